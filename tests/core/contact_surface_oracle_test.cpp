// The smooth contact surface: what it is (planes, edges, the limit), and that forces and motion belong together.
#include "core/body/node_weights.hpp"
#include "core/contact_surface/contact_surface.hpp"

#include <gtest/gtest.h>

#include "core/contact_surface/subdivision.hpp"
#include "tests/support/linearized_block.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

const Smoothing kLoop{"loop", 2};

struct SmoothBlock : LinearizedBlock {
  SmoothBlock() : LinearizedBlock(3) {
    site.reach = 0.01;
    patch = make_patch(LinearizedBlock::surface, tangent.state.x, site, true);
    smooth = make_contact_surface(patch, kLoop);
    for (int i : patch.global_node)
      for (int c = 0; c < 3; ++c) x.conservativeResize(x.size() + 1), x[x.size() - 1] = tangent.state.x[3 * i + c];
  }
  SurfacePatch patch;
  ContactSurface smooth;
  VectorX x;  // of the patch
};

TEST(ContactSurface, FlatIsThePatch) {
  const SmoothBlock b;
  const ContactSurface flat = make_contact_surface(b.patch, {});
  VectorX out;
  flat.follow(b.x, out);
  EXPECT_EQ(out, b.x);
  EXPECT_EQ(flat.facets.triangles, b.patch.triangles);
  const Vec3 bary(0.2, 0.3, 0.5);
  const Triangle& t = b.patch.triangles[3];
  EXPECT_LT((flat.at(b.x, 3, bary) - 0.2 * node(b.x, t[0]) - 0.3 * node(b.x, t[1]) - 0.5 * node(b.x, t[2])).norm(),
            1e-17);
}

TEST(ContactSurface, APointIsWhereItsFacetIs) {
  const SmoothBlock b;
  VectorX fine(3 * b.smooth.facets.num_vertices());
  b.smooth.follow(b.x, fine);
  const Vec3 bary(0.1, 0.6, 0.3);
  for (int f = 0; f < static_cast<int>(b.smooth.facets.triangles.size()); ++f) {
    Vec3 p = Vec3::Zero();
    for (int c = 0; c < 3; ++c) p += bary[c] * node(fine, b.smooth.facets.triangles[f][c]);
    ASSERT_LT((p - b.smooth.at(b.x, f, bary)).norm(), 1e-16);
  }
}

TEST(ContactSurface, ForcesAndMotionDoTheSameWork) {
  const SmoothBlock b;
  const VectorX v = random_vector(static_cast<int>(b.x.size()), 5);
  const Vec3 force(1, -2, 3), bary(0.5, 0.2, 0.3);
  for (const int f : {0, 17, 40}) {
    VectorX spread = VectorX::Zero(b.x.size());
    b.smooth.add_at(spread, f, bary, force);
    EXPECT_NEAR(spread.dot(v), force.dot(b.smooth.at(v, f, bary)), 1e-13);
  }
}

/// J C J^T, column by column.
TEST(ContactSurface, PointsAreCoupledAsTheirForcesMoveThem) {
  const SmoothBlock b;
  const auto rows = static_cast<int>(b.x.size());
  const MatrixX any = random_vector(rows * rows, 6).reshaped(rows, rows), C = any + any.transpose();
  const std::vector<std::pair<int, Vec3>> points{
      {0, {0.5, 0.2, 0.3}}, {1, {0.1, 0.1, 0.8}}, {5, {1, 0, 0}}, {40, {0.3, 0.3, 0.4}}, {0, {0, 0.5, 0.5}}};
  std::vector<NodeWeights> moves;
  for (const auto& [f, bary] : points) moves.push_back(b.smooth.moved_by(f, bary));
  CouplingRoom room(rows / 3);
  const auto n = 3 * static_cast<int>(points.size());
  MatrixX coupled(n, n);
  for (int again = 0; again < 2; ++again) couple_points(C, moves, room, coupled);  // the room is used again
  for (int k = 0; k < n; ++k) {
    VectorX unit = VectorX::Zero(rows);
    b.smooth.add_at(unit, points[k / 3].first, points[k / 3].second, Vec3::Unit(k % 3));
    const VectorX moved = C * unit;
    for (int i = 0; i < n / 3; ++i)
      EXPECT_LT((coupled.block<3, 1>(3 * i, k) - b.smooth.at(moved, points[i].first, points[i].second)).norm(), 1e-13);
  }
}

