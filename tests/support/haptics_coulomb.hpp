#pragma once
// Coulomb friction in its own right, to judge the engine's solvers: velocities and impulses of c contacts, stacked.
#include <vector>

#include "core/types.hpp"

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

}  // namespace kt
