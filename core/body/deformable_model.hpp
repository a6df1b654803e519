#pragma once
// The one interface between a body's physics and everything else, M a = f(x, v).            Paper eqs. (1)-(2).
#include <map>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// `exact` is the derivative of force(), and may be indefinite under compression. `symmetric` is the same where only
/// the symmetric part of dfdx is wanted. A model may leave the rest out, to be faster. `definite` has -dfdx and -dfdv
/// positive semidefinite (geometric stiffness clamped), for implicit solvers and as the passive fallback of a local
/// model.
enum class TangentKind { exact, symmetric, definite };

struct Tangent {
  SparseMatrix dfdx, dfdv;  ///< [N/m], [N s/m], (3n x 3n), symmetric pattern
};

/// A model's description of itself in summaries.
struct ModelInfo {
  std::string type, material;
  std::map<std::string, double> parameters;  ///< SI, by name
};

/// Physics of one body, const while stepping. State is a value apart. Fixed nodes keep their position. Integrators and
/// reducers leave them out, force() and update_tangent() need not know them. A model of one's own needs the first four
/// functions. check_model() names its faults.
class DeformableModel {
 public:
  virtual ~DeformableModel() = default;
  virtual const Mesh& mesh() const = 0;
  virtual const SparseMatrix& mass() const = 0;  ///< [kg], (3n x 3n), symmetric positive definite
  /// Ascending, the vertices of an embedded surface among them, see still_nodes().
  virtual const std::vector<int>& fixed_nodes() const = 0;
  /// Internal and body forces [N], (3n).
  virtual void force(const State& state, VectorX& out) const = 0;
  /// `out` is empty, or an earlier tangent of this model, whose storage is used again. Self-contact changes the
  /// pattern. The default takes differences of force(), 300 to 600 calls of it a tangent, see difference_tangent().
  virtual void update_tangent(const State& state, TangentKind kind, Tangent& out) const;
  virtual ModelInfo info() const { return {"own", "", {}}; }
  /// Share in [0, 1] of the motion from x to x + dx, (3n), that the body can make, 1 unless its surface meets itself.
  /// Newton's method asks before each motion, and evaluates forces on the way only.
  virtual double free_share(const VectorX& /*x*/, const VectorX& /*dx*/) const { return 1; }

  /// The model of the mesh's own nodes, itself unless a surface is embedded in its cells.
  virtual const DeformableModel& own() const { return *this; }

  /// The model whose tangent, with added_stiffness(), is this one's, itself as a rule, which adds nothing. A model
  /// that adds a few springs to another one gives that other, whose tangent at the same state need not be made again.
  virtual const DeformableModel& base() const { return *this; }
  /// Entries of dfdx [N/m], symmetric, that this model adds to those of base(). Appended to `out`.
  virtual void added_stiffness(std::vector<Eigen::Triplet<double>>& /*out*/) const {}

  Tangent tangent(const State& state, TangentKind kind) const {
    Tangent out;
    update_tangent(state, kind, out);
    return out;
  }
};

/// The part of the mesh's own nodes, all of it where no surface is embedded.
State own_part(const DeformableModel& model, const State& state);

/// Nodes that do not move, ascending, the fixed ones and the vertices of an embedded surface between such.
std::vector<int> still_nodes(const DeformableModel& model);

/// The undeformed body at rest at t = 0.
inline State rest_state(const DeformableModel& model) {
  return {0, model.mesh().x, VectorX::Zero(model.mesh().x.size())};
}

}  // namespace kt
