// A body of a lattice, touched at the triangles of its surface: against the same cells as a mesh, against beams, and
// what it does not go with.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <numbers>

#include "core/body/embedded_surface.hpp"
#include "core/fine/fine_size.hpp"
#include "core/fine/fine_surface.hpp"
#include "core/global/integrator.hpp"
#include "haptics/predict/predict_elements.hpp"
#include "haptics/session/session.hpp"
#include "io/mesh/mesh_io.hpp"
#include "tests/support/axisymmetric_press.hpp"
#include "tests/support/input_errors.hpp"
#include "tests/support/test_data.hpp"

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

// On a rough scan the nearest facet may face away. The ball was held at one place from both sides: 3e8 N.
TEST(LatticeBody, HoldsAToolFromOneSideOfARoughScan) {
  const std::string mesh = test_data() + "/meshes/organ_femur.off";
  if (!std::filesystem::exists(mesh)) GTEST_SKIP() << "no test data";
  Scene s = scene_of_lattice();
  s.object.mesh = mesh;
  s.object.size = 0.1;
  s.object.fixed.below = FixedBelow{"z", 0.2};
  s.tool.radius = 0.004;
  s.local.refine = "auto";
  s.tool.path.press_drag = PressDrag{
      .at = {}, .depth = 0.003, .press_time = 0.2, .direction = {1, 0, 0}, .speed = 0.04, .ease = "minimum_jerk"};
  const SessionResult r = Session(s).run();
  double largest = 0;
  for (const LocalFrame& f : r.tools[0].frames) largest = std::max(largest, f.f_n);
  EXPECT_GT(largest, 0.002);
  EXPECT_LT(largest, 0.03);
}

// ---- the same cells ----

constexpr double kCell = 0.005;

/// A block that a lattice fits exactly: its cells, and its surface's vertices, are those of the block's own mesh.
SessionResult press_block(const std::string& body) {
  Scene s = scene_of_lattice();
  s.object.body = body;
  if (body == "lattice") s.object.lattice = SceneLattice{.edge = kCell, .nodes = {}};
  s.tool.path.press_drag = PressDrag{
      .at = std::array{0.011, 0.013}, .depth = 0.002, .press_time = 0.1, .direction = {1, 0.3, 0}, .speed = 0.02};
  s.local.reducer = "full";
  s.duration = 0.2;
  return Session(s, kuhn_block(5, 5, 3, kCell)).run();
}

TEST(LatticeBody, IsTheMeshOfItsCellsWhereItFitsThem) {
  const SessionResult mesh = press_block("mesh"), lattice = press_block("lattice");
  double most = 0, largest = 0;
  for (std::size_t i = 0; i < mesh.tools[0].frames.size(); ++i) {
    most = std::max(most, (mesh.tools[0].frames[i].force - lattice.tools[0].frames[i].force).norm());
    largest = std::max(largest, mesh.tools[0].frames[i].force.norm());
  }
  EXPECT_GT(largest, 0.05);
  EXPECT_LT(most, 3e-4 * largest);  // its triangles are in smaller pieces
  EXPECT_EQ(lattice.tools[0].missed_impacts, 0);
}

