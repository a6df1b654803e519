// One's own device and one's own 1 kHz loop; the body in a thread of the engine.
#include <chrono>
#include <cstdio>
#include <kilotouch/kilotouch.hpp>
#include <thread>

/// Stands for a driver: a stylus that is lowered, drawn sideways and turned. A real one has both functions, too.
class MyDevice {
 public:
  bool read(kt::Pose& out) {
    const double t = 1e-3 * ++tick_, down = std::min(1.0, t / 0.2), along = 0.04 * std::max(0.0, t - 0.25);
    out = {{0.02 + along, 0.026, 0.027 - 0.005 * down}, kt::Quaternion(Eigen::AngleAxisd(t, kt::Vec3::UnitX()))};
    return tick_ <= 1000;
  }
  void write(const kt::Vec3& force, const kt::Vec3& torque) { most_ = std::max(most_, force.norm() + torque.norm()); }
  double most() const { return most_; }

 private:
  int tick_ = 0;
  double most_ = 0;
};

int main() {
  kt::BodyOptions made;
  made.object.mesh = "meshes/block.msh";
  const kt::Body body(made);
  kt::TouchOptions options;
  options.tools[0].shape = kt::make_capsule(0.003, 0.01);
  kt::Touch touch(body, options);

  MyDevice device;
  kt::Pose pose;
  device.read(pose);
  touch.place(pose);
  touch.start();  // the body's own thread, 30 Hz
  auto due = std::chrono::steady_clock::now();
  while (device.read(pose)) {
    std::this_thread::sleep_until(due += std::chrono::milliseconds(1));  // your servo loop's clock
    const kt::LocalFrame& f = touch.tick(pose);                          // no allocation, lock or clock
    if (touch.next_tick() == 500) touch.set("contact.mu", 0.2);          // a slider, from any thread
    if (f.flags & kt::kStaleModel) std::puts("the body does not keep up");
    device.write(f.force, f.torque);  // finite; limits are your device's
  }
  touch.stop();
  std::printf("%d refreshes, at most %.3f N\n", touch.status().refreshes, device.most());
}
