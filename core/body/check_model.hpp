#pragma once
// Whether a body's physics keeps what the engine relies on: for models of one's own, in one's own tests.
#include <string>
#include <vector>

#include "core/body/deformable_model.hpp"

namespace kt {

/// kept; told: allowed, but worth knowing; broken: forces will be wrong, or steps fail.
enum class ModelVerdict { kept, told, broken };

/// One thing that a model has to keep, as it was found.
struct ModelFinding {
  std::string name;  ///< "tangent of positions", say
  ModelVerdict verdict = ModelVerdict::kept;
  double value = 0, allowed = 0;  ///< measured; at most
  std::string meaning;            ///< what a larger value says
};

struct ModelCheck {
  std::vector<ModelFinding> findings;
  bool passed() const;  ///< nothing is broken
  /// One line a finding: "ok", "note" or "WRONG", its name, what was measured, what is allowed, what it says.
  std::string text() const;
};

struct ModelCheckOptions {
  double strain = 0.02;    ///< nodes are moved at random by up to this share of their shortest edge
  double speed = 0.1;      ///< nodes have random speeds of up to this many shortest edges in a second
  double accuracy = 1e-5;  ///< of derivatives and balances, over their size
  bool anchored = false;   ///< tied to something outside by forces: may depend on where it is, and keeps no momentum
  unsigned seed = 1;
};

/// Tries the model at rest and in states that move and are deformed at random:
/// - sizes, finite numbers, a symmetric positive definite mass, fixed nodes in range and ascending, equal bits twice;
/// - the exact tangent against differences of the force along random motions, also of a squeezed body; the symmetric
/// one
///   has its symmetric part; the definite one is symmetric and definite (to 1e-8 of its largest diagonal entry);
/// - forces that do not depend on where the body is, and whose sum does not depend on its shape (unless `anchored`);
/// - springs that give back what was put in (a symmetric exact tangent of a body that does not move), dampers that
/// take;
/// - told: forces that do not turn with the body, as those of a linear material;
/// - free_share() in [0, 1].
/// Costs some ten tangents and four factorizations. Where sizes are wrong nothing further is tried. What the model
/// throws is passed on.
ModelCheck check_model(const DeformableModel& model, const ModelCheckOptions& options = {});

}  // namespace kt
