// Presses through the whole engine without friction: the force at rest with the body over the continuum's, with and
// without refined cells.
//   fine_touch_table [presses] [materials] [threads] [drags]
// A ball of 8 mm on a block of 60 x 60 x 20 mm bonded below, 10 kPa, nu = 0.3; at a node of the surface, in the middle
// of an edge, and within a triangle. Truth: the ball meets the body where it has moved to
// (tests/support/axisymmetric_press.hpp, `follows`). "materials" has other Poisson's ratios and layers, "threads" two
// threads in real time, the others are in lockstep. "drags": 20 mm at 20 mm/s along eight paths.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "core/body/mesh.hpp"
#include "haptics/session/session.hpp"
#include "tests/support/axisymmetric_press.hpp"
#include "tests/support/drag_ripple.hpp"

namespace kt {
namespace {

constexpr double kRadius = 0.008, kWide = 0.06;

struct Block {
  const char* name;
  const char* type;
  const char* element;
  double cell;
  double poisson = 0.3;
  double thick = 0.02;
  const char* link = "lockstep";
};

Scene scene_of(const Block& body, const PressDrag& path, double duration, const char* refine) {
  Scene s = default_scene();
  s.object.mesh = std::string("block");
  s.object.model.type = body.type;
  s.object.model.element = body.element;
  s.object.model.poisson = body.poisson;
  s.link.type = body.link;
  s.object.model.material = std::string("linear");
  s.object.fixed.below = FixedBelow{"z", 1e-6};
  s.tool.radius = kRadius;
  s.tool.path.press_drag = path;
  s.duration = duration;
  s.contact.mu_static = s.contact.mu_kinetic = 0;
  s.contact.surface = std::string("flat");
  s.local.refine = refine;
  s.local.reducer = std::string("condensed");
  return s;
}

SessionResult run(const Block& body, const Scene& scene) {
  const int wide = static_cast<int>(std::lround(kWide / body.cell)),
            thick = std::max(1, static_cast<int>(std::lround(body.thick / body.cell)));
  Mesh mesh = kuhn_block(wide, wide, thick, body.cell);
  for (int i = 0; i < mesh.num_nodes(); ++i) mesh.x[3 * i + 2] *= body.thick / (thick * body.cell);
  return Session(scene, std::move(mesh)).run();
}

double continuum(const Block& body, double depth) {
  return press_axisymmetric({.young = 1e4,
                             .poisson = body.poisson,
                             .thickness = body.thick,
                             .width = kWide / std::sqrt(3.14159265358979323846),
                             .radius = kRadius,
                             .depth = depth,
                             .cells = 16,
                             .follows = true})
      .force;
}

struct Pressed {
  double force = 0, tick_us = 0;
  int contacts = 0;
};

Pressed press(const Block& body, double depth, double x, double y, const char* refine) {
  const std::array at{0.5 * kWide + x * body.cell, 0.5 * kWide + y * body.cell};
  const SessionResult r =
      run(body, scene_of(body, PressDrag{.at = at, .depth = depth, .press_time = 0.3, .speed = 0}, 0.5, refine));
  std::vector<double> us(r.step_us.begin(), r.step_us.end());
  std::ranges::nth_element(us, us.begin() + static_cast<std::ptrdiff_t>(us.size() / 2));
  const LocalFrame& last = r.tools[0].frames.back();
  return {last.f_n, us[us.size() / 2], last.contacts};
}

void print_row(const Block& body, double depth) {
  const double truth = continuum(body, depth);
  std::printf("| %s | %.1f |", body.name, 1e3 * depth);
  for (const char* refine : {"off", "follow"}) {
    double tick_us = 0;
    int contacts = 0;
    for (const auto& [x, y] : {std::pair(0.0, 0.0), {0.5, 0.0}, {0.6, 0.3}}) {
      const Pressed p = press(body, depth, x, y, refine);
      std::printf(" %.2f", p.force / truth);
      tick_us = std::max(tick_us, p.tick_us);
      contacts = std::max(contacts, p.contacts);
    }
    std::printf(" | %d | %.0f |", contacts, tick_us);
  }
  std::printf("\n");
  std::fflush(stdout);
}

/// Over all paths: the mean force over the continuum's; peak to peak over the mean, mean and worst; largest step from
/// one tick to the next over the mean.
void print_drags(const Block& body, double depth, const char* refine) {
  constexpr std::size_t kSettled = 450;  // [ticks]
  double force = 0, ripple = 0, worst = 0, step = 0;
  int paths = 0;
  for (const double y : {0.030, 0.0312, 0.0325, 0.0337})
    for (const double aside : {0.0, 0.3}) {
      const PressDrag path{
          .at = std::array{0.02, y}, .depth = depth, .press_time = 0.3, .direction = {1, aside, 0}, .speed = 0.02};
      const SessionResult r = run(body, scene_of(body, path, 1.3, refine));
      const DragRipple found = drag_ripple({r.tools[0].frames.begin(), r.tools[0].frames.end()}, kSettled);
      force += found.mean;
      ripple += found.peak_to_peak;
      worst = std::max(worst, found.peak_to_peak);
      step = std::max(step, found.largest_step);
      ++paths;
    }
  std::printf("| %s | %.1f | %s | %.2f | %.1f | %.1f | %.1f |\n", body.name, 1e3 * depth, refine,
              force / paths / continuum(body, depth), 100 * ripple / paths, 100 * worst, 100 * step);
  std::fflush(stdout);
}

}  // namespace
}  // namespace kt