/// Cells of ten nodes, and springs. Nodes need not have the same numbers: the energy of a motion of the second degree.
TEST(LatticeBody, HasTheMatricesOfAMesh) {
  for (const auto& [type, element] : {std::pair("fem", "tet10"), {"msd", "tet4"}}) {
    BodyOptions options;
    options.object.mesh = "block";
    options.object.model.type = std::string(type);
    options.object.model.element = std::string(element);
    options.object.fixed.below = FixedBelow{"z", 1e-6};
    const Mesh block = kuhn_block(3, 2, 2, kCell);
    const Body mesh(block, options);
    options.object.body = "lattice";
    options.object.lattice = SceneLattice{.edge = kCell, .nodes = {}};
    const Body lattice(surface_of(block), options);
    const DeformableModel &own = lattice.model().own(), &truth = mesh.model();
    ASSERT_EQ(own.mesh().num_nodes(), truth.mesh().num_nodes()) << type;
    EXPECT_EQ(own.fixed_nodes().size(), truth.fixed_nodes().size()) << type;
    const auto energy = [](const DeformableModel& model) {
      const State rest = rest_state(model);
      VectorX step(rest.x.size());
      for (int i = 0; i < model.mesh().num_nodes(); ++i) {
        const Vec3 p = 1e2 * node(rest.x, i);
        node(step, i) = 1e-3 * Vec3(p.y() * p.z(), p.x() * p.x() - p.z(), p.x() * p.y());
      }
      return -step.dot(model.tangent(rest, TangentKind::exact).dfdx * step);
    };
    EXPECT_NEAR(energy(own), energy(truth), 1e-9 * energy(truth)) << type;
    const double mass = truth.mass().diagonal().sum();
    EXPECT_NEAR(own.mass().diagonal().sum(), mass, 1e-12 * mass) << type;
  }
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

TEST(LatticeBody, HasTheContinuumsForceWhereItsCellsAreRefined) {
  const Mesh scan = surface_of(kuhn_block(12, 12, 4, 0.005));
  EXPECT_NEAR(press_lattice("tet4", 0.008, 0.0015, scan).mean, 1.06, 0.08);
  EXPECT_NEAR(press_lattice("tet10", 0.015, 0.0015, scan).mean, 1.06, 0.08);
}

// A scan has more vertices under the tool than the cells have nodes. At rest the force alternated by a quarter between
// two sizes of cells, since the contact is measured larger on small ones.
TEST(LatticeBody, UnderAFineScanTheForceIsTheContinuumsAndStays) {
  const Mesh scan = surface_of(kuhn_block(60, 60, 20, 0.001));
  for (const double depth : {0.0015, 0.0025, 0.0035}) {
    const PressedLattice pressed = press_lattice("tet4", 0.008, depth, scan);
    EXPECT_NEAR(pressed.mean, 1.06, 0.08) << depth;
    EXPECT_LT(pressed.most - pressed.least, 0.03) << depth;
  }
}

// Held at the vertices of the scan the ball sank in between large triangles, 0.65 of the force, and of small ones a
// tick held others each time.
TEST(LatticeBody, TheForceDoesNotDependOnTheTriangles) {
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

// ---- beams ----

const Mat3 kTurn = Eigen::AngleAxisd(0.5235987755982988, Vec3::UnitZ()).toRotationMatrix();

/// 80 mm along z, turned by 30 degrees about it, so that cubes are cut along four sides.
/// @param cells  of 2.5 mm along its depth and width
Mesh turned_bar(int deep = 8, int wide = 8, double depth = 0.02) {
  Mesh bar = kuhn_block(deep, wide, 32, 0.0025);
  for (int i = 0; i < bar.num_nodes(); ++i)
    node(bar.x, i) = kTurn * (node(bar.x, i).cwiseProduct(Vec3(depth / (0.0025 * deep), 1, 1)) - Vec3(0.01, 0.01, 0));
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
double yields(const Mesh& bar, const std::string& body, double edge, const Vec3& direction, const IsLoaded& is_loaded,
              const std::string& cells = "tet4") {
  BodyOptions options;
  options.object.mesh = "bar";
  options.object.body = body;
  const bool are_springs = cells == "springs";
  options.object.model.type = are_springs ? "msd" : "fem";
  options.object.model.material = "linear";
  options.object.model.poisson = are_springs ? 0.25 : 0;
  if (!are_springs) options.object.model.element = cells;
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

/// A cantilever that bends and shears, Poisson's ratio 0, so that width does not matter.
double beam(double depth, double width) {
  const double second_moment = width * std::pow(depth, 3) / 12;
  return 0.01 * std::pow(0.08, 3) / (3 * 1e4 * second_moment) + 0.01 * 0.08 * 1.2 / (5e3 * depth * width);
}

/// Ten-node cells, a bar's as wide as it is, a plate's five times as thick.
TEST(LatticeBody, BendsAsABarAndAPlateDoInTenNodeCells) {
  const Vec3 across = kTurn * Vec3::UnitX();
  const auto all = [](const Vec3&) { return true; };
  for (const double edge : {0.02, 0.01}) {
    const double bar = yields(turned_bar(), "lattice", edge, across, all, "tet10");
    EXPECT_NEAR(bar, beam(0.02, 0.02), 0.08 * beam(0.02, 0.02)) << edge;
    const double plate = yields(turned_bar(2, 24, 0.004), "lattice", edge, across, all, "tet10");
    EXPECT_NEAR(plate, beam(0.004, 0.06), 0.2 * beam(0.004, 0.06)) << edge;
  }
}

TEST(LatticeBody, StretchesAsABarDoes) {
  const double truth = 0.01 * 0.08 / (1e4 * 0.02 * 0.02);
  EXPECT_NEAR(yields("lattice", 0.008, Vec3::UnitZ()), truth, 0.03 * truth);
  EXPECT_NEAR(yields("lattice", 0.005, Vec3::UnitZ()), truth, 0.02 * truth);
}

/// Springs have a Poisson ratio near 1/4, and are a tenth too soft or too stiff along one axis or another.
TEST(LatticeBody, OfSpringsStretchesAsABarDoes) {
  const double truth = 0.01 * 0.08 / (1e4 * 0.02 * 0.02);
  const auto all = [](const Vec3&) { return true; };
  for (const double edge : {0.008, 0.005})
    EXPECT_NEAR(yields(turned_bar(), "lattice", edge, Vec3::UnitZ(), all, "springs"), truth, 0.1 * truth) << edge;
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
  for (const auto& [type, element] : {std::pair("fem", "tet4"), {"fem", "tet10"}, {"msd", "tet4"}}) {
    options.object.model.type = std::string(type);
    options.object.model.element = std::string(element);
    const Body body(sphere, options);
    const VectorX along = body.model().mass() * VectorX::Ones(body.model().mesh().x.size());
    EXPECT_NEAR(along.sum() / 3, 1000 * enclosed_volume(sphere), 10 * enclosed_volume(sphere)) << type << element;
  }
}

/// A ball's extent is four times that of its cells, and its wall a third of one.
TEST(LatticeBody, OfAThinWallIsSaidToBendTooLittle) {
  Mesh ball = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off"), hollow = ball;
  const Vec3 middle = bounds(ball).centre();
  const int outer = ball.num_nodes();
  hollow.x.conservativeResize(6 * outer);
  for (int i = 0; i < outer; ++i) node(hollow.x, outer + i) = middle + 0.9 * (node(ball.x, i) - middle);
  for (const Triangle& v : ball.triangles) hollow.triangles.push_back({v[0] + outer, v[2] + outer, v[1] + outer});
  BodyOptions options;
  options.object.body = "lattice";
  options.object.model.type = "fem";
  const auto said = [&](const Mesh& surface, const std::string& element) {
    options.object.model.element = element;
    return predict_locking(Body(surface, options).model(), element, 0.3);
  };
  EXPECT_FALSE(said(ball, "tet4"));
  const auto thin = said(hollow, "tet4");
  ASSERT_TRUE(thin);
  EXPECT_EQ(thin->finding.cures.at(0).key, "object.model.element");
  EXPECT_EQ(thin->finding.cures.at(0).value, "tet10");
  EXPECT_FALSE(said(hollow, "tet10"));
}

TEST(LatticeBody, OfCubesFarWiderThanTheContactIsToldBeforeTheRun) {
  const auto said = [](int nodes) {
    Scene s = scene_of_lattice();
    s.object.lattice = SceneLattice{.edge = {}, .nodes = nodes};
    s.local.refine = "auto";
    s.tool.radius = 0.004;
    s.tool.path.press_drag = PressDrag{.at = std::array{0.05, 0.05}, .depth = 0.002, .press_time = 0.1, .speed = 0};
    std::vector<std::string> out;
    const Session session(s, surface_of(kuhn_block(10, 10, 5, 0.01)));
    for (const Prediction& p : session.predictions())
      if (p.failure == "contact_width") out.push_back(p.finding.what);
    return out;
  };
  EXPECT_TRUE(said(1500).empty());
  const auto few = said(60);
  ASSERT_EQ(few.size(), 1u);
  EXPECT_NE(few[0].find("contact radii wide"), std::string::npos) << few[0];
}

/// Cells that a surface cuts hold leaves without material: they are not unknowns, and no vertex of the surface is in
/// one.
TEST(LatticeBody, RefinesNothingWhereThereIsNoMaterial) {
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
TEST(LatticeBody, RefinedTrianglesAreInPiecesAsSmallAsTheContactNeeds) {
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

TEST(LatticeBody, ToolsAreHeldAtPlacesThatLieApart) {
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
  const std::vector<char> chosen = places_apart(x, sheet, 0.01);
  EXPECT_EQ(std::count(chosen.begin(), chosen.begin() + 3, 1), 1);
  EXPECT_EQ(std::count(chosen.begin() + 3, chosen.end(), 1), 1);
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
  const std::array<std::array<const char*, 3>, 4> cases{
      {{"fem", "tet4", "off"}, {"fem", "tet4", "follow"}, {"fem", "tet10", "follow"}, {"msd", "tet4", "off"}}};
  for (const auto& [type, element, refine] : cases) {
    s.object.model.type = std::string(type);
    s.object.model.element = std::string(element);
    s.local.refine = std::string(refine);
    s.object.lattice->nodes = s.object.model.element == "tet10" ? 300 : 100;
    const SessionResult first = Session(s).run();
    if (s.local.refine == "follow" && s.object.model.element == "tet4") {
      EXPECT_EQ(first.hash, Session(s).run().hash);
    }
    EXPECT_EQ(first.tools[0].missed_impacts, 0) << type << element << refine;
    EXPECT_GT(first.tools[0].frames.back().f_n, 0.02) << type << element << refine;
    EXPECT_LT(*std::ranges::max_element(first.tools[0].penetration), 1e-6) << type << element << refine;
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
