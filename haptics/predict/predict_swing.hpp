#pragma once
// A body that gives way to the tool by swinging as a whole: implicit steps as long as a refresh interval damp the
// swing, and with it the force that goes up and down, far more than the body does.
#include <optional>

#include "core/body/deformable_model.hpp"

namespace kt {

/// The vibration that a steady push at one place of the body starts most of.
struct BodySwing {
  double omega = 0;  ///< [rad/s]
  double zeta = 0;   ///< damping ratio of the body's own damping [-]
  double share = 0;  ///< of how far the pushed place gives way at rest, what is this vibration's [-], 0..1
};

/// At `state`, of the slowest vibration that `push` starts: inverse iteration from the static answer. None when the
/// body is not clamped, too large (kSwingNodes) or its definite stiffness cannot be solved with.
/// @param push  forces [N], (3n); fixed nodes do not count
std::optional<BodySwing> find_swing(const DeformableModel& model, const State& state, const VectorX& push);

constexpr int kSwingNodes = 20000;  ///< four solutions with their stiffness take a second

/// Damping ratio that steps of backward Euler alone give a vibration: of exp(-zeta omega t), the amplitude and phase of
/// one step 1 / (1 - i omega dt).
/// @param dt  [s]
double backward_euler_damping(double omega, double dt);

}  // namespace kt
