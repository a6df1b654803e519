// A body of a lattice, touched at the triangles of its surface: against the same cells as a mesh, against beams, and
// what it does not go with.
#include <gtest/gtest.h>

#include <numbers>

#include "core/global/integrator.hpp"
#include "haptics/session/session.hpp"
#include "io/mesh/mesh_io.hpp"
#include "tests/support/axisymmetric_press.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

Mesh surface_of(Mesh mesh) {
  mesh.tetrahedra.clear();
  return mesh;
}

Scene scene_of_lattice() {
  Scene s = default_scene();
  s.object.mesh = "block";
  s.object.body = "lattice";
  s.object.model.type = "fem";
  s.object.fixed.below = FixedBelow{"z", 1e-6};
  s.tool.radius = 0.008;
  s.duration = 0.3;
  s.local.refine = "off";
  s.collision.backend = "brute_force";
  return s;
}

// A scan's vertices are unevenly spread: the radius of the contact, the surface in reach and the patch must not depend
// on which of them push. The default run of a surface had 94 of 1,200 ticks beside the refined cells, and three times
// the force there.
TEST(LatticeBody, ADragOverAScanStaysOnTheRefinedCells) {
  Scene s = scene_of_lattice();
  s.object.mesh = KT_SOURCE_DIR "/meshes/organ.off";
  s.object.size = 0.1;
  s.object.fixed.below = FixedBelow{"z", 0.2};
  s.tool.radius = 0.004;
  s.duration = 0.7;
  s.local.refine = "auto";
  s.tool.path.press_drag = PressDrag{
      .at = {}, .depth = 0.003, .press_time = 0.2, .direction = {1, 0, 0}, .speed = 0.04, .ease = "minimum_jerk"};
  const SessionResult r = Session(s).run();
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

// ---- the same cells ----

constexpr double kCell = 0.005;

/// A block that a lattice fits exactly: its cells, and its surface's vertices, are those of the block's own mesh.
SessionResult press_block(const std::string& body, double speed) {
  Scene s = scene_of_lattice();
  s.object.body = body;
  if (body == "lattice") s.object.lattice = SceneLattice{.edge = kCell, .nodes = {}};
  s.tool.path.press_drag = PressDrag{
      .at = std::array{0.011, 0.013}, .depth = 0.002, .press_time = 0.1, .direction = {1, 0.3, 0}, .speed = speed};
  s.local.reducer = "full";
  s.duration = 0.2;
  return Session(s, kuhn_block(5, 5, 3, kCell)).run();
}

TEST(LatticeBody, IsTheMeshOfItsCellsWhereItFitsThem) {
  const SessionResult mesh = press_block("mesh", 0.02), lattice = press_block("lattice", 0.02);
  double most = 0, largest = 0;
  for (std::size_t i = 0; i < mesh.tools[0].frames.size(); ++i) {
    most = std::max(most, (mesh.tools[0].frames[i].force - lattice.tools[0].frames[i].force).norm());
    largest = std::max(largest, mesh.tools[0].frames[i].force.norm());
  }
  EXPECT_GT(largest, 0.05);
  EXPECT_LT(most, 3e-4 * largest);  // its triangles are in smaller pieces
  EXPECT_EQ(lattice.tools[0].missed_impacts, 0);
}

// ---- refined cells ----

/// A ball of 8 mm on a block of 60 x 60 x 20 mm in cubes of 7.5 x 7.5 x 6.7 mm, 1.5 mm deep: over the continuum's
/// force.
double pressed_over_continuum() {
  Scene s = scene_of_lattice();
  s.object.lattice = SceneLattice{.edge = 0.008, .nodes = {}};
  s.object.model.material = "linear";
  s.tool.path.press_drag = PressDrag{.at = std::array{0.0315, 0.0285}, .depth = 0.0015, .press_time = 0.3, .speed = 0};
  s.duration = 0.5;
  s.contact.mu_static = s.contact.mu_kinetic = 0;
  s.local.reducer = "condensed";
  s.local.refine = "follow";
  const double force = Session(s, surface_of(kuhn_block(12, 12, 4, 0.005))).run().tools[0].frames.back().f_n;
  return force / press_axisymmetric({.young = 1e4,
                                     .poisson = 0.3,
                                     .thickness = 0.02,
                                     .width = 0.06 / std::sqrt(std::numbers::pi),
                                     .radius = 0.008,
                                     .depth = 0.0015,
                                     .cells = 16,
                                     .follows = true})
                     .force;
}

TEST(LatticeBody, HasTheContinuumsForceWhereItsCellsAreRefined) { EXPECT_NEAR(pressed_over_continuum(), 1.06, 0.08); }

// ---- beams ----

/// 20 x 20 x 80 mm along z, turned by 30 degrees about it, so that cubes are cut along four sides.
Mesh turned_bar() {
  Mesh bar = kuhn_block(8, 8, 32, 0.0025);
  const Mat3 turn = Eigen::AngleAxisd(0.5235987755982988, Vec3::UnitZ()).toRotationMatrix();
  for (int i = 0; i < bar.num_nodes(); ++i) node(bar.x, i) = turn * (node(bar.x, i) - Vec3(0.01, 0.01, 0));
  return bar;
}

/// 20 x 20 x 80 mm along z with a slit of 0.2 mm from the top to a quarter of its height, turned about z by 30 degrees.
/// @param cubes  in six cells each, over the 10 mm beside the slit
Mesh slit_bar(int cubes) {
  constexpr double kGap = 2e-4, kBottom = 0.02;
  const double cube = 0.01 / cubes;
  Mesh bar = kuhn_block(2 * cubes + 1, 2 * cubes, 8 * cubes, cube);
  std::erase_if(bar.tetrahedra, [&](const Tetrahedron& t) {
    return std::ranges::all_of(t, [&](int i) {
      const double column = bar.x[3 * i] / cube;
      return column > cubes - 0.5 && column < cubes + 1.5 && bar.x[3 * i + 2] > kBottom - 1e-9;
    });
  });
  bar.triangles = boundary_triangles(bar.tetrahedra);
  for (int i = 0; i < bar.num_nodes(); ++i)
    if (double& x = bar.x[3 * i]; x > 0.01 + 0.5 * cube) x += kGap - cube;
  const Mat3 turn = Eigen::AngleAxisd(0.5235987755982988, Vec3::UnitZ()).toRotationMatrix();
  for (int i = 0; i < bar.num_nodes(); ++i) node(bar.x, i) = turn * node(bar.x, i);
  return bar;
}

/// Mean displacement of some of the surface's upper end along a force of 10 mN that is spread over it, clamped below.
template <class IsLoaded>
double yields(const Mesh& bar, const std::string& body, double edge, const Vec3& direction, const IsLoaded& is_loaded) {
  BodyOptions options;
  options.object.mesh = "bar";
  options.object.body = body;
  options.object.model.type = "fem";
  options.object.model.material = "linear";
  options.object.model.poisson = 0;
  options.object.fixed.below = FixedBelow{"z", 1e-6};
  if (body == "lattice") options.object.lattice = SceneLattice{.edge = edge, .nodes = {}};
  const Body made(body == "lattice" ? surface_of(bar) : bar, options);
  const Surface& surface = made.surface();
  const VectorX& rest = made.model().mesh().x;
  VectorX force = VectorX::Zero(rest.size());
  std::vector<std::pair<int, double>> top;  // triangles, areas
  double area = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& v = surface.triangles[t];
    if (std::ranges::any_of(v, [&](int i) { return rest[3 * i + 2] < 0.08 - 1e-9 || !is_loaded(node(rest, i)); }))
      continue;
    const Vec3 a = node(rest, v[0]);
    top.emplace_back(static_cast<int>(t), 0.5 * (node(rest, v[1]) - a).cross(node(rest, v[2]) - a).norm());
    area += top.back().second;
  }
  const Vec3 third = Vec3::Constant(1.0 / 3);
  for (const auto& [t, its] : top) moved_by(surface, {}, t, third).add_to(force, 0.01 * its / area * direction);
  State state = rest_state(made.model());
  make_integrator("quasistatic", {})->step(made.model(), force, 0, state);
  double out = 0;
  for (const auto& [t, its] : top)
    out += its / area * direction.dot(moved_by(surface, {}, t, third).of(VectorX(state.x - rest)));
  return out;
}

