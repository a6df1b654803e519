#include "core/local/far_motions.hpp"

#include <Eigen/Eigenvalues>

namespace kt {
namespace {

using FarArray = Eigen::Array<double, 1, kFarEach>;

constexpr double kLongest = 10;       // step, of what a perfect preconditioner would ask for: a body about to give way
                                      // would have none
constexpr double kDependent = 1e-10;  // squared length, of what is left of a motion without the others

FarArray dot(const FarRows& a, const FarRows& b) { return (a.array() * b.array()).colwise().sum(); }

/// @param image  K motions
void descend(FarRows& motions, const FarRows& loads, const FarRows& image, const FarOperators& body, int steps) {
  FarRows residual = loads - image, direction = body.precondition(residual), product;
  FarArray rz = dot(residual, direction);
  for (int step = 0;; ++step) {
    body.stiffness(direction, product);
    const FarArray curvature = dot(direction, product);
    // A load that is answered already, or a tangent that is not definite: that motion stays as it is.
    const FarArray length = (curvature > 0 && rz > 0).select((rz / curvature).min(kLongest), 0.0);
    motions.array() += direction.array().rowwise() * length;
    if (step + 1 == steps) return;
    residual.array() -= product.array().rowwise() * length;
    const FarRows z = body.precondition(residual);
    const FarArray rz_new = dot(residual, z);
    const FarArray keep = (rz > 0).select(rz_new / rz, 0.0);
    direction = (z.array() + direction.array().rowwise() * keep).matrix();
    rz = rz_new;
  }
}

}  // namespace

FarRows smooth_loads(const FreeDofs& dofs, const VectorX& x, const SurfacePatch& patch) {
  Vec3 middle = Vec3::Zero();
  for (int i : patch.global_node) middle += node(x, i) / patch.num_vertices();
  FarRows out = FarRows::Zero(dofs.size(), kFarEach);
  for (int i : patch.global_node) {
    const int k = dofs.to_free[3 * i];
    if (k < 0) continue;
    const Vec3 arm = node(x, i) - middle;
    for (int c = 0; c < 3; ++c) {
      out(k + c, c) = 1;
      for (int axis = 0; axis < 3; ++axis) out(k + c, 3 + 3 * axis + c) = arm[axis];
    }
  }
  return out;
}

FarRows even_motions(const FreeDofs& dofs, const VectorX& x) {
  Vec3 middle = Vec3::Zero();
  for (int k = 0; k < dofs.size(); k += 3) middle += 3 * node(x, dofs.to_all[k] / 3) / dofs.size();
  FarRows out = FarRows::Zero(dofs.size(), kFarEach);
  for (int k = 0; k < dofs.size(); k += 3) {
    const Vec3 arm = node(x, dofs.to_all[k] / 3) - middle;
    out.block<3, 3>(k, 0).setIdentity();
    for (int axis = 0; axis < 3; ++axis) out.block<3, 3>(k, 3 + 3 * axis) = arm[axis] * Mat3::Identity();
  }
  return out;
}

bool improve_yielding(FarRows& motions, const FarRows& loads, const FarOperators& body, int steps) {
  FarRows image;
  body.stiffness(motions, image);
  descend(motions, loads, image, body, steps);
  return motions.allFinite();
}

bool improve_vibrations(FarRows& motions, const FarOperators& body, int steps) {
  using Square = Eigen::Matrix<double, kFarEach, kFarEach>;
  using Column = Eigen::Vector<double, kFarEach>;
  FarRows image, inertia;
  body.stiffness(motions, image);
  body.mass(motions, inertia);
  const Square mass = motions.transpose() * inertia;
  const Column length = mass.diagonal().cwiseSqrt(), scale = (length.array() > 0).select(length.cwiseInverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Square> apart(scale.asDiagonal() * mass * scale.asDiagonal());
  const Column rest =
      (apart.eigenvalues().array() > kDependent).select(apart.eigenvalues().cwiseSqrt().cwiseInverse(), 0.0);
  const Square orthonormal = scale.asDiagonal() * apart.eigenvectors() * rest.asDiagonal();
  const Square stiffness = orthonormal.transpose() * (motions.transpose() * image) * orthonormal;
  const Eigen::SelfAdjointEigenSolver<Square> ritz(0.5 * (stiffness + stiffness.transpose()));
  const Square turned = orthonormal * ritz.eigenvectors();
  if (!turned.allFinite()) return false;
  motions = (motions * turned).eval();
  image = (image * turned).eval();
  descend(motions, inertia * (turned * ritz.eigenvalues().asDiagonal()), image, body, steps);
  return motions.allFinite();
}

}  // namespace kt
