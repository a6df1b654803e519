#include "haptics/predict/predict_hand.hpp"

#include "haptics/predict/contact_stiffness.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {
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