namespace kt {
namespace {

void print_presses(std::initializer_list<Block> blocks, std::initializer_list<double> depths) {
  std::puts(
      "| cells | depth mm | as they are: node, edge, within | contacts | tick us | refined | contacts | tick us |\n"
      "|---|---|---|---|---|---|---|---|");
  for (const Block& body : blocks)
    for (const double depth : depths) print_row(body, depth);
  std::puts("");
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  using kt::Block;
  const auto asks = [&](const char* what) {
    return argc == 1 || std::any_of(argv + 1, argv + argc, [&](const char* a) { return std::strcmp(a, what) == 0; });
  };
  const Block tet4{"4 nodes, 5 mm", "fem", "tet4", 0.005}, large{"4 nodes, 10 mm", "fem", "tet4", 0.01},
      tet10{"10 nodes, 10 mm", "fem", "tet10", 0.01};
  if (asks("presses"))
    kt::print_presses({tet4,
                       large,
                       {"10 nodes, 5 mm", "fem", "tet10", 0.005},
                       tet10,
                       {"springs, 5 mm", "msd", "tet4", 0.005},
                       {"springs, 10 mm", "msd", "tet4", 0.01}},
                      {0.0005, 0.0015, 0.003});
  if (asks("materials"))
    kt::print_presses({{"4 nodes, 5 mm, nu 0.4", "fem", "tet4", 0.005, 0.4},
                       {"4 nodes, 5 mm, nu 0.45", "fem", "tet4", 0.005, 0.45},
                       {"4 nodes, 5 mm, nu 0.48", "fem", "tet4", 0.005, 0.48},
                       {"4 nodes, 10 mm, nu 0.45", "fem", "tet4", 0.01, 0.45},
                       {"10 nodes, 10 mm, nu 0.4", "fem", "tet10", 0.01, 0.4},
                       {"10 nodes, 10 mm, nu 0.45", "fem", "tet10", 0.01, 0.45},
                       {"10 nodes, 10 mm, nu 0.49", "fem", "tet10", 0.01, 0.49},
                       {"4 nodes, 5 mm, layer 10 mm", "fem", "tet4", 0.005, 0.3, 0.01},
                       {"4 nodes, 5 mm, layer 5 mm", "fem", "tet4", 0.005, 0.3, 0.005},
                       {"4 nodes, 5 mm, layer 3 mm", "fem", "tet4", 0.005, 0.3, 0.003}},
                      {0.0005, 0.0015});
  if (asks("threads"))
    kt::print_presses({{"4 nodes, 5 mm, two threads", "fem", "tet4", 0.005, 0.3, 0.02, "thread"},
                       {"4 nodes, 10 mm, two threads", "fem", "tet4", 0.01, 0.3, 0.02, "thread"},
                       {"10 nodes, 10 mm, two threads", "fem", "tet10", 0.01, 0.3, 0.02, "thread"}},
                      {0.0005, 0.0015, 0.003});
  if (!asks("drags")) return 0;
  std::puts(
      "| cells | depth mm | local.refine | force / continuum | peak to peak % | worst | largest step % |\n"
      "|---|---|---|---|---|---|---|");
  for (const Block& body : {tet4, large})
    for (const double depth : {0.0005, 0.0015})
      for (const char* refine : {"off", "follow"}) kt::print_drags(body, depth, refine);
}