TEST(ContactSurface, ATriangleAloneKnowsItsSurface) {
  const SmoothBlock b;
  int checked = 0;
  for (int local = 0; local < static_cast<int>(b.patch.triangles.size()); ++local) {
    if (b.patch.on_rim[local]) continue;
    ++checked;
    const Vec3 bary = Vec3(0.21, 0.34, 0.45);
    const auto [piece, in_piece] = piece_at(2, bary);
    EXPECT_LT((weights_in_triangle(piece, 2, in_piece) - bary).norm(), 1e-15);
    const NodeWeights w = moved_by(b.surface, kLoop, b.patch.global_triangle[local], bary);
    EXPECT_LT((w.of(b.tangent.state.x) - b.smooth.at(b.x, 16 * local + piece, in_piece)).norm(), 1e-16);
  }
  EXPECT_GT(checked, 10);
}

TEST(ContactSurface, PiecesCoverTheirTriangle) {
  for (int i = 0; i <= 20; ++i)
    for (int k = 0; i + k <= 20; ++k) {
      const Vec3 bary(i / 20.0, k / 20.0, 1 - (i + k) / 20.0);
      const auto [piece, w] = piece_at(3, bary);
      EXPECT_GE(w.minCoeff(), -1e-15);
      EXPECT_LT((weights_in_triangle(piece, 3, w) - bary).norm(), 1e-15);
    }
}

std::vector<Vec3> loop_of(const Mesh& mesh, int levels, double ridge_angle) {
  const Surface surface = make_surface(mesh, ridge_angle);
  std::vector<std::array<bool, 3>> sharp;
  for (const auto& c : surface.crease)
    sharp.push_back({c[0] != Crease::none, c[1] != Crease::none, c[2] != Crease::none});
  const Subdivision s = subdivide_loop(surface.triangles, mesh.num_nodes(), sharp, levels);
  std::vector<Vec3> out;
  for (int v = 0; v < s.num_vertices(); ++v) {
    Vec3 sum = Vec3::Zero();
    double total = 0;
    for (int k = s.first[v]; k < s.first[v + 1]; ++k) {
      sum += s.weight[k] * node(mesh.x, s.from[k]);
      total += s.weight[k];
    }
    EXPECT_NEAR(total, 1, 1e-14);
    out.push_back(sum);
  }
  return out;
}

TEST(Subdivision, KeepsSharpEdgesAndFlatFaces) {
  const Mesh block = kuhn_block(2, 2, 2, 1);
  double off = 0, rounded = 0;
  const auto from_cube = [](const Vec3& p) {  // distance of a point inside from the nearest face of [0, 2]^3
    return std::min((p.array()).minCoeff(), (2 - p.array()).minCoeff());
  };
  std::vector<char> on_surface(static_cast<std::size_t>(block.num_nodes()), 0);
  for (const Triangle& t : block.triangles)
    for (int i : t) on_surface[static_cast<std::size_t>(i)] = 1;
  const std::vector<Vec3> sharp = loop_of(block, 2, kRidgeAngle), smooth = loop_of(block, 2, 3.2);
  for (std::size_t v = 0; v < sharp.size(); ++v) {
    if (v < on_surface.size() && !on_surface[v]) continue;  // a node inside the block
    off = std::max(off, std::abs(from_cube(sharp[v])));
    rounded = std::max(rounded, from_cube(smooth[v]));
  }
  EXPECT_LT(off, 1e-14);
  EXPECT_GT(rounded, 0.1);
}

TEST(Subdivision, ItsVerticesDoNotDependOnHowOftenItWasRefined) {
  Mesh mesh = kuhn_block(2, 2, 1, 1);
  mesh.x += 0.2 * random_vector(static_cast<int>(mesh.x.size()), 3);
  const std::vector<Vec3> once = loop_of(mesh, 1, 3.2), often = loop_of(mesh, 3, 3.2);
  for (std::size_t v = 0; v < once.size(); ++v) EXPECT_LT((once[v] - often[v]).norm(), 1e-14);
}

}  // namespace
}  // namespace kt
