// Tetrahedra of springs that lost their volume: pushed back by the gradient of an energy, and back from inside out.
#include "models/msd/volume_guard.hpp"

#include <gtest/gtest.h>

#include "core/global/integrator.hpp"
#include "models/model.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/shaken_body.hpp"

namespace kt {
namespace {

constexpr double kEdge = 0.01, kStiffness = 40, kShare = 0.7;

std::vector<Spring> springs_of(const Mesh& mesh) {
  std::vector<Spring> out = make_springs(mesh);
  for (Spring& s : out) s.stiffness = kStiffness;
  return out;
}

/// By the determinant, not by the gradients that the code takes its volume from.
double energy(const std::vector<VolumeGuard>& guards, const VectorX& x) {
  double out = 0;
  for (const VolumeGuard& g : guards) {
    Mat3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = node(x, g.nodes[k + 1]) - node(x, g.nodes[0]);
    const double lacking = std::max(0.0, g.least - edges.determinant() / 6);
    out += 0.5 * g.stiffness * lacking * lacking;
  }
  return out;
}

VectorX total_force(const std::vector<VolumeGuard>& guards, const VectorX& x) {
  VectorX out = VectorX::Zero(x.size());
  Eigen::Matrix<double, 3, 4> push;
  for (const VolumeGuard& g : guards)
    if (guard_force(g, x, push))
      for (int i = 0; i < 4; ++i) node(out, g.nodes[i]) += push.col(i);
  return out;
}

Mesh block() { return kuhn_block(2, 2, 2, kEdge); }

/// From hardly pushed to turned inside out.
std::vector<VectorX> crushed(const Mesh& mesh) {
  std::vector<VectorX> out;
  for (const double height : {0.65, 0.3, 0.0, -0.4, -1.0}) {
    VectorX x = mesh.x + 0.1 * kEdge * VectorX::LinSpaced(mesh.x.size(), 0, 40).array().sin().matrix();
    for (int i = 0; i < mesh.num_nodes(); ++i) x[3 * i + 2] *= height;
    out.push_back(x);
  }
  return out;
}

TEST(VolumeGuard, ForceIsMinusTheGradientOfItsEnergyAndItsTangentTheDerivative) {
  const Mesh mesh = block();
  const auto guards = make_volume_guards(mesh, springs_of(mesh), kShare);
  ASSERT_EQ(guards.size(), mesh.tetrahedra.size());
  for (const VectorX& x : crushed(mesh)) {
    const auto of_x = [&](const VectorX& y) { return VectorX{{energy(guards, y)}}; };
    const VectorX gradient = central_differences(of_x, x, 1e-7).transpose(), f = total_force(guards, x);
    EXPECT_GT(f.norm(), 0);
    EXPECT_LE((f + gradient).norm(), 1e-6 * f.norm());
    MatrixX dfdx = MatrixX::Zero(x.size(), x.size());
    for (const VolumeGuard& g : guards) {
      GuardForce push;
      if (!guard_force(g, x, false, push)) continue;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          dfdx.block<3, 3>(3 * g.nodes[i], 3 * g.nodes[j]) += push.dfdx.block<3, 3>(3 * i, 3 * j);
    }
    const auto force_of_x = [&](const VectorX& y) { return total_force(guards, y); };
    EXPECT_LE(relative_error(dfdx, central_differences(force_of_x, x, 1e-8)), 1e-6);
    EXPECT_LE((dfdx - dfdx.transpose()).norm(), 1e-12 * dfdx.norm());
  }
}

TEST(VolumeGuard, OfOneFlatTetrahedronIsTheHandValue) {
  const Mesh mesh = one_tetrahedron(1);  // volume 1/6, springs of mean stiffness 40
  const auto guards = make_volume_guards(mesh, springs_of(mesh), 0.5);
  VectorX x = mesh.x;
  x[11] = 0;  // node 3 onto the face opposite to it
  // |gradient at rest|^2 = 3 (1/6)^2 + 3 (1/6)^2; c = 4 * 40 / (1/6); the volume lacks 1/12.
  const VectorX f = total_force(guards, x);
  EXPECT_NEAR(f[11], 160 * 6 / 12.0 / 6, 1e-12);  // up, along the height
  EXPECT_NEAR(f[2] + f[5] + f[8], -f[11], 1e-12);
}

TEST(VolumeGuard, ThoseWithVolumeEnoughFeelNothing) {
  const Mesh mesh = block();
  const auto guards = make_volume_guards(mesh, springs_of(mesh), kShare);
  EXPECT_TRUE(total_force(guards, mesh.x).isZero(0));
  EXPECT_TRUE(total_force(guards, 0.9 * mesh.x).isZero(0));  // 0.73 of the volume
  EXPECT_FALSE(total_force(guards, 0.88 * mesh.x).isZero(0));
  EXPECT_TRUE(make_volume_guards(mesh, springs_of(mesh), 0).empty());
}

TEST(VolumeGuard, DefiniteDerivativesAreSemidefinite) {
  const Mesh mesh = block();
  for (const VectorX& x : crushed(mesh))
    for (const VolumeGuard& g : make_volume_guards(mesh, springs_of(mesh), kShare)) {
      GuardForce push;
      if (!guard_force(g, x, true, push)) continue;
      const VectorX values = symmetric_eigenvalues(-push.dfdx);
      EXPECT_GE(values[0], -1e-9 * values[11]);
    }
}

/// Height of a tetrahedron of height 1 that starts as its own mirror image.
double height_after(double share) {
  const auto model = make_model("msd", one_tetrahedron(1),
                                {.density = 1,
                                 .damping_mass = 2,
                                 .damping_stiffness = 1e-2,
                                 .stiffness = kStiffness,
                                 .least_volume = share,
                                 .fixed_nodes = {0, 1, 2}});
  State s = rest_state(*model);
  s.x[11] = -1;  // every spring has its length there
  const auto integrator = make_integrator("newton_euler");
  for (int i = 0; i < 2000; ++i) integrator->step(*model, VectorX::Zero(s.x.size()), 0.01, s);
  return s.x[11];
}

TEST(VolumeGuard, WhatIsTurnedInsideOutComesBackAndWithoutItStays) {
  EXPECT_NEAR(height_after(0), -1, 1e-9);
  EXPECT_NEAR(height_after(kShare), 1, 1e-6);
}

}  // namespace
}  // namespace kt
