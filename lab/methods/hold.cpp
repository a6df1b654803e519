// The practice of the 1990s: the force is computed once per global step, with the tool's pose then, and held until the
// next one arrives. The kindest form: the body is followed by the engine's own local simulation underneath, so the held
// force is right for the moment it was computed for; only the holding is wrong.
#include <cmath>
#include <vector>

#include "core/base/ticks.hpp"
#include "haptics/tick/local_simulation.hpp"

namespace kt {
namespace {

class Hold final : public HapticMethod {
 public:
  explicit Hold(const HapticMethodOptions& options)
      : body_(options.tools[0], options.h,
              make_contact_solver(options.law, options.friction, options.friction_of_triangle)),
        past_(static_cast<std::size_t>(ticks_in(kRemembered, 1 / options.h, 1024, 1 << 18))) {}

  std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> next) noexcept override {
    held_ = at_time(next->model.t);
    return body_.adopt(std::move(next));
  }

  LocalFrame step(const ToolSweep& sweep) noexcept override {
    LocalFrame frame = body_.step(sweep);
    past_[static_cast<std::size_t>(++ticks_) % past_.size()] = frame;
    frame.force = held_.force;
    frame.f_n = held_.f_n;
    frame.f_t = held_.f_t;
    frame.normal = held_.normal;
    frame.point = held_.point;
    frame.torque = held_.torque;
    frame.cone_ratio = held_.cone_ratio;
    frame.mode = held_.mode;
    return frame;
  }

  std::span<const TickContact> samples() const noexcept override { return body_.samples(); }
  const PreparedLocalModel& model() const noexcept override { return body_.model(); }
  double h() const noexcept override { return body_.h(); }
  const ToolShape& tool() const noexcept override { return body_.tool(); }

 private:
  static constexpr double kRemembered = 1.024;  // [s]: a model that was on its way for longer gets the oldest

  /// The frame that ended at time t: a model linearized then was linearized at that pose of the tool.
  LocalFrame at_time(double t) const noexcept {
    const long long wanted = std::llround(t / body_.h());
    const auto kept = static_cast<long long>(past_.size());
    return past_[static_cast<std::size_t>(std::clamp(wanted, std::max(0LL, ticks_ - kept + 1), ticks_) % kept)];
  }

  LocalSimulation body_;
  std::vector<LocalFrame> past_;  // ring; [0] is the free frame before the first tick
  long long ticks_ = 0;
  LocalFrame held_;
};

}  // namespace

std::unique_ptr<HapticMethod> make_hold_method(const HapticMethodOptions& options) {
  return std::make_unique<Hold>(options);
}

}  // namespace kt
