#include "core/base/error.hpp"
#include "haptics/predict/predict_hand.hpp"

namespace kt {

std::optional<Prediction> predict_limit_cycle(const HandLoop& loop, double most_damping) {
  // Near its limit a loop swings for as long as anybody looks.
  constexpr double kMargin = 1.08;
  // What passivity control adds comes late, and only while the loop gives energy: measured, a third of it counts.
  constexpr double kCounts = 1.0 / 3;
  HandLoop stiffer = loop;
  stiffer.wall_stiffness *= kMargin;
  stiffer.wall_damping *= kMargin;
  if (loop_growth(stiffer) < 1) return {};
  if (most_damping > 0 && passive_damping(loop) <= loop.hand_damping + kCounts * most_damping) return {};
  return Prediction{"hand", text("tool.path.hand: a limit cycle, the contact's ", loop.wall_stiffness,
                                 " N/m are too stiff for a device that damps ", loop.hand_damping, " N.s/m at ",
                                 1 / loop.h, " Hz and ", 1e3 * loop.delay, " ms of delay: at most ",
                                 stiffest_stable_wall(loop), " N/m; raise tool.path.hand.damping to ",
                                 passive_damping(loop), ", or local.rate_hz, or set local.passivity_damping")};
}

}  // namespace kt
