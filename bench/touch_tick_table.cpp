// What a tick of the engine costs above the bare tick of its method: the same drag, tick by tick, by a Touch in
// lockstep and by the method alone, in turns on one thread. CPU time of that thread, ticks in contact; refreshes are
// not part of it. `differ`: mean difference of the two forces over the mean force, to see that both do the same work.
//   build/release/bench/touch_tick_table [SCENE...]
#include <cstdio>

#include "core/base/cpu_time.hpp"
#include "core/base/percentile.hpp"
#include "haptics/halves/body_side.hpp"
#include "haptics/session/session.hpp"
#include "haptics/tick/catch_up.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "tests/support/allocations.hpp"

namespace kt {
namespace {

constexpr int kRunIn = 4;  // ticks, as in haptics/touch/lockstep_link.cpp

/// The method with the body's half, by hand.
class BareTick {
 public:
  explicit BareTick(const Session& session)
      : refresher_(session.model(), session.surface(), session.options(), session.start()),
        method_(make_method(session.options(), session.friction())),
        catch_up_(session.tools(), tick_length(session.options()),
                  catch_up_solver(session.options(), session.friction())),
        motion_(make_local_motion(session.model().mesh().num_nodes())),
        every_(ticks_per_refresh(session.options())) {}

  /// As the lockstep link: a new model starts from the motion of some ticks ago and is stepped to the present.
  template <class PoseAt>
  void refresh(int tick, const PoseAt& pose) {
    const bool goes_on = tick > 0;
    if (goes_on && !has_start_) record_motion(method_->model(), tick, motion_);
    const Pose at = pose(tick);
    auto model = refresher_.refresh(tick * method_->h(), {&at, 1}, reports_, goes_on ? &motion_ : nullptr);
    for (int i = goes_on ? motion_.tick : tick; i < tick; ++i) {
      const ToolSweep sweep(pose(i), pose(i + 1));
      catch_up_.step(*model, {&sweep, 1});
    }
    model->caught_up = true;
    method_->adopt(std::move(model));
    reports_.clear();
    start_ = std::max(tick + 1, tick + refresher_.next_interval(every_) - kRunIn);
    has_start_ = false;
  }
  void before_tick(int tick) {
    if (tick != start_) return;
    record_motion(method_->model(), tick, motion_);
    has_start_ = true;
  }
  void step(const ToolSweep& sweep, LocalFrame& frame) noexcept { method_->step_tools({&sweep, 1}, {&frame, 1}); }
  void report(int tick, const Pose& pose, const LocalFrame& frame) {
    LocalReport& out = reports_.emplace_back();
    out.tick = tick;
    out.model_frame = method_->model().model.frame;
    for (const TickContact& c : method_->samples()) out.samples[out.count++] = c;
    out.tools[0] = {pose, out.count > 0 ? frame.triangle : -1, frame.mode == ContactMode::frictional_slide};
    out.left_patch = (frame.flags & kLeftPatch) != 0;
  }

 private:
  Refresher refresher_;
  std::unique_ptr<HapticMethod> method_;
  CatchUp catch_up_;
  LocalMotion motion_;
  int every_, start_ = -1;
  bool has_start_ = false;
  std::vector<LocalReport> reports_;
};

void run(const std::string& file) {
  Scene scene = load_scene(file);
  scene.link = LinkSettings();
  const Session session(scene);
  Touch touch(session.body(), session.options());
  BareTick bare(session);
  const auto pose = [&](int tick) { return Pose{interpolate_path(session.path(), tick * touch.h())}; };
  touch.place(pose(0));
  std::vector<double> engine_us, bare_us, above_us;
  int refreshes = 0;
  double difference = 0, force = 0;
  long long allocations = 0;
  const int ticks = static_cast<int>(scene.duration / touch.h());
  for (int i = 0; i < ticks; ++i) {
    const Pose from = pose(i), to = pose(i + 1);
    TouchHalves::refresh_if_due(touch);
    if (const int now = touch.status().refreshes; now > refreshes) {
      bare.refresh(i, pose);
      refreshes = now;
    }
    bare.before_tick(i);
    LocalFrame own, engines;
    double engine = 0, alone = 0;
    const auto time_engine = [&] {
      allocations += allocations_during([&] {
        const double start = thread_time_us();
        engines = touch.tick(to);
        engine = thread_time_us() - start;
      });
    };
    const auto time_bare = [&] {
      const double start = thread_time_us();
      bare.step({from, to}, own);
      alone = thread_time_us() - start;
    };
    if (i % 2 == 0) time_engine();
    time_bare();
    if (i % 2 == 1) time_engine();
    bare.report(i, to, own);
    difference += (own.force - engines.force).norm();
    force += engines.force.norm();
    if (own.mode == ContactMode::free) continue;
    engine_us.push_back(engine);
    bare_us.push_back(alone);
    above_us.push_back(engine - alone);
  }
  const std::string name = file.substr(file.find_last_of('/') + 1);
  std::printf("%-20s %6zu %8.2f %8.2f %8.2f %8.2f %8.2f %8.2f %6lld %6.2f%%\n", name.c_str(), engine_us.size(),
              percentile(engine_us, 0.5), percentile(engine_us, 0.9), percentile(bare_us, 0.5),
              percentile(bare_us, 0.9), percentile(above_us, 0.5), percentile(above_us, 0.9), allocations,
              100 * difference / force);
  std::fflush(stdout);
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  std::vector<std::string> files(argv + 1, argv + argc);
  if (files.empty())
    for (const char* scene : {"slab_drag", "organ_drag"})
      files.push_back(kt::text(KT_SOURCE_DIR "/scenes/", scene, ".json"));
  std::printf("%-20s %6s %8s %8s %8s %8s %8s %8s %6s %6s\n", "scene, us", "ticks", "engine", "p90", "bare", "p90",
              "above", "p90", "allocs", "differ");
  for (const std::string& file : files) kt::run(file);
}