double yields(const std::string& body, double edge, const Vec3& direction) {
  return yields(turned_bar(), body, edge, direction, [](const Vec3&) { return true; });
}

TEST(LatticeBody, StretchesAsABarDoes) {
  const double truth = 0.01 * 0.08 / (1e4 * 0.02 * 0.02);
  EXPECT_NEAR(yields("lattice", 0.008, Vec3::UnitZ()), truth, 0.03 * truth);
  EXPECT_NEAR(yields("lattice", 0.005, Vec3::UnitZ()), truth, 0.02 * truth);
}

/// Linear tetrahedra bend too stiffly; a lattice no more so than a mesh of its cells: six of 5 mm over the width.
TEST(LatticeBody, BendsAsABarDoes) {
  const double second_moment = std::pow(0.02, 4) / 12;
  const double truth = 0.01 * std::pow(0.08, 3) / (3 * 1e4 * second_moment) + 0.01 * 0.08 * 1.2 / (5e3 * 4e-4);
  const double fine = yields("mesh", 0, Vec3::UnitX()), lattice = yields("lattice", 0.005, Vec3::UnitX());
  EXPECT_NEAR(fine, truth, 0.08 * truth);
  EXPECT_NEAR(lattice, truth, 0.2 * truth);
  EXPECT_GT(lattice, yields("lattice", 0.01, Vec3::UnitX()));
}

