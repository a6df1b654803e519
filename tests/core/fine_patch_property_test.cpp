// The surface of refined cells: whole triangles in pieces that share their edges, each point in one of them, and what
// has yielded carried from one zone to the next by place.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "core/body/node_weights.hpp"
#include "core/fine/fine_size.hpp"
#include "core/fine/make_fine_patch.hpp"
#include "models/model.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

class FinePatches : public ::testing::TestWithParam<const char*> {
 protected:
  FinePatches() {
    Mesh mesh = kuhn_block(6, 6, 3, 0.01);
    ModelOptions options{.material = "linear", .element = GetParam()};
    for (int i = 0; i < mesh.num_nodes(); ++i)
      if (node(mesh.x, i).z() < 1e-9) options.fixed_nodes.push_back(i);
    model_ = make_model("fem", std::move(mesh), options);
    body_ = make_fine_body(*model_, *told_by(*model_));
  }
  std::shared_ptr<FinePatch> patch_at(const Vec3& centre, double radius) const {
    const FineZone zone = make_fine_zone(body_, fine_options(body_, {centre, radius}, 0.7));
    const State rest = rest_state(*model_);
    const auto solver = make_block_solver();
    return make_fine_patch(
        body_, zone, model_->mesh().triangles,
        find_yield(body_, zone, {rest}, model_->tangent(rest, TangentKind::symmetric).dfdx, *solver));
  }
  Vec3 at(const SurfacePlace& place) const {
    Vec3 out = Vec3::Zero();
    for (int c = 0; c < 3; ++c)
      out += place.weights[c] * node(model_->mesh().x, model_->mesh().triangles[place.triangle][c]);
    return out;
  }
  std::unique_ptr<DeformableModel> model_;
  FineBody body_;
};

TEST_P(FinePatches, PiecesShareTheirEdgesAndCoverTheirTriangles) {
  const auto patch = patch_at({0.031, 0.028, 0.03}, 0.004);
  ASSERT_GT(patch->facets.size(), 40u);
  std::map<std::pair<int, int>, int> edges;  // how often, in this direction
  std::map<int, double> covered;
  const VectorX& x = model_->mesh().x;
  std::vector<Vec3> place(static_cast<std::size_t>(patch->num_vertices()), Vec3::Zero());
  for (int v = 0; v < patch->num_vertices(); ++v) {
    double sum = 0;
    for (int k = patch->first[v]; k < patch->first[v + 1]; ++k) {
      place[v] += patch->weight[k] * node(x, patch->node[k]);
      sum += patch->weight[k];
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  for (std::size_t f = 0; f < patch->facets.size(); ++f) {
    const Triangle& t = patch->facets[f];
    covered[patch->triangle[f]] += patch->corners[f].determinant();
    for (int c = 0; c < 3; ++c) {
      ++edges[{t[c], t[(c + 1) % 3]}];
      EXPECT_LE((at({patch->triangle[f], patch->corners[f].col(c)}) - place[t[c]]).norm(), 1e-12);
    }
  }
  for (const auto& [triangle, share] : covered) EXPECT_NEAR(share, 1, 1e-12) << triangle;
  int inside = 0;
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    inside += edges.contains({edge.second, edge.first});
    if (edges.contains({edge.second, edge.first})) continue;
    // An edge of the refined part: no vertex lies within it.
    const Vec3 a = place[edge.first], b = place[edge.second];
    for (const Vec3& p : place) {
      const double along = (p - a).dot(b - a) / (b - a).squaredNorm();
      EXPECT_FALSE(along > 1e-6 && along < 1 - 1e-6 && (p - a - along * (b - a)).norm() < 1e-9);
    }
  }
  EXPECT_GT(inside, 0);
}

TEST_P(FinePatches, EachPlaceIsInOneOfThePieces) {
  const auto patch = patch_at({0.031, 0.028, 0.03}, 0.004);
  Sample s{std::mt19937_64(7)};
  const std::set<int> refined(patch->triangle.begin(), patch->triangle.end());
  for (const int triangle : refined)
    for (int run = 0; run < 20; ++run) {
      const double u = s.uniform(0, 1), v = s.uniform(0, 1 - u);
      const SurfacePlace place{triangle, {1 - u - v, u, v}};
      const auto [facet, bary] = patch->find(place);
      ASSERT_GE(facet, 0);
      EXPECT_EQ(patch->triangle[facet], triangle);
      EXPECT_GE(bary.minCoeff(), -1e-9);
      EXPECT_LE((patch->corners[facet] * bary - place.weights).norm(), 1e-12);
    }
  EXPECT_EQ(patch->find({-1, Vec3::Unit(0)}).first, -1);
}

// Where both patches yield, what is alike in every place stays; elsewhere nothing has.
TEST_P(FinePatches, WhatHasYieldedIsCarriedByPlace) {
  const auto old = patch_at({0.031, 0.028, 0.03}, 0.004), now = patch_at({0.034, 0.03, 0.03}, 0.005);
  VectorX z(3 * old->num_yielding()), carried = VectorX::Constant(3 * now->num_yielding(), 1e9);
  const auto field = [](const Vec3& p) { return Vec3(1e-3 + 0.1 * p.x(), 0.2 * p.y(), 0.3 * p.x() - 0.1 * p.y()); };
  for (int i = 0; i < old->num_yielding(); ++i) node(z, i) = field(at(old->yielding[i]));
  carry_yield(old.get(), z, *now, carried);
  int same = 0;
  for (int i = 0; i < now->num_yielding(); ++i) {
    const auto [facet, bary] = old->find(now->yielding[i]);
    double share = 0;
    if (facet >= 0) {
      const NodeWeights yields = old->yields_with(facet, bary);
      for (int k = 0; k < yields.count; ++k) share += yields.weight[static_cast<std::size_t>(k)];
    }
    const Vec3 here = node(carried, i);
    if (share > 1 - 1e-12) {
      ++same;
      EXPECT_LE((here - field(at(now->yielding[i]))).norm(), 1e-12);
    } else if (facet < 0) {
      EXPECT_EQ(here, Vec3(Vec3::Zero()));
    }
  }
  EXPECT_GT(same, 10);
  carry_yield(nullptr, z, *now, carried);
  EXPECT_TRUE(carried.isZero(0));
}

INSTANTIATE_TEST_SUITE_P(Elements, FinePatches, ::testing::Values("tet4", "tet10"));

}  // namespace
}  // namespace kt
