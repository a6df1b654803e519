// A body of a lattice whose cells are refined under the tool: the force of the continuum, pieces and places of a scan's
// triangles, and how these yield.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <filesystem>
#include <map>
#include <numbers>

#include "core/body/embedded_surface.hpp"
#include "core/fine/fine_size.hpp"
#include "core/fine/fine_surface.hpp"
#include "core/fine/make_fine_patch.hpp"
#include "haptics/refresh/seen_tool.hpp"
#include "haptics/session/session.hpp"
#include "haptics/watch/lost_contact.hpp"
#include "tests/support/axisymmetric_press.hpp"
#include "tests/support/lattice_scene.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/test_data.hpp"

namespace kt {
namespace {

/// The press and drag that `kilotouch run` gives a surface of 100 mm by default.
Scene default_drag(const std::string& mesh, double duration) {
  Scene s = scene_of_lattice();
  s.object.mesh = mesh;
  s.object.size = 0.1;
  s.object.fixed.below = FixedBelow{"z", 0.2};
  s.tool.radius = 0.004;
  s.duration = duration;
  s.local.refine = "auto";
  s.tool.path.press_drag = PressDrag{
      .at = {}, .depth = 0.003, .press_time = 0.2, .direction = {1, 0, 0}, .speed = 0.04, .ease = "minimum_jerk"};
  return s;
}

// A scan's vertices are unevenly spread: the radius of the contact, the surface in reach and the patch must not depend
// on which of them push. The default run of a surface had 94 of 1,200 ticks beside the refined cells, and three times
// the force there.
TEST(RefinedLattice, ADragOverAScanStaysOnTheRefinedCells) {
  const SessionResult r = Session(default_drag(KT_SOURCE_DIR "/meshes/organ.off", 0.7)).run();
  double sum = 0, largest = 0;
  int beside = 0, touching = 0;
  for (const LocalFrame& f : r.tools[0].frames) {
    beside += (f.flags & (kUnrefined | kLeftPatch)) != 0;
    touching += f.f_n > 0;
    sum += f.f_n;
    largest = std::max(largest, f.f_n);
  }
  ASSERT_GT(touching, 500);
  EXPECT_LE(beside, 7);
  EXPECT_LT(largest, 1.5 * sum / touching);
}

// A tool that presses gets faster. Where models are late, cells that were refined for its speed of 0.08 s ago served
// the first tenths of a millimetre: 14 and 9 ticks beside them.
TEST(RefinedLattice, AToolThatGetsFasterFindsRefinedCellsWhereModelsAreLate) {
  for (const char* mesh : {"/meshes/sphere.off", "/meshes/torus.off"}) {
    Scene s = default_drag(std::string(KT_SOURCE_DIR) + mesh, 0.25);
    s.link.latency_ms = 35;
    const SessionResult r = Session(s).run();
    const auto& frames = r.tools[0].frames;
    EXPECT_GT(std::ranges::max(frames, {}, &LocalFrame::f_n).f_n, 0.01) << mesh;
    EXPECT_EQ(std::ranges::count_if(frames, [](const LocalFrame& f) { return (f.flags & kUnrefined) != 0; }), 0)
        << mesh;
  }
}

/// Of a tool that is held at four places around the origin, by `wide` and by half of it in turn.
double seen_radius(bool is_scan, double wide) {
  Mesh mesh = kuhn_block(2, 2, 2, 0.01);
  Surface surface = make_surface(mesh);
  if (is_scan) surface.embedded = std::make_shared<EmbeddedSurface>();
  std::vector<LocalReport> reports(20);
  for (std::size_t i = 0; i < reports.size(); ++i) {
    reports[i].tick = static_cast<int>(i);
    reports[i].count = 4;
    const double r = i % 2 == 0 ? wide : wide / 2;
    const std::array at{Vec3(r, 0, 0), Vec3(-r, 0, 0), Vec3(0, r, 0), Vec3(0, -r, 0)};
    for (std::size_t k = 0; k < at.size(); ++k)
      reports[i].samples[k] = {
          .triangle = 0, .bary = Vec3(1, 0, 0), .impulse = Vec3(0, 0, -1e-4), .normal = Vec3::UnitZ(), .point = at[k]};
  }
  const VectorX still = VectorX::Zero(mesh.x.size());
  const ContactNodes nodes(surface);
  return see_tool({surface, nodes, mesh.x, still}, ToolShape{.radius = 0.004}, Pose{}, reports, 0, 1000).contact_radius;
}

TEST(RefinedLattice, RadiusOfAContactIsTheMeanOfSomeTicks) {
  EXPECT_NEAR(seen_radius(true, 0.002) / (seen_radius(false, 0.002) + seen_radius(false, 0.004)), 0.75 / 1.5, 1e-9);
}

TEST(RefinedLattice, ContactOfABallIsNoWiderThanTheBall) {
  const ToolShape ball{.kind = ToolShape::Kind::sphere, .radius = 0.004};
  EXPECT_DOUBLE_EQ(pressed_radius(ball, 0.002, 0.001), std::sqrt(0.002 * 0.002 + 0.004 * 0.001));
  EXPECT_DOUBLE_EQ(pressed_radius(ball, 0.0035, 0.003), 0.004);
  const ToolShape capsule{
      .kind = ToolShape::Kind::capsule, .radius = 0.002, .corners = {Vec3(-0.01, 0, 0), Vec3(0.01, 0, 0)}};
  EXPECT_GE(pressed_radius(capsule, 0.008, 0.001), 0.008) << "along it";
}

// The contact of a drag was expected to be twice as wide as the ball, where models are late. Cells and places were as
// far apart as the ball is wide, it ploughed two of them along, and had 1.4 times the force.
TEST(RefinedLattice, ADragHasTheSameForceWhereModelsAreLate) {
  const std::string mesh = test_data() + "/meshes/clean_sphere.obj";
  if (!std::filesystem::exists(mesh)) GTEST_SKIP() << "no test data";
  const auto force_sum = [&](double late_ms) {
    Scene s = default_drag(mesh, 1.2);
    if (late_ms > 0) {
      s.link.charge_refreshes = "given";
      s.link.refresh_ms = late_ms;
    }
    const SessionResult r = Session(s).run();
    double sum = 0;
    for (const LocalFrame& f : r.tools[0].frames) sum += f.force.norm();
    return sum;
  };
  const double in_time = force_sum(0);
  EXPECT_NEAR(force_sum(25) / in_time, 1, 0.05);
}

// On a rough scan the nearest facet may face away. The ball was held at one place from both sides: 3e8 N.
TEST(RefinedLattice, HoldsAToolFromOneSideOfARoughScan) {
  const std::string mesh = test_data() + "/meshes/organ_femur.off";
  if (!std::filesystem::exists(mesh)) GTEST_SKIP() << "no test data";
  const SessionResult r = Session(default_drag(mesh, 0.3)).run();
  double largest = 0;
  for (const LocalFrame& f : r.tools[0].frames) largest = std::max(largest, f.f_n);
  EXPECT_GT(largest, 0.002);
  EXPECT_LT(largest, 0.03);
}

// Under a deep press places are further apart than at rest. What a ball sinks between them was counted from their
// distance at rest, and it was told to be up to 0.4 mm inside in 369 of 1,200 ticks.
TEST(RefinedLattice, ABallBetweenPlacesThatAreStretchedApartIsNotInside) {
  const std::string mesh = test_data() + "/meshes/organ_tooth.obj";
  if (!std::filesystem::exists(mesh)) GTEST_SKIP() << "no test data";
  const SessionResult r = Session(default_drag(mesh, 0.3)).run();
  ASSERT_FALSE(r.tools[0].penetration.empty());
  EXPECT_LT(std::ranges::max(r.tools[0].penetration), LostContact::kNoticeableDepth);
}

// ---- refined cells ----

struct PressedLattice {
  double mean = 0, most = 0, least = 0;  ///< force over the continuum's, in the last 0.2 s
};

/// A ball at rest on a block of 60 x 60 x 20 mm in cubes of 7.5 x 7.5 x 6.7 mm.
PressedLattice press_lattice(const std::string& element, double edge, double depth, const Mesh& scan,
                             double radius = 0.008, std::array<double, 2> at = {0.0315, 0.0285}) {
  Scene s = scene_of_lattice();
  s.object.lattice = SceneLattice{.edge = edge, .nodes = {}};
  s.object.model.element = element;
  s.tool.radius = radius;
  s.object.model.material = "linear";
  s.tool.path.press_drag = PressDrag{.at = at, .depth = depth, .press_time = 0.3, .speed = 0};
  s.duration = 0.6;
  s.contact.mu_static = s.contact.mu_kinetic = 0;
  s.local.reducer = "condensed";
  s.local.refine = "follow";
  const SessionResult result = Session(s, scan).run();
  const double continuum = press_axisymmetric({.young = 1e4,
                                               .poisson = 0.3,
                                               .thickness = 0.02,
                                               .width = 0.06 / std::sqrt(std::numbers::pi),
                                               .radius = radius,
                                               .depth = depth,
                                               .cells = 16,
                                               .follows = true})
                               .force;
  const auto& frames = result.tools[0].frames;
  PressedLattice out{.least = std::numeric_limits<double>::infinity()};
  for (std::size_t i = frames.size() - 200; i < frames.size(); ++i) {
    const double f = frames[i].f_n / continuum;
    out.mean += f / 200;
    out.most = std::max(out.most, f);
    out.least = std::min(out.least, f);
  }
  return out;
}

TEST(RefinedLattice, HasTheContinuumsForceWhereItsCellsAreRefined) {
  const Mesh scan = surface_of(kuhn_block(12, 12, 4, 0.005));
  EXPECT_NEAR(press_lattice("tet4", 0.008, 0.0015, scan).mean, 1.06, 0.08);
  EXPECT_NEAR(press_lattice("tet10", 0.015, 0.0015, scan).mean, 1.06, 0.08);
  for (const double edge : {0.008, 0.012})
    EXPECT_NEAR(press_lattice("hex8", edge, 0.0015, scan).mean, 1.06, 0.08) << edge;
}

// A scan has more vertices under the tool than the cells have nodes. At rest the force alternated by a quarter between
// two sizes of cells, since the contact is measured larger on small ones.
TEST(RefinedLattice, UnderAFineScanTheForceIsTheContinuumsAndStays) {
  const Mesh scan = surface_of(kuhn_block(60, 60, 20, 0.001));
  for (const double depth : {0.0015, 0.0025, 0.0035}) {
    const PressedLattice pressed = press_lattice("tet4", 0.008, depth, scan);
    EXPECT_NEAR(pressed.mean, 1.06, 0.08) << depth;
    EXPECT_LT(pressed.most - pressed.least, 0.03) << depth;
  }
}

// Held at the vertices of the scan the ball sank in between large triangles, 0.65 of the force, and of small ones a
// tick held others each time.
TEST(RefinedLattice, TheForceDoesNotDependOnTheTriangles) {
  for (const int cells : {2, 8, 32}) {
    const double size = 0.02 / cells;
    const Mesh scan = surface_of(kuhn_block(3 * cells, 3 * cells, cells, size));
    for (const double depth : {0.0005, 0.0012}) {
      const PressedLattice pressed = press_lattice("tet4", 0.008, depth, scan, 0.004, {0.0309375, 0.0290625});
      EXPECT_NEAR(pressed.mean, 1.06, 0.08) << size << ' ' << depth;
      EXPECT_LT(pressed.most - pressed.least, 0.03) << size << ' ' << depth;
    }
  }
}

/// A bar in cubes of 9 mm, refined under a contact.
struct RefinedBar {
  explicit RefinedBar(const Mesh& bar, double contact_radius = 0.003, const std::string& element = "tet4")
      : body(surface_of(bar), options(element)), refinable(make_refinable_body(body.model(), body.surface())) {
    const Mesh& mesh = *refinable.fine.mesh;
    const EmbeddedSurface& embedded = *mesh.embedded;
    asked =
        fine_options(refinable.fine, {node(mesh.x, embedded.first + embedded.num_vertices() / 2), contact_radius}, 1.0);
    zone = make_fine_zone(refinable.fine, asked);
  }
  static BodyOptions options(const std::string& element) {
    BodyOptions out;
    out.object.mesh = "bar";
    out.object.model.element = element;
    out.object.body = "lattice";
    out.object.model.type = "fem";
    out.object.lattice = SceneLattice{.edge = 0.009, .nodes = {}};
    return out;
  }
  Vec3 place(int vertex) const { return zone.embedded.vertex[vertex].of(refinable.fine.mesh->x); }

