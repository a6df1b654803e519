#include "haptics/predict/predict_hand.hpp"

#include <algorithm>

#include "core/base/error.hpp"
#include "haptics/cells/contact_stiffness.hpp"
#include "haptics/safety/device_coupling.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {

std::optional<Prediction> predict_limit_cycle(const HandLoop& loop, double most_damping) {
  return predict_limit_cycle(loop, HandPort{.most_damping = most_damping, .delay = loop.delay});
}

std::optional<Prediction> predict_limit_cycle(const HandLoop& loop, const HandPort& port) {
  // Near its limit a loop swings for as long as anybody looks.
  constexpr double kMargin = 1.08;
  // What passivity control adds comes late, and only while the loop gives energy: measured, a third of it counts.
  constexpr double kCounts = 1.0 / 3;
  // A coupling that swings lets go of the wall, which is not stiff then: measured, up to so much more is held.
  constexpr double kLetsGo = 1.4;
  const bool coupled = port.coupling > 0;
  if (coupled && port.adapts) return {};  // how soft it gets nobody knows before
  HandLoop felt = loop;
  felt.wall_stiffness = felt_stiffness(loop.wall_stiffness, port.coupling);
  if (port.bounded_damping > 0)
    felt.wall_stiffness =
        std::min(felt.wall_stiffness, kCouplingShare * port.bounded_damping / (0.5 * loop.h + port.delay));
  HandLoop stiffer = felt;
  stiffer.wall_stiffness *= coupled ? 1 / kLetsGo : kMargin;
  stiffer.wall_damping *= coupled ? 1 / kLetsGo : kMargin;
  if (loop_growth(stiffer) < 1) return {};
  if (port.most_damping > 0) {
    // It takes back what a force gives that acts when it is said to: the rest of the delay is the device's.
    const double untold = felt.wall_stiffness * std::max(0.0, loop.delay - port.delay);
    const bool told = untold <= (coupled ? kLetsGo : 1 / kMargin) * loop.hand_damping;
    if (told && passive_damping(felt) <= loop.hand_damping + kCounts * port.most_damping) return {};
  }
  const std::string damping = short_number(passive_damping(loop));
  return Prediction{
      "hand", Finding{told("tool.path.hand: a limit cycle, the contact's ", loop.wall_stiffness,
                           " N/m are too stiff for a device that damps ", loop.hand_damping, " N.s/m at ", 1 / loop.h,
                           " Hz and ", 1e3 * loop.delay, " ms of delay: at most ", stiffest_stable_wall(loop), " N/m"),
                      {{"tool.path.hand.damping", damping, told("raise tool.path.hand.damping to ", damping)},
                       advise("raise local.rate_hz"),
                       advise(port.most_damping > 0 ? "raise local.passivity_damping" : "set local.passivity_damping")}}
                  .at("tool.path.hand", loop.wall_stiffness, stiffest_stable_wall(loop))};
}

void predict_hand(const BuiltScene& built, std::vector<Prediction>& out) {
  const Scene& scene = built.scene();
  if (!scene.tool.path.hand) return;
  const auto contact = contact_stiffness(built);
  if (!contact) return;
  const SceneHand& hand = *scene.tool.path.hand;
  HandLoop loop;
  loop.mass = hand.mass;
  loop.hand_stiffness = hand.stiffness;
  loop.hand_damping = hand.damping;
  loop.h = 1 / scene.local.rate_hz;
  loop.delay = 1e-3 * hand.delay_ms;
  loop.wall_stiffness = contact->stiffness;
  loop.wall_damping = contact->damping;
  if (auto p = predict_limit_cycle(loop, scene.local.passivity_damping)) out.push_back(std::move(*p));
}

}  // namespace kt
