#pragma once
// Coulomb friction in its own right, to judge the engine's solvers: velocities and impulses of c contacts, stacked.
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Nearest point of the second-order cone |p_t| <= mu p_m around m.
Vec3 project_to_cone(const Vec3& p, const Vec3& m, double mu);

/// How far p is from a solution: || p - K(p - r (u + mu |u_t| m)) || / (|| p || + r || b ||) with u = W p + b, K the
/// projection on all friction cones and r about 1 / || W || (De Saxce 1998). Zero exactly at solutions.
/// @param normal  per contact, from the body towards the tool
double coulomb_residual(const MatrixX& W, const VectorX& b, const std::vector<Vec3>& normal, double mu,
                        const VectorX& p);

/// Solution by the fixed-point iteration of that map from zero: slow and simple.
VectorX project_iterate(const MatrixX& W, const VectorX& b, const std::vector<Vec3>& normal, double mu, int steps);

/// Solution by a method of another kind: with the sliding speeds s held, friction is a convex problem,
///   min 1/2 p.W p + p.(b + mu s m) over the product of the cones,
/// solved by accelerated projected gradients; s is then the speed found, until it stays (Acary, Cadoux and Lemarechal
/// 2011). No contact is ever solved by itself, no direction of sliding is looked for.
/// @param mu  per contact
struct ConvexSolution {
  VectorX p;
  double change = 0;  ///< of the speeds in the last round, relative to the largest velocity in b
};
ConvexSolution solve_by_convex_rounds(const MatrixX& W, const VectorX& b, const std::vector<Vec3>& normal,
                                      const std::vector<double>& mu, int rounds = 200);

}  // namespace kt
