// Zones of fine cells: graded, no more nodes than asked for, their facets on the body's surface.
#include "core/fine/fine_size.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "models/model.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

struct ZoneBody {
  std::unique_ptr<DeformableModel> model;
  FineBody fine;
  explicit ZoneBody(const std::string& element, int wide = 6, int high = 3) {
    Mesh mesh = kuhn_block(wide, wide, high, 0.01);
    model = make_model("fem", std::move(mesh), {.material = "linear", .element = element});
    fine = make_fine_body(*model, *told_by(*model));
  }
};

/// Anywhere on the surface of the block, corners and sides too.
Vec3 place_on_surface(const Mesh& mesh, Sample& s) {
  const auto& t = mesh.triangles[static_cast<std::size_t>(s.uniform(0, static_cast<double>(mesh.triangles.size())))];
  const double u = s.uniform(0, 1), v = s.uniform(0, 1 - u);
  return (1 - u - v) * node(mesh.x, t[0]) + u * node(mesh.x, t[1]) + v * node(mesh.x, t[2]);
}

Vec3 facet_area(const VectorX& x, const FineZone& zone, const Triangle& t) {
  const Vec3 a = zone.nodes[t[0]].of(x);
  return 0.5 * (zone.nodes[t[1]].of(x) - a).cross(zone.nodes[t[2]].of(x) - a);
}

TEST(FineZone, FacetsArePiecesOfTheBodysTrianglesAndCoverAllInReach) {
  Sample s{std::mt19937_64(3)};
  for (const std::string element : {"tet4", "tet10"}) {
    const ZoneBody body(element);
    const Mesh& mesh = *body.fine.mesh;
    for (int run = 0; run < 10; ++run) {
      const Vec3 centre = place_on_surface(mesh, s);
      const FineZone zone = make_fine_zone(body.fine, fine_options(body.fine, {centre, 0.004}, 0.7));
      ASSERT_GT(zone.facets.size(), 4u);
      std::map<int, double> covered;
      for (std::size_t f = 0; f < zone.facets.size(); ++f) {
        const Triangle& t = mesh.triangles[zone.facet_triangle[f]];
        const Vec3 a = node(mesh.x, t[0]), normal = (node(mesh.x, t[1]) - a).cross(node(mesh.x, t[2]) - a);
        const Vec3 area = facet_area(mesh.x, zone, zone.facets[f]);
        EXPECT_NEAR(area.dot(normal) / (area.norm() * normal.norm()), 1, 1e-12);
        covered[zone.facet_triangle[f]] += 2 * area.norm() / normal.norm();
        for (const int i : zone.facets[f]) {  // inside of the triangle
          const Vec3 p = zone.nodes[i].of(mesh.x);
          for (int e = 0; e < 3; ++e) {
            const Vec3 from = node(mesh.x, t[e]), along = Vec3(node(mesh.x, t[(e + 1) % 3])) - from;
            EXPECT_GE(along.cross(p - from).dot(normal), -1e-12 * normal.squaredNorm());
          }
        }
      }
      // Points of the surface in reach lie in a facet: triangles are covered once, wholly or not at all.
      const double reach = 1.15 * 0.004;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (covered[static_cast<int>(t)] > 0) {
          EXPECT_NEAR(covered[static_cast<int>(t)], 1, 1e-12);
        }
        double farthest = 0;
        for (const int i : mesh.triangles[t]) farthest = std::max(farthest, (node(mesh.x, i) - centre).norm());
        if (farthest < reach) {
          EXPECT_NEAR(covered[static_cast<int>(t)], 1, 1e-12);
        }
      }
    }
  }
}

