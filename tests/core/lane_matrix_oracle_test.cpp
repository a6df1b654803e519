// Vectors and matrices in lanes of four, and the sweeps of conjugate gradients over them, against Eigen's.
#include "core/linear/dense/lane_matrix.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "core/global/newton.hpp"
#include "core/linear/step_solvers/pcg_sweeps.hpp"
#include "models/model.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/shaken_body.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-13;  // relative, of sums over some fifty neighbours

/// The step matrix of a shaken block of springs, and an order of its nodes.
struct Body {
  Body() {
    const Mesh mesh = kuhn_block(3, 3, 4, 0.01);
    model =
        make_model("msd", mesh, {.damping_mass = 2, .damping_stiffness = 1e-3, .fixed_nodes = nodes_below(mesh, 1e-6)});
    state = shaken(*model, 0.002, 3);
    tangent = model->tangent(state, TangentKind::definite);
    matrix = std::make_unique<StepMatrix>(make_free_dofs(mesh.num_nodes(), model->fixed_nodes()));
    A = matrix->sum({{{1, &model->mass()}, {-0.03, &tangent.dfdv}, {-9e-4, &tangent.dfdx}}});
    order.resize(static_cast<std::size_t>(A.rows() / 3));
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>((i * 7) % order.size());
    lanes.set_pattern(A, order);
    lanes.update(A);
  }
  int nodes() const { return static_cast<int>(order.size()); }
  std::vector<double> in_lanes(const VectorX& v) const {
    std::vector<double> out;
    lanes.to_lanes(v, out);
    return out;
  }
  VectorX stacked(const std::vector<double>& v) const {
    VectorX out;
    lanes.from_lanes(v, out);
    return out;
  }
  std::unique_ptr<DeformableModel> model;
  State state;
  Tangent tangent;
  std::unique_ptr<StepMatrix> matrix;
  SparseMatrix A;
  std::vector<int> order;
  LaneMatrix lanes;
};

double sum(const double* four) { return four[0] + four[1] + four[2] + four[3]; }

TEST(LaneMatrix, MultipliesAsTheSparseOneDoesInAnyOrder) {
  const Body b;
  ASSERT_EQ(std::gcd(7, b.nodes()), 1);  // every node once
  const VectorX x = random_vector(b.A.rows(), 1), expected = b.A * x;
  const std::vector<double> in = b.in_lanes(x);
  std::vector<double> out(in.size(), 7.0);
  double dot[4] = {1, 0, 0, 0};  // what is there is added to
  const int half = b.nodes() / 2;
  b.lanes.times(in.data(), out.data(), 0, half, dot);
  b.lanes.times(in.data(), out.data(), half, b.nodes(), dot);
  EXPECT_LE(relative_error(b.stacked(out), expected), kRoundoff);
  EXPECT_NEAR(sum(dot) - 1, x.dot(expected), kRoundoff * x.norm() * expected.norm() + kRoundoff);
  for (std::size_t i = 3; i < out.size(); i += 4) EXPECT_EQ(out[i], 0) << i;  // the lane without a number
  EXPECT_EQ(b.stacked(in), x);
  for (int i : {0, 5}) EXPECT_EQ(b.lanes.diagonal(i), Mat3(MatrixX(b.A).block<3, 3>(3 * b.order[i], 3 * b.order[i])));
}

TEST(PcgSweeps, AreTheFormulasOfTheIteration) {
  const Body b;
  const Eigen::Index n = b.A.rows();
  VectorX v[6];
  for (int i = 0; i < 6; ++i) v[i] = random_vector(n, 10 + i);
  auto &x = v[0], &r = v[1], &p = v[2], &q = v[3], &arm = v[4], &z = v[5];
  std::vector<double> in[6];
  for (int i = 0; i < 6; ++i) in[i] = b.in_lanes(v[i]);
  const std::vector<int> groups{0, 11, b.nodes()};
  MatrixX inverse = MatrixX::Zero(n, n);
  std::vector<double> blocks(12 * b.order.size(), 0.0);
  for (int i = 0; i < b.nodes(); ++i) {
    const Mat3 block = random_positive_definite(3, 50 + i);
    inverse.block<3, 3>(3 * b.order[i], 3 * b.order[i]) = block;
    for (int c = 0; c < 3; ++c) Vec3::Map(blocks.data() + 12 * i + 4 * c) = block.col(c);
  }
  const PcgVectors lanes{in[0].data(), in[1].data(),  in[2].data(), in[3].data(),
                         in[5].data(), blocks.data(), in[4].data(), groups.data()};
  double loads[12], sums[8];
  pcg_descend(lanes, 0.3, 0, 2, loads, sums);
  x += 0.3 * p;
  r -= 0.3 * q;
  z = inverse * r;
  EXPECT_LE(relative_error(b.stacked(in[0]), x), kRoundoff);
  EXPECT_LE(relative_error(b.stacked(in[1]), r), kRoundoff);
  EXPECT_LE(relative_error(b.stacked(in[5]), z), kRoundoff);
  EXPECT_NEAR(sum(sums), r.squaredNorm(), kRoundoff * r.squaredNorm());
  EXPECT_NEAR(sum(sums + 4), r.dot(z), kRoundoff * r.norm() * z.norm());
  const double share = 0.7;
  const VectorX motions = random_vector(14, 90);
  VectorX turned = z + share * p;
  for (int g = 0; g < 2; ++g) {
    Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
    for (int i = groups[g]; i < groups[g + 1]; ++i) {
      const int k = b.order[i];
      force += node(r, k);
      moment += Vec3(node(arm, k)).cross(Vec3(node(r, k)));
      node(turned, k) += motions.segment<3>(6 * g) + Vec3(motions.segment<3>(6 * g + 3)).cross(Vec3(node(arm, k)));
    }
    EXPECT_LE((Vec3::Map(loads + 6 * g) - force).norm(), 10 * kRoundoff * r.norm());
    EXPECT_LE((Vec3::Map(loads + 6 * g + 3) - moment).norm(), 10 * kRoundoff * r.norm());
  }
  pcg_turn(lanes, share, 0, 2, motions.data());
  EXPECT_LE(relative_error(b.stacked(in[2]), turned), kRoundoff);
}

TEST(StepMatrix, MultipliesOneOfItsTermsWithAVector) {
  const Body b;
  const VectorX v = random_vector(b.state.x.size(), 5);
  const FreeDofs& dofs = b.matrix->dofs();
  EXPECT_LE(relative_error(b.matrix->symmetric_times(2, b.tangent.dfdx, v), gather(dofs, VectorX(b.tangent.dfdx * v))),
            kRoundoff);
  EXPECT_LE(
      relative_error(b.matrix->symmetric_times(0, b.model->mass(), v), gather(dofs, VectorX(b.model->mass() * v))),
      kRoundoff);  // not in blocks
}

}  // namespace
}  // namespace kt