  Body body;
  RefinableBody refinable;
  FineZoneOptions asked;
  FineZone zone;
};

/// Cells that a surface cuts hold leaves without material: they are not unknowns, and no vertex of the surface is in
/// one.
TEST(RefinedLattice, RefinesNothingWhereThereIsNoMaterial) {
  const RefinedBar bar(turned_bar());
  const FineZone& zone = bar.zone;
  const FineBody& body = bar.refinable.fine;
  const EmbeddedSurface& embedded = *body.mesh->embedded;
  ASSERT_GT(zone.embedded.vertex.size(), 10u);
  std::vector<char> is_needed(zone.nodes.size(), 0);
  int empty = 0;
  for (const FineLeaf& leaf : zone.leaves) {
    Vec3 middle = Vec3::Zero();
    for (int c = 0; c < 4; ++c) middle += 0.25 * zone.nodes[leaf.node[c]].of(body.mesh->x);
    if (leaf.is_empty)
      EXPECT_LT(embedded.material->depth(zone.cells[leaf.cell], middle, embedded.edge), 0);
    else
      for (const int i : leaf.node) is_needed[i] = 1;
    empty += leaf.is_empty;
  }
  EXPECT_GT(empty, static_cast<int>(zone.leaves.size()) / 20);
  for (const int l : zone.embedded.leaf) EXPECT_FALSE(zone.leaves[l].is_empty);
  for (const int i : zone.unknown) EXPECT_TRUE(is_needed[i]) << i;
}

// Triangles with edges of 1.2 mm, as the lattice cuts them, under contacts of 1 mm, and of 0.5 mm that stay.
TEST(RefinedLattice, RefinedTrianglesAreInPiecesAsSmallAsTheContactNeeds) {
  for (const auto& [cells, element] : {std::pair(2, "tet4"), {2, "tet10"}, {40, "tet4"}}) {
    const RefinedBar bar(kuhn_block(cells, cells, cells, 0.02 / cells), cells == 2 ? 0.001 : 0.003, element);
    const EmbeddedFacets& e = bar.zone.embedded;
    const auto between = std::ranges::count_if(e.vertex, [](const CellPoint& p) { return p.count > 1; });
    EXPECT_EQ(between > 0, cells == 2);
    const std::vector<Triangle>& triangles = bar.refinable.fine.mesh->triangles;
    std::map<std::array<int, 2>, int> edges;
    std::map<int, double> covered;  // of each triangle [m^2]
    double longest = 0;
    for (std::size_t f = 0; f < e.facets.size(); ++f) {
      const Triangle& t = e.facets[f];
      covered[e.triangle[f]] +=
          0.5 * (bar.place(t[1]) - bar.place(t[0])).cross(bar.place(t[2]) - bar.place(t[0])).norm();
      for (int c = 0; c < 3; ++c) {
        const auto [a, b] = std::minmax(t[c], t[(c + 1) % 3]);
        ++edges[{a, b}];
        longest = std::max(longest, (bar.place(a) - bar.place(b)).norm());
        EXPECT_TRUE(e.vertex[t[c]].lies_on(triangles[e.triangle[f]]));
      }
    }
    EXPECT_LE(longest, (1 + 1e-12) * 2 * e.apart);
    EXPECT_GE(e.apart, bar.asked.apart);
    EXPECT_LT(e.apart, 1.7 * bar.asked.apart);
    for (const auto& [t, area] : covered) {
      const auto at = [&](int c) { return node(bar.refinable.fine.mesh->x, triangles[t][c]); };
      const double whole = 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
      EXPECT_NEAR(area, whole, 1e-12 * whole);
    }
    // Triangles side by side share whole edges: what one has alone is at the rim of what is refined, or in no piece.
    std::size_t inner = 0;
    for (const auto& [edge, count] : edges) {
      EXPECT_LE(count, 2);
      inner += count == 2;
    }
    EXPECT_EQ(e.vertex.size() + e.facets.size(), edges.size() + 1) << "Euler's number of a disc";
    EXPECT_GT(inner, edges.size() / 2);
    // Each vertex is in its leaf.
    for (const auto& weight : e.weight) {
      EXPECT_NEAR(weight[0] + weight[1] + weight[2] + weight[3], 1, 1e-9);
      EXPECT_GE(std::ranges::min(weight), -1e-6);
    }
    for (std::size_t v = 0; v < e.vertex.size(); ++v) {
      Vec3 at = Vec3::Zero();
      for (int c = 0; c < 4; ++c) at += e.weight[v][c] * bar.zone.nodes[e.node[v][c]].of(bar.refinable.fine.mesh->x);
      EXPECT_LT((at - bar.place(static_cast<int>(v))).norm(), 1e-9) << v;
    }
  }
}

TEST(RefinedLattice, ToolsAreHeldAtPlacesThatLieApart) {
  const RefinedBar bar(kuhn_block(40, 40, 40, 5e-4));
  const EmbeddedFacets& e = bar.zone.embedded;
  ASSERT_EQ(e.is_place.size(), e.vertex.size());
  std::vector<int> places;
  for (int v = 0; v < static_cast<int>(e.vertex.size()); ++v)
    if (e.is_place[v]) places.push_back(v);
  EXPECT_LT(places.size(), e.vertex.size() / 2);
  const double apart = e.apart;
  for (const int a : places)
    for (const int b : places)
      if (a < b) {
        EXPECT_GE((bar.place(a) - bar.place(b)).norm(), apart);
      }
  for (int v = 0; v < static_cast<int>(e.vertex.size()); ++v)
    EXPECT_TRUE(std::ranges::any_of(places, [&](int p) { return (bar.place(p) - bar.place(v)).norm() < apart; })) << v;
  // The two sides of a sheet thinner than that have places of their own.
  EmbeddedFacets sheet;
  VectorX x(18);
  for (int side = 0; side < 2; ++side)
    for (int c = 0; c < 3; ++c) {
      node(x, 3 * side + c) = Vec3(c == 1 ? 1e-3 : 0, c == 2 ? 1e-3 : 0, -1e-4 * side);
      sheet.vertex.push_back(corner_point(3 * side + c));
    }
  sheet.facets = {{0, 1, 2}, {3, 5, 4}};
  FineZone thin;
  thin.embedded = sheet;
  thin.embedded.apart = 0.01;
  thin.num_yielding = 6;
  choose_places(x, thin);
  const std::vector<char>& chosen = thin.embedded.is_place;
  EXPECT_EQ(std::count(chosen.begin(), chosen.begin() + 3, 1), 1);
  EXPECT_EQ(std::count(chosen.begin() + 3, chosen.end(), 1), 1);
}

/// Rows and columns of three coordinates each.
MatrixX in_space(const MatrixX& weights) {
  MatrixX out = MatrixX::Zero(3 * weights.rows(), 3 * weights.cols());
  for (Eigen::Index i = 0; i < weights.rows(); ++i)
    for (Eigen::Index j = 0; j < weights.cols(); ++j) out.block<3, 3>(3 * i, 3 * j) = weights(i, j) * Mat3::Identity();
  return out;
}

TEST(RefinedLattice, PlacesYieldWithTheCellsThatHoldThem) {
  for (const char* element : {"tet4", "tet10"}) {
    const RefinedBar bar(kuhn_block(20, 20, 20, 0.001), 0.004, element);
    const FineBody& fine = bar.refinable.fine;
    FineZoneOptions options = bar.asked;
    options.most_nodes = 400;
    const FineZone zone = make_fine_zone(fine, options);
    const EmbeddedFacets& e = zone.embedded;
    ASSERT_GT(e.places.size(), 20u);
    ASSERT_GT(zone.num_yielding, static_cast<int>(e.places.size()));
    ASSERT_GT(zone.inner.size(), 2u);
    const State state{0, fine.mesh->x, VectorX::Zero(fine.mesh->x.size())};
    const DeformableModel& model = bar.body.model();
    TangentModel tangent;
    linearize(model.own(), own_part(model, {0, model.mesh().x, VectorX::Zero(model.mesh().x.size())}),
              TangentKind::symmetric, tangent);
    const auto solver = make_block_solver();
    const FineYield yield = find_yield(fine, zone, {tangent.state, TangentKind::symmetric}, tangent.dfdx, *solver);

    const MatrixX K = fine_stiffness(fine, zone, {tangent.state, TangentKind::symmetric});
    const MatrixX S_f = K.llt()
                            .solve(MatrixX::Identity(K.rows(), K.cols()))
                            .bottomRightCorner(3 * zone.num_yielding, 3 * zone.num_yielding);
    MatrixX P = MatrixX::Zero(static_cast<Eigen::Index>(e.places.size()), zone.num_yielding);
    for (Eigen::Index i = 0; i < P.rows(); ++i)
      for (int c = 0; c < 4; ++c) {
        const int n = e.node[e.places[i]][c];
        for (int k = zone.first[n]; k < zone.first[n + 1]; ++k)
          if (const int j = zone.from[k] - (zone.num_unknown() - zone.num_yielding); j >= 0)
            P(i, j) += e.weight[e.places[i]][c] * zone.weight[k];
      }
    const MatrixX W = P * MatrixX(coarse_weights(fine, zone, zone.yielding()))(Eigen::all, zone.inner);
    const MatrixX dfdx = tangent.dfdx;
    MatrixX K_c(3 * zone.inner.size(), 3 * zone.inner.size());
    for (std::size_t i = 0; i < zone.inner.size(); ++i)
      for (std::size_t j = 0; j < zone.inner.size(); ++j)
        K_c.block<3, 3>(3 * i, 3 * j) = -dfdx.block<3, 3>(3 * zone.inner[i], 3 * zone.inner[j]);
    K_c = MatrixX(0.5 * (K_c + K_c.transpose()));
    MatrixX expected =
        in_space(P) * S_f * in_space(P).transpose() - in_space(W) * K_c.inverse() * in_space(W).transpose();
    expected.diagonal().array() += yield.added;
    EXPECT_EQ(yield.least, 0);
    EXPECT_LE(relative_error(yield.R, expected), 1e-9) << element;

    // The patch that ticks have: places yield by themselves, what lies between them nearly as linear fields do.
    const auto patch = make_fine_patch(fine, zone, fine.mesh->triangles, yield);
    ASSERT_EQ(patch->num_yielding(), static_cast<int>(e.places.size()));
    double furthest = 0, sum_apart = 0;
    for (int v = 0; v < patch->num_vertices(); ++v) {
      double sum = 0;
      Vec3 at = Vec3::Zero();
      for (int k = patch->first_from[v]; k < patch->first_from[v + 1]; ++k) {
        sum += patch->share[k];
        at += patch->share[k] * e.vertex[e.places[patch->from[k]]].of(fine.mesh->x);
      }
      EXPECT_NEAR(sum, 1, 1e-12);
      const double its = (at - e.vertex[v].of(fine.mesh->x)).norm() / e.apart;
      furthest = std::max(furthest, its);
      sum_apart += its;
      if (e.is_place[v]) {
        EXPECT_EQ(patch->first_from[v + 1] - patch->first_from[v], 1);
      }
    }
    EXPECT_LT(furthest, 1) << "at the rim";
    EXPECT_LT(sum_apart / patch->num_vertices(), 0.15);
  }
}

TEST(RefinedLattice, HasNoMorePlacesThanNodesThatYield) {
  const RefinedBar bar(kuhn_block(40, 40, 40, 5e-4));
  FineZoneOptions options = bar.asked;
  for (const double apart : {0.0, 1e-5}) {
    options.apart = apart;
    const FineZone zone = make_fine_zone(bar.refinable.fine, options);
    EXPECT_GT(static_cast<int>(zone.embedded.vertex.size()), zone.num_yielding);
    EXPECT_EQ(zone.num_points(), zone.num_yielding) << apart;  // those with larger distances were a third of it
    const EmbeddedFacets& e = zone.embedded;
    const auto at = [&](int v) { return e.vertex[v].of(bar.refinable.fine.mesh->x); };
    for (int v = 0; v < static_cast<int>(e.vertex.size()); ++v)
      EXPECT_TRUE(std::ranges::any_of(e.places, [&](int p) { return (at(p) - at(v)).norm() < e.apart; })) << v;
  }
}

// Nothing yields there: the search for few enough places had no end.
TEST(RefinedLattice, TouchesWhatIsClamped) {
  for (const char* refine : {"auto", "off"})
    for (const double at : {0.012, 0.04}) {
      Scene s = scene_of_lattice();
      s.object.mesh = KT_SOURCE_DIR "/meshes/organ.off";
      s.object.size = 0.12;
      s.object.fixed = {};
      s.object.fixed.box = std::array{Vec3(0, -1, -1), Vec3(1, 1, 1)};
      s.tool.radius = 0.006;
      s.local.refine = refine;
      s.tool.path.press_drag = PressDrag{.at = std::array{at, 0.0}, .depth = 0.001, .press_time = 0.1};
      s.duration = 0.15;
      const SessionResult r = Session(s).run();
      ASSERT_EQ(r.tools[0].frames.size(), 150u);
      EXPECT_TRUE(std::ranges::all_of(r.tools[0].frames, [](const LocalFrame& f) { return f.force.allFinite(); }));
    }
}

// Two places in front of the ball stuck to it, were drawn along by 8 mm, more than twice the contact's radius, past
// those ahead of them, and held it back with twice the force: 0.33 N.
TEST(RefinedLattice, APlaceIsNotDrawnAlongPastOthers) {
  Scene s = default_drag(KT_SOURCE_DIR "/meshes/organ.off", 0.75);
  s.tool.path.press_drag->at = std::array{-0.0305, 0.0034956};
  const SessionResult r = Session(s).run();
  double largest = 0;
  for (const LocalFrame& f : r.tools[0].frames) largest = std::max(largest, f.f_n);
  EXPECT_LT(largest, 0.25);
  EXPECT_GT(largest, 0.1);
}

}  // namespace
}  // namespace kt
