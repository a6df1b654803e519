// A device that somebody holds, driven by a program of its own: every force goes through the engine's safety chain.
#include <chrono>
#include <cstdio>
#include <kilotouch/kilotouch.hpp>
#include <thread>

/// Stands for a driver: here a stylus that is lowered into the body, and that is unplugged at the end.
class MyDevice {
 public:
  bool read(kt::Pose& pose, kt::DeviceState& state) {  // false: it did not answer
    const double t = 1e-3 * ++tick_;
    if (tick_ > 1200) return false;
    pose = {{0.02, 0.026, 0.027 - 0.009 * std::min(1.0, 3 * t)}, kt::Quaternion::Identity()};
    state.buttons = 1;  // its first button is held
    return true;
  }
  void write(const kt::Vec3& force) { last_ = force.norm(), most_ = std::max(most_, last_); }
  double most() const { return most_; }
  double last() const { return last_; }

 private:
  int tick_ = 0;
  double last_ = 0, most_ = 0;
};

int main() {
  kt::BodyOptions made;
  made.object.mesh = "meshes/block.msh";
  const kt::Body body(made);
  kt::TouchOptions options;
  options.tools[0].shape = kt::make_capsule(0.003, 0.01);
  kt::Touch touch(body, options);

  // What is known of the device, and what it may be given. Let go when its first button is.
  const kt::DeviceInfo info{.max_force = 7.9, .delay = 1e-3, .yields = true, .is_live = true};
  kt::SafetyChain chain({.device = info, .most_damping = 5, .max_force = 2.0, .deadman = 1});

  MyDevice device;
  kt::Pose pose;
  kt::DeviceState state;
  device.read(pose, state);
  touch.place(pose);
  touch.start();
  auto due = std::chrono::steady_clock::now(), before = due, read = due;
  for (int i = 0; i < 1300; ++i) {
    std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
    const auto now = std::chrono::steady_clock::now();
    if (device.read(pose, state)) read = now;
    state.age = std::chrono::duration<double>(now - read).count();  // an old pose shuts the gate: zero within 20 ms
    const double dt = std::max(1e-9, std::chrono::duration<double>(now - before).count());
    kt::LocalFrame frame = touch.tick(chain.tool(pose, dt));
    device.write(chain.make_safe(frame, pose, state, dt).force);
    before = now;
  }
  touch.stop();
  device.write(kt::Vec3::Zero());  // on every way out; a real driver goes on with it for 50 ms
  std::printf("at most %.3f N; at the end %.3f N, as %s\n", device.most(), device.last(), name_of(chain.reason()));
}