/// One of two arms that a slit narrower than a cube parts, against a mesh of cells of the same size that has the slit:
/// four-node cells of 5 mm bend by 0.69 of those of 2.5 mm, and this is no fault of the slit. Glued, they would yield a
/// sixth.
TEST(LatticeBody, BendsAnArmBesideASlitNarrowerThanItsCubes) {
  const Vec3 across = Eigen::AngleAxisd(0.5235987755982988, Vec3::UnitZ()).toRotationMatrix() * Vec3::UnitX();
  const auto first_arm = [&](const Vec3& place) { return across.dot(place) < 0.01 + 1e-9; };
  const double second_moment = 0.02 * std::pow(0.01, 3) / 12;
  const double beam = 0.01 * std::pow(0.06, 3) / (3 * 1e4 * second_moment) + 0.01 * 0.06 * 1.2 / (5e3 * 2e-4);
  for (const int cubes : {2, 4}) {
    const double mesh = yields(slit_bar(cubes), "mesh", 0, across, first_arm);
    const double lattice = yields(slit_bar(2), "lattice", 0.01 / cubes, across, first_arm);
    EXPECT_NEAR(lattice, mesh, 0.1 * mesh) << cubes;
    EXPECT_NEAR(mesh, beam, 0.3 * beam) << cubes;
  }
}

TEST(LatticeBody, WeighsWhatItHolds) {
  const Mesh sphere = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  BodyOptions options;
  options.object.body = "lattice";
  options.object.model.type = "fem";
  const Body body(sphere, options);
  const VectorX along = body.model().mass() * VectorX::Ones(body.model().mesh().x.size());
  EXPECT_NEAR(along.sum() / 3, 1000 * enclosed_volume(sphere), 10 * enclosed_volume(sphere));
}

// ---- in a run ----

