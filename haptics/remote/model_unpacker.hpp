#pragma once
// A local model from what another computer sent of it: everything that can be built from the body's surface is built
// here.
#include <functional>
#include <optional>

#include "haptics/body/body.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/remote/remote_cells.hpp"
#include "haptics/remote/sent_model.hpp"
#include "haptics/tick/haptic_method.hpp"

namespace kt {

class ModelUnpacker {
 public:
  /// The body with another material.
  using MakeLike = std::function<std::unique_ptr<DeformableModel>(const LiveMaterial&)>;
  /// @param model, surface  of the body, borrowed. Throws InputError for options that no link can carry: see
  ///                        require_sendable().
  /// @param make_like       none: models of another material have trouble
  ModelUnpacker(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                MakeLike make_like = {});
  ModelUnpacker(const Body& body, const TouchOptions& options);

  /// What is wrong with it: sizes that disagree, an index out of range, a number that is none, mass that is not
  /// positive, stiffness or damping that is negative. Empty: nothing.
  std::string trouble(const SentModel& sent) const;

  /// Of the whole body [m], (3n). Of one that has no trouble.
  VectorX positions_of(const SentModel& sent) const;

  /// As the refresh made it, but for what rounding took: contact response within 1e-4 at 16 bits. Of one that has no
  /// trouble; throws RunError where its step matrix is not positive definite, or refined cells do not fit the body.
  /// What these have yielded by is zero: see YieldMemory.
  std::unique_ptr<PreparedLocalModel> unpack(const SentModel& sent);

 private:
  std::shared_ptr<const FinePatch> refine(const SentModel& sent);
  Smoothing smoothing_of(const SentModel& sent) const;
  const DeformableModel& model_;
  const Surface& surface_;
  TouchOptions options_;
  Metric metric_;
  std::unique_ptr<HapticMethod> method_;
  std::optional<Friction> friction_of_;
  std::shared_ptr<const SurfaceFriction> friction_;
  MakeLike make_like_;
  std::optional<LiveMaterial> material_;   // of what follows
  std::unique_ptr<DeformableModel> like_;  // none: model_
  std::optional<RemoteCells> cells_;
};

/// Throws InputError: methods and laws that need the refresh's own maps cannot be on two computers.
void require_sendable(const TouchOptions& options);

}  // namespace kt
