// Refined cells against a body that is fine everywhere and is stepped as a whole (lab/study/full_simulation.hpp): tools
// that are no balls, large strain, and the answer to vibration.
//   fine_reference_table [cells across the reference [presses | strain | vibration]]
// A block of 60 x 60 x 20 mm bonded below, 10 kPa, nu = 0.3, small strains, no friction. The reference has cells of ten
// nodes, 1.2 mm under the tool; the ball's force on it against the continuum's says how far it is off itself. The
// engine has cells of four nodes, 5 and 10 mm, refreshed 30 times a second in lockstep.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>

#include "haptics/body/body.hpp"
#include "haptics/contact/projection.hpp"
#include "haptics/touch/touch.hpp"
#include "lab/study/full_simulation.hpp"
#include "lab/study/press.hpp"
#include "tests/support/axisymmetric_press.hpp"
#include "tests/support/tool_shapes.hpp"

namespace kt {
namespace {

constexpr double kWide = 0.06, kThick = 0.02, kTick = 1e-3;

/// Where the tool touches cells are smaller than the mean by this.
constexpr double kCentre = 0.35;

/// From -1..1 to -1..1, cells in the middle kCentre of the mean.
double graded(double u) { return kCentre * u + (1 - kCentre) * u * u * u; }

/// A block of `wide` x `wide` x wide / 3 cells, small ones in the middle of its upper side.
Mesh reference_block(int wide) {
  const int thick = wide / 3;
  Mesh out = kuhn_block(wide, wide, thick, 1);
  for (int i = 0; i < out.num_nodes(); ++i) {
    const Vec3 at = node(out.x, i);
    node(out.x, i) = Vec3(0.5 * kWide * (1 + graded(2 * at.x() / wide - 1)),
                          0.5 * kWide * (1 + graded(2 * at.y() / wide - 1)), kThick * (1 + graded(at.z() / thick - 1)));
  }
  return out;
}

Body block(Mesh mesh, const char* element, double retardation, const char* material = "linear") {
  BodyOptions o;
  o.object.model.type = "fem";
  o.object.model.material = material;
  o.object.model.element = element;
  o.object.model.damping.stiffness = retardation;
  o.object.fixed.below = FixedBelow{"z", 1e-6};
  return Body(std::move(mesh), o);
}

Body coarse_block(double cell, double retardation) {
  const int wide = static_cast<int>(std::lround(kWide / cell));
  return block(kuhn_block(wide, wide, static_cast<int>(std::lround(kThick / cell)), cell), "tet4", retardation);
}

struct ShapedTool {
  const char* name;
  ToolShape shape;
  double above;  ///< of its centre over its lowest point [m]
};

/// The height of a tool's centre at each tick.
using Heights = std::vector<double>;

Pose at(double height) { return {Vec3(0.5 * kWide + 0.0007, 0.5 * kWide + 0.0011, height), Quaternion::Identity()}; }

std::vector<double> by_engine(const Body& body, const ToolShape& shape, const Heights& heights, const char* refine) {
  TouchOptions o;
  o.tools[0].shape = shape;
  o.contact.mu_static = o.contact.mu_kinetic = 0;
  o.contact.surface = "flat";
  o.local.refine = refine;
  o.local.reducer = "condensed";
  Touch touch(body, o);
  touch.place(at(heights[0]));
  std::vector<double> out;
  for (const double h : heights) out.push_back(touch.tick(at(h)).force.z());
  return out;
}

/// @param steps  of each tick; its step is one of implicit Euler, which damps what is fast
std::vector<double> by_reference(const Body& body, const ToolShape& shape, const Heights& heights, int steps) {
  FullOptions o;
  o.h = kTick / steps;
  o.matrix_time = 1e3;  // of small strains there is one matrix
  FullSimulation full(body.model(), body.surface(), {&shape, 1}, make_contact_solver("coulomb", {0, 0}), o,
                      body.start());
  std::vector<double> out;
  double from = heights[0];
  for (const double to : heights) {
    double sum = 0;  // a tick's force is the mean over it
    for (int i = 0; i < steps; ++i)
      sum += full.step({at(from + (to - from) * i / steps), at(from + (to - from) * (i + 1) / steps)}).force.z();
    out.push_back(sum / steps);
    from = to;
  }
  return out;
}

Heights pressed(const ShapedTool& tool, double depth) {
  Heights out;
  for (int i = 0; i <= 300; ++i) out.push_back(kThick + tool.above + 1e-4 - (depth + 1e-4) * std::min(1.0, i / 150.0));
  return out;
}

double ball_truth(double radius, double depth) {
  return press_axisymmetric({.young = 1e4,
                             .poisson = 0.3,
                             .thickness = kThick,
                             .width = kWide / std::sqrt(std::numbers::pi),
                             .radius = radius,
                             .depth = depth,
                             .cells = 16,
                             .follows = true})
      .force;
}

void print_presses(int wide) {
  const Body fine = block(reference_block(wide), "tet10", 0.005), five = coarse_block(0.005, 0.005),
             ten = coarse_block(0.01, 0.005);
  const ToolShape ball{ToolShape::Kind::sphere, 0.008};
  const ShapedTool tools[] = {
      {"ball of 8 mm", ball, 0.008},
      {"capsule of 4 x 20 mm, lying", lying_capsule(0.004, 0.02), 0.004},
      {"capsule of 4 x 20 mm, upright", make_capsule(0.004, 0.02), 0.014},
      {"ball of 8 mm in 224 triangles", ball_tool(0.008, 8, 0.001), 0.008},
      {"box of 10 x 10 x 6 mm, rounded by 1 mm", box_tool({0.004, 0.004, 0.002}, 2, 0.001), 0.003}};
  std::puts("| tool | depth mm | reference N | 5 mm: as they are | refined | 10 mm: as they are | refined |");
  std::puts("|---|---|---|---|---|---|---|");
  for (const ShapedTool& tool : tools)
    for (const double depth : {0.0015, 0.003}) {
      const Heights way = pressed(tool, depth);
      const double truth = by_reference(fine, tool.shape, way, 1).back();
      std::printf("| %s | %.1f | %.4f |", tool.name, 1e3 * depth, truth);
      for (const Body* body : {&five, &ten})
        for (const char* refine : {"off", "follow"})
          std::printf(" %.2f |", by_engine(*body, tool.shape, way, refine).back() / truth);
      if (tool.shape.kind == ToolShape::Kind::sphere)
        std::printf("  reference over the continuum %.3f", truth / ball_truth(0.008, depth));
      std::printf("\n");
      std::fflush(stdout);
    }
}

/// A layer of half the thickness, of a material that stiffens, pressed in by a fifth and two fifths of it. The
/// reference is pressed in at rest.
void print_strain(int wide) {
  constexpr double kLayer = 0.5;
  const auto thinner = [](Mesh mesh) {
    for (int i = 0; i < mesh.num_nodes(); ++i) node(mesh.x, i).z() *= kLayer;
    return mesh;
  };
  const auto cubes = [](int across, int thick) { return kuhn_block(across, across, thick, kWide / across); };
  const auto body = [](Mesh mesh, const char* element) {
    return block(std::move(mesh), element, 0.005, "neo_hookean");
  };
  const Body fine = body(thinner(reference_block(wide)), "tet10"), five = body(cubes(12, 2), "tet4"),
             ten = body(cubes(6, 1), "tet10");
  const ShapedTool ball{"ball of 8 mm", {ToolShape::Kind::sphere, 0.008}, 0.008};
  std::puts(
      "\n| neo-Hookean layer of 10 mm, depth mm | reference N | 4 nodes, 5 mm: as they are | refined | 10 nodes, 10 "
      "mm: "
      "as they are | refined |\n|---|---|---|---|---|---|");
  for (const double depth : {0.002, 0.004}) {
    Heights way = pressed(ball, depth);
    for (double& height : way) height -= (1 - kLayer) * kThick;
    const Vec3 above(0.5 * kWide + 0.0007, 0.5 * kWide + 0.0011, kLayer * kThick + ball.above);
    const PressResult pressed_in =
        press(fine.model(), fine.start(), {above, above - depth * Vec3::UnitZ(), 0.008}, {.young = 1e4});
    if (!pressed_in.settled) std::puts("the reference did not settle");
    const double truth = pressed_in.force.z();
    std::printf("| %.0f | %.4f |", 1e3 * depth, truth);
    for (const Body* coarse : {&five, &ten})
      for (const char* refine : {"off", "follow"})
        std::printf(" %.2f |", by_engine(*coarse, ball.shape, way, refine).back() / truth);
    std::puts("");
    std::fflush(stdout);
  }
}

constexpr double kTones[] = {2, 5, 10, 20, 35, 50, 75, 100};  // [Hz]: whole numbers of periods in a second

/// A ball 1.5 mm deep that shakes by 20 um in each tone for a second, after half a second.
Heights shaken() {
  Heights out;
  for (int i = 0; i <= 1500; ++i) {
    double z = kThick + 0.008 + 1e-4 - 0.0016 * std::min(1.0, i / 250.0);
    if (i > 500)
      for (std::size_t k = 0; k < std::size(kTones); ++k)
        z +=
            2e-5 * std::sin(2 * std::numbers::pi * (kTones[k] * (i - 500) * kTick + 0.37 * static_cast<double>(k * k)));
    out.push_back(z);
  }
  return out;
}

std::complex<double> tone(const std::vector<double>& signal, double hz) {
  std::complex<double> out = 0;
  for (int i = 501; i <= 1500; ++i)
    out += signal[static_cast<std::size_t>(i)] *
           std::polar(1.0, -2 * std::numbers::pi * hz * static_cast<double>(i - 500) * kTick);
  return out / 500.0;
}

void print_impedance(int wide, double retardation) {
  const ToolShape ball{ToolShape::Kind::sphere, 0.008};
  const Body fine = block(reference_block(wide), "tet10", retardation), five = coarse_block(0.005, retardation),
             ten = coarse_block(0.01, retardation);
  const Heights way = shaken();
  const std::vector<double> truth = by_reference(fine, ball, way, 4), refined5 = by_engine(five, ball, way, "follow"),
                            as5 = by_engine(five, ball, way, "off"), refined10 = by_engine(ten, ball, way, "follow");
  std::printf(
      "\nretardation %g ms\n| Hz | reference N/m, phase deg | 5 mm as they are | refined | phase deg | 10 mm refined | "
      "phase "
      "deg |\n|---|---|---|---|---|---|---|\n",
      1e3 * retardation);
  for (const double hz : kTones) {
    const std::complex<double> x = tone(way, hz), z = -tone(truth, hz) / x;
    const auto over = [&](const std::vector<double>& force) { return -tone(force, hz) / x / z; };
    const auto degrees = [](std::complex<double> v) { return std::arg(v) * 180 / std::numbers::pi; };
    std::printf("| %.0f | %.1f, %.1f | %.2f | %.3f | %+.1f | %.3f | %+.1f |\n", hz, std::abs(z), degrees(z),
                std::abs(over(as5)), std::abs(over(refined5)), degrees(over(refined5)), std::abs(over(refined10)),
                degrees(over(refined10)));
  }
  std::fflush(stdout);
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  const int wide = argc > 1 ? std::atoi(argv[1]) : 18;
  const std::string what = argc > 2 ? argv[2] : "";
  if (what.empty() || what == "presses") kt::print_presses(wide);
  if (what.empty() || what == "strain") kt::print_strain(wide);
  if (what.empty() || what == "vibration")
    for (const double retardation : {0.002, 0.01}) kt::print_impedance(wide, retardation);
}