TEST(LatticeBody, IsDraggedOverWithoutAMissedImpactAndReplays) {
  Scene s = scene_of_lattice();
  s.object.mesh = KT_SOURCE_DIR "/meshes/organ.off";
  s.object.fixed.below = FixedBelow{};
  s.object.lattice = SceneLattice{.edge = {}, .nodes = 100};
  s.tool.radius = 0.006;
  s.tool.path.press_drag =
      PressDrag{.at = {}, .depth = 0.003, .press_time = 0.15, .direction = {1, 0, 0}, .speed = 0.05};
  s.duration = 0.3;
  for (const char* refine : {"off", "follow"}) {
    s.local.refine = refine;
    const SessionResult first = Session(s).run();
    if (s.local.refine == "follow") {
      EXPECT_EQ(first.hash, Session(s).run().hash);
    }
    EXPECT_EQ(first.tools[0].missed_impacts, 0) << refine;
    EXPECT_GT(first.tools[0].frames.back().f_n, 0.02) << refine;
    EXPECT_LT(*std::ranges::max_element(first.tools[0].penetration), 1e-6) << refine;
  }
}

/// Nodes on the two sides of a slit lie in one place.
TEST(LatticeBody, IsPressedBesideASlit) {
  Scene s = scene_of_lattice();
  s.object.lattice = SceneLattice{.edge = 0.005, .nodes = {}};
  s.tool.path.press_drag = PressDrag{.at = std::array{0.005, 0.012}, .depth = 0.001, .press_time = 0.1, .speed = 0};
  s.local.reducer = "condensed";
  s.duration = 0.2;
  const SessionResult pressed = Session(s, surface_of(slit_bar(2))).run();
  EXPECT_GT(pressed.tools[0].frames.back().f_n, 0.01);
  EXPECT_EQ(pressed.tools[0].missed_impacts, 0);
}

TEST(LatticeBody, HangsInItsWeightAndHasInclusions) {
  Scene s = scene_of_lattice();
  s.object.mesh = KT_SOURCE_DIR "/meshes/organ.off";
  s.object.fixed.below = FixedBelow{};
  s.object.gravity = {0, 0, -9.81};
  s.object.model.inclusions = {{Vec3(0, 0, 0), 0.015, 10}};
  const Session session(s);
  const Mesh& mesh = session.model().mesh();
  const VectorX sag = session.start().x - mesh.x;
  EXPECT_GT(sag.lpNorm<Eigen::Infinity>(), 1e-4);
  VectorX followed = session.start().x;
  mesh.embedded->follow(followed);
  EXPECT_EQ(followed, session.start().x);
  EXPECT_GT(session.model().info().parameters.at("stiffened_elements"), 5);
}

TEST(LatticeBody, SaysInOneLineWhatItDoesNotGoWith) {
  const auto refused = [](const auto& change) {
    Scene s = scene_of_lattice();
    s.object.lattice = SceneLattice{.edge = 0.02, .nodes = {}};
    change(s);
    return message([&] { Session(s, surface_of(kuhn_block(4, 4, 4, 0.01))).run(); });
  };
  EXPECT_EQ(refused([](Scene& s) { s.object.model.type = "msd"; }),
            "object.model.type \"msd\": object.body lattice is made of finite elements; set it to fem");
  EXPECT_EQ(refused([](Scene& s) { s.object.model.element = "tet10"; }),
            "object.model.element \"tet10\": object.body lattice has tet4 only");
  EXPECT_NE(refused([](Scene& s) { s.object.body = "cubes"; }).find("object.body"), std::string::npos);
  EXPECT_NE(refused([](Scene& s) { s.contact.surface = "loop"; }).find("contact.surface \"loop\""), std::string::npos);
  EXPECT_NE(refused([](Scene& s) { s.local.method = "hold"; }).find("take multirate with coulomb"), std::string::npos);
  EXPECT_NE(refused([](Scene& s) {
              s.object.fixed = {{}, {}, std::vector<int>{1}};
            }).find("object.fixed.nodes"),
            std::string::npos);
}

}  // namespace
}  // namespace kt
