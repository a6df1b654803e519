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
#include "tests/support/lattice_scene.hpp"
#include "tests/support/test_data.hpp"

namespace kt {
namespace {

// ---- the same cells ----

constexpr double kCell = 0.005;

/// A block that a lattice fits exactly: its cells, and its surface's vertices, are those of the block's own mesh.
SessionResult press_block(const std::string& body) {
  Scene s = scene_of_lattice();
  s.object.body = body;
  if (body == "lattice") s.object.lattice = SceneLattice{.edge = kCell, .nodes = {}};
  s.tool.path.press_drag = PressDrag{
      .at = std::array{0.011, 0.013}, .depth = 0.002, .press_time = 0.1, .direction = {1, 0.3, 0}, .speed = 0.02};
  s.object.model.element = "tet4";
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
              const std::string& cells = "tet4", double clamped = 1e-6) {
  BodyOptions options;
  options.object.mesh = "bar";
  options.object.body = body;
  const bool are_springs = cells == "springs";
  options.object.model.type = are_springs ? "msd" : "fem";
  options.object.model.material = "linear";
  options.object.model.poisson = are_springs ? 0.25 : 0;
  if (!are_springs) options.object.model.element = cells;
  options.object.fixed.below = FixedBelow{"z", clamped};
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

/// Bar of 20 mm, plate 60 mm wide.
/// @param off  the plate's deflection over a beam's may be by
void expect_bends(const std::string& cells, double edge, double plate, double off) {
  const auto all = [](const Vec3&) { return true; };
  const auto deflection = [&](const Mesh& mesh) {
    return yields(mesh, "lattice", edge, kTurn * Vec3::UnitX(), all, cells);
  };
  EXPECT_NEAR(deflection(turned_bar()), beam(0.02, 0.02), 0.08 * beam(0.02, 0.02)) << edge;
  EXPECT_NEAR(deflection(turned_bar(2, 24, plate)), beam(plate, 0.06), off * beam(plate, 0.06)) << edge;
}

/// A bar's as wide as it is, a plate's five times as thick.
TEST(LatticeBody, BendsAsABarAndAPlateDoInTenNodeCells) {
  for (const double edge : {0.02, 0.01}) expect_bends("tet10", edge, 0.004, 0.2);
}

/// A bar of two to three cubes, a plate of 0.8 and 1.3.
TEST(LatticeBody, BendsAsABarAndAPlateDoInCubes) {
  for (const double edge : {0.01, 0.006}) expect_bends("hex8", edge, 0.008, 0.25);
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

/// The part of a ball of 50 mm between two heights, in cells along each of the three.
Mesh barrel(int wide, int high, double low) {
  constexpr double kTop = 0.08, kMiddle = 0.05, kRadius = 0.05;
  Mesh out = kuhn_block(wide, wide, high, 1);
  for (int i = 0; i < out.num_nodes(); ++i) {
    const Vec3 p = node(out.x, i);
    const double x = 2 * p.x() / wide - 1, y = 2 * p.y() / wide - 1, z = low + (kTop - low) * p.z() / high;
    const double radius = std::sqrt(kRadius * kRadius - (z - kMiddle) * (z - kMiddle));
    node(out.x, i) = Vec3(radius * x * std::sqrt(1 - 0.5 * y * y), radius * y * std::sqrt(1 - 0.5 * x * x), z);
  }
  return out;
}

/// A round body stands on what is clamped of it, however narrow it is below that, and wherever the cubes lie: it yields
/// as what is above does, clamped at its base.
TEST(LatticeBody, IsClampedUpToWhereTheClampEnds) {
  constexpr double kBottom = 0.002, kClamp = 0.02, kShare = (kClamp - kBottom) / (0.08 - kBottom);
  const auto all = [](const Vec3&) { return true; };
  const Mesh whole = barrel(20, 26, kBottom);
  for (const Vec3& direction : {Vec3(Vec3::UnitX()), Vec3(-Vec3::UnitZ())}) {
    const double truth = yields(barrel(8, 8, kClamp), "mesh", 0, direction, all, "tet10");
    for (const char* cells : {"tet10", "hex8"})
      for (const double edge : {0.024, 0.017, 0.011}) {
        const double its = yields(whole, "lattice", edge, direction, all, cells, kShare);
        EXPECT_LT(its, 1.05 * truth) << cells << ' ' << edge << ' ' << direction.transpose();
        EXPECT_GT(its, (cells == std::string("tet10") ? 0.9 : 0.8) * truth)
            << cells << ' ' << edge << ' ' << direction.transpose();
      }
  }
}

/// A clamp that is smaller than a cube holds a cell, and not one node, about which the body would turn.
TEST(LatticeBody, IsHeldByAClampSmallerThanACube) {
  BodyOptions options;
  options.object.mesh = "ball";
  options.object.body = "lattice";
  options.object.model.type = "fem";
  options.object.lattice = SceneLattice{.edge = 0.024, .nodes = {}};
  options.object.fixed.below.reset();
  for (const double width : {0.005, 1.0}) {  // along x: a spot, a line
    options.object.fixed.box = std::array{Vec3(-width, -0.005, -1), Vec3(width, 0.005, 0.008)};
    const Body body(surface_of(barrel(20, 26, 0.002)), options);
    const DeformableModel& own = body.model().own();
    Mat3 spread = Mat3::Zero();
    const int first = own.fixed_nodes().front();
    for (const int i : own.fixed_nodes()) {
      const Vec3 off = node(own.mesh().x, i) - node(own.mesh().x, first);
      spread += off * off.transpose();
    }
    EXPECT_GT(spread.determinant(), 1e-16) << width;
  }
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
  for (const auto& [type, element] : {std::pair("fem", "tet4"), {"fem", "tet10"}, {"fem", "hex8"}, {"msd", "tet4"}}) {
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
  EXPECT_EQ(thin->finding.cures.at(0).value, "hex8");
  EXPECT_FALSE(said(hollow, "tet10"));
  const auto cubes = said(hollow, "hex8");  // a third of a cube
  ASSERT_TRUE(cubes);
  EXPECT_LT(*cubes->finding.value, *thin->finding.value);
  EXPECT_EQ(cubes->finding.cures.size(), 1u);
  options.object.model.element = "auto";
  const auto nodes = [&](const Mesh& surface) {
    return Body(surface, options).model().info().parameters.at("nodes_per_element");
  };
  EXPECT_EQ(nodes(ball), 4);
  EXPECT_EQ(nodes(hollow), 8);
  for (const double poisson : {0.45, 0.46, 0.49}) {
    options.object.model.poisson = poisson;
    EXPECT_EQ(nodes(ball), poisson > 0.45 ? 10 : 4) << poisson;
  }
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
