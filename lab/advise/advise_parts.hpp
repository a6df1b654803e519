#pragma once
// What the parts of an advice share: the clock, and the scene made the same for every body and method.
#include <algorithm>
#include <chrono>

#include "lab/advise/advise.hpp"
#include "lab/study/press.hpp"
#include "lab/study/reference.hpp"

namespace kt {

/// The budget's clock.
class AdviceClock {
 public:
  explicit AdviceClock(const AdviseOptions& options) : options_(options) {}
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  /// Of a share of the budget [s]; negative: overdrawn.
  double left(double share = 1) const { return share * options_.budget_seconds - seconds(); }
  /// The user wants the end, or that share is spent. Shows the progress: ask often.
  bool is_over(double share = 1) const {
    if (options_.progress) options_.progress(std::clamp(seconds() / options_.budget_seconds, 0.0, 0.99));
    return stopped() || left(share) < 0;
  }
  bool stopped() const { return options_.stop && options_.stop->load(); }

 private:
  const AdviseOptions& options_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A callback for long runs that sets `over` when that share of the budget is spent.
inline std::function<void(double)> watch(const AdviceClock& clock, double share, std::atomic<bool>& over) {
  return [&clock, share, &over](double) {
    if (clock.is_over(share)) over = true;
  };
}

/// Of one core, that this process had while it worked: the machine may be shared.
double share_of_core(const std::function<void()>& work);

constexpr double kRates[] = {10, 30, 60};  ///< that are tried [Hz], ascending

/// The scene with its tool path written out, from the first touch on.
struct AdviceScene {
  Scene scene;
  Mesh mesh = {};             ///< its own, in metres
  PosePath tool = {};         ///< at the ends of the ticks, before them the start
  PressSite site = {};        ///< where the tool presses hardest
  bool from_surface = false;  ///< other meshes can be made for it
  bool may_refine = false;    ///< cells under the tool, by what the scene says
};

/// The scene with another model (msd, tet4, tet10) and mesh, its cells refined under the tool or as they are.
Scene with_body(Scene scene, const AdviceBody& body);

/// The scene at that rate, with that reducer, repeatable.
Scene row_scene(const Scene& scene, double rate_hz, const std::string& reducer);

/// Fills truth and bodies. Ends at `share` of the budget.
void press_bodies(const AdviceScene& scene, const AdviceClock& clock, double share, Advice& out);

/// Appends the rows of one body.
void measure_rates(const AdviceScene& scene, int body, const AdviceClock& clock, Advice& out);

}  // namespace kt