TEST(FineZone, HasNoMoreNodesThanAskedForAndSaysWhatItTook) {
  const ZoneBody body("tet4");
  for (const int most : {300, 500, 900}) {
    FineZoneOptions options = fine_options(body.fine, {{0.031, 0.028, 0.03}, 0.002, 0.003}, 0.7);
    options.most_nodes = most;
    const FineZone zone = make_fine_zone(body.fine, options);
    EXPECT_LE(zone.num_unknown(), most);
    EXPECT_GT(zone.num_unknown(), most / 3);
    const double steps = std::log(zone.edge / options.size.edge) / std::log(1.25);
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
    EXPECT_GT(steps, 0.5);
    EXPECT_GE(zone.flat, (1 - 1e-12) * options.size.least_flat);
    EXPECT_LE(zone.flat, options.size.flat);
    // The step before was too large, as far as it had to go at least.
    options.size.edge = zone.edge / 1.25;
    options.size.flat = options.size.least_flat;
    options.most_nodes = 100000;
    EXPECT_GT(make_fine_zone(body.fine, options).num_unknown(), most);
  }
}

TEST(FineZone, IsEmptyWhereTheCellsAloneAreTooMany) {
  const ZoneBody body("tet4");
  FineZoneOptions options = fine_options(body.fine, {{0.03, 0.03, 0.03}, 0.02}, 0.7);
  options.most_nodes = 50;
  EXPECT_EQ(make_fine_zone(body.fine, options).num_yielding, 0);
  EXPECT_EQ(make_fine_zone(body.fine, {.centre = {1, 1, 1}, .radius = 0.01, .size = {.edge = 0.001}}).num_yielding, 0);
}

/// Leaves that share a part of an edge or a face are at most one level apart: of the nodes there none is elsewhere than
/// the smaller ones' corners and middles, a quarter of the larger one apart; and none is inside of a leaf.
TEST(FineZone, LeavesSideBySideAreAtMostOneLevelApart) {
  const ZoneBody body("tet4");
  const VectorX& x = body.fine.mesh->x;
  const FineZone zone = make_fine_zone(body.fine, {.centre = {0.031, 0.028, 0.03},
                                                   .radius = 0.02,
                                                   .reach = 0.004,
                                                   .size = {.edge = 0.0008, .flat = 0.001, .slope = 2},
                                                   .most_nodes = 100000});
  int most = 0, quarters = 0;
  for (const FineLeaf& leaf : zone.leaves) most = std::max(most, leaf.level);
  ASSERT_GE(most, 3);
  Eigen::Matrix4Xd places(4, zone.nodes.size());
  for (std::size_t i = 0; i < zone.nodes.size(); ++i) places.col(static_cast<int>(i)) << zone.nodes[i].of(x), 1;
  for (const FineLeaf& leaf : zone.leaves) {
    Eigen::Matrix4d corners;
    for (int c = 0; c < 4; ++c) corners.col(c) << zone.nodes[leaf.node[c]].of(x), 1;
    const Eigen::Matrix4Xd shares = corners.inverse() * places;
    for (const auto& share : shares.colwise()) {
      if (share.minCoeff() < -1e-9) continue;
      EXPECT_LE(share.minCoeff(), 1e-9);
      EXPECT_LE((4 * share - (4 * share).array().round().matrix()).lpNorm<Eigen::Infinity>(), 1e-9);
      quarters += (2 * share - (2 * share).array().round().matrix()).lpNorm<Eigen::Infinity>() > 1e-9;
    }
  }
  EXPECT_GT(quarters, 100);
}

TEST(FineZone, SizesFollowTheToolAndTheCells) {
  const ZoneBody body("tet4");
  EXPECT_NEAR(cell_size_at(body.fine, {0.031, 0.028, 0.03}), 0.01, 1e-12);
  const FineZoneOptions o = fine_options(body.fine, {{0.03, 0.03, 0.03}, 0.003, 0.002}, 0.5);
  EXPECT_NEAR(o.size.edge, 0.0015, 1e-12);
  EXPECT_NEAR(o.size.flat, 0.005, 1e-12);
  EXPECT_NEAR(o.radius, 0.016, 1e-12);
  EXPECT_NEAR(o.reach, 1.15 * 0.003 + 0.002, 1e-12);
  EXPECT_NEAR(fine_options(body.fine, {{0.03, 0.03, 0.03}, 0.012, 0.002}, 0.7).radius, 0.019, 1e-12);
}

}  // namespace
}  // namespace kt
