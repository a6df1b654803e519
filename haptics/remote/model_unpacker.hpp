#pragma once
// A local model from what another computer sent of it: everything that can be built from the body's surface is built
// here.
#include "core/body/deformable_model.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/remote/sent_model.hpp"
#include "haptics/tick/haptic_method.hpp"

namespace kt {

class ModelUnpacker {
 public:
  /// @param model, surface  of the body, borrowed. Throws InputError for options that no link can carry: see
  ///                        require_sendable().
  ModelUnpacker(const DeformableModel& model, const Surface& surface, const TouchOptions& options);

  /// What is wrong with it: sizes that disagree, an index out of range, a number that is none, mass that is not
  /// positive, stiffness or damping that is negative. Empty: nothing.
  std::string trouble(const SentModel& sent) const;

  /// As the refresh made it, but for what rounding took: contact response within 1e-4 at 16 bits. Of one that has no
  /// trouble; throws RunError where its step matrix is not positive definite.
  std::unique_ptr<PreparedLocalModel> unpack(const SentModel& sent);

 private:
  const DeformableModel& model_;
  const Surface& surface_;
  TouchOptions options_;
  Smoothing smoothing_;
  Metric metric_;
  std::unique_ptr<HapticMethod> method_;
  std::optional<Friction> friction_of_;
  std::shared_ptr<const SurfaceFriction> friction_;
};

/// Throws InputError: methods and laws that need the refresh's own maps cannot be on two computers.
void require_sendable(const TouchOptions& options);

}  // namespace kt
