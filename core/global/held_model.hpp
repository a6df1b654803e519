#pragma once
// A body whose touched points are held where the tool left them: how the global side catches up with a contact.
//
// The local model is stiffer than the body (the wall, thirty times in the worst case), so its force history alone would
// push the body past the tool by that factor, and low global rates would swing. Where the contact point ended is known
// exactly, from the tool; so the normal force of the catch-up follows from it, and only friction from the history.
#include <memory>
#include <span>

#include "core/body/node_weights.hpp"
#include "core/body/wrapping_model.hpp"

namespace kt {

/// One contact at the end of a refresh interval.
struct ContactHold {
  NodeWeights moves{};           ///< the nodes that move the contact point
  Vec3 normal = Vec3::Zero();    ///< unit, from the body towards the tool
  Vec3 point = Vec3::Zero();     ///< where the contact point is [m]
  bool sticks = false;           ///< held in all directions; else along the normal only
  double force = 0;              ///< normal force that the local model had there [N]
  Vec3 friction = Vec3::Zero();  ///< its tangential force on the body [N]; of what does not stick
  Mat3 yields = Mat3::Zero();    ///< how far the point gives way in series with these nodes [m/N]
};

/// The model with a stiff spring at each hold. Borrows the model; same pattern of the tangent where the nodes of each
/// hold are coupled anyway, as those of a triangle.
class HeldModel final : public WrappingModel {
 public:
  /// @param stiffness  of each spring [N/m], > 0
  HeldModel(const DeformableModel& model, std::span<const ContactHold> holds, double stiffness);
  void force(const State& state, VectorX& out) const override;
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override;
  const DeformableModel& base() const override { return model_; }
  void added_stiffness(std::vector<Eigen::Triplet<double>>& out) const override;

  /// Sum over the holds of the normal force that they push the body with at x [N]; negative: they pull.
  double push(const VectorX& x) const;

 private:
  Mat3 spring(const ContactHold& hold) const;
  std::span<const ContactHold> holds_;
  double stiffness_;
};

}  // namespace kt
