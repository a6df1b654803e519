#pragma once
// Tests of a body's physics for the properties that the engine relies on, for models of one's own, in one's own tests.
#include <string>
#include <vector>

#include "core/body/deformable_model.hpp"

namespace kt {

/// kept. told, allowed but worth knowing. broken, forces will be wrong or steps fail.
enum class ModelVerdict { kept, told, broken };

/// One thing that a model has to keep, as it was found.
struct ModelFinding {
  std::string name;  ///< "tangent of positions", say
  ModelVerdict verdict = ModelVerdict::kept;
  double value = 0, allowed = 0;  ///< measured value, and its limit
  std::string meaning;            ///< meaning of a larger value
};

struct ModelCheck {
  std::vector<ModelFinding> findings;
  bool passed() const;  ///< nothing is broken
  /// One line a finding, with "ok", "note" or "WRONG", its name, the measured and the allowed value, its meaning.
  std::string text() const;
};

struct ModelCheckOptions {
  double strain = 0.02;    ///< nodes are moved at random by up to this share of their shortest edge
  double speed = 0.1;      ///< nodes have random speeds of up to this many shortest edges in a second
  double accuracy = 1e-5;  ///< allowed error of derivatives and balances, over their size
  bool anchored = false;   ///< tied to something outside by forces, may depend on its place, and keeps no momentum
  unsigned seed = 1;
};

/// Tries the model at rest and in states that move and are deformed at random.
/// - sizes, finite numbers, a symmetric positive definite mass, fixed nodes in range and ascending, equal bits twice.
/// - the exact tangent against differences of the force along random motions, also of a squeezed body. The symmetric
/// one
///   has its symmetric part, the definite one is symmetric and definite (to 1e-8 of its largest diagonal entry).
/// - forces that do not depend on the body's place, and a sum of them that does not depend on its shape (unless
/// `anchored`).
/// - springs that conserve energy (a symmetric exact tangent of a body that does not move), dampers that dissipate it.
/// - forces that turn with the body. Others are told, as those of a linear material.
/// - free_share() in [0, 1].
///
/// Costs some ten tangents and four factorizations. Where sizes are wrong nothing further is tried. Exceptions of the
/// model are passed on.
ModelCheck check_model(const DeformableModel& model, const ModelCheckOptions& options = {});

}  // namespace kt
