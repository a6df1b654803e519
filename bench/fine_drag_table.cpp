// Drags of 42 mm through the whole engine without friction, refined and with the cells as they are, against the same
// body with fine cells: at places along the way the same tetrahedra, halved around the tool until their edges are a
// third of the contact's radius, with ten nodes, and the ball pressed in at rest.
//   fine_drag_table [block] [organ]
// The block is one of 80 x 60 x 20 mm, bonded below, in cells of 5 mm. The organ is that of scenes/organ_drag.json.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <map>
#include <queue>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "collision/shape/closest_point.hpp"
#include "core/body/mesh.hpp"
#include "haptics/body/body.hpp"
#include "haptics/session/session.hpp"
#include "lab/study/press.hpp"

namespace kt {
namespace {

using Edge = std::pair<int, int>;

Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

constexpr std::array<std::array<int, 2>, 6> kEdges{{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// The same tetrahedra, the longest edges halved first, until none is longer than its target at its middle.
template <class Target>
Mesh split_near(const Mesh& coarse, Target target) {
  std::vector<Vec3> at;
  for (int i = 0; i < coarse.num_nodes(); ++i) at.push_back(node(coarse.x, i));
  std::vector<Tetrahedron> cells = coarse.tetrahedra;
  std::map<Edge, std::set<int>> around;
  std::priority_queue<std::pair<double, Edge>> too_long;
  const auto add = [&](int cell) {
    for (const auto& [a, b] : kEdges) {
      const Edge e = edge_of(cells[cell][a], cells[cell][b]);
      if (around[e].insert(cell).second && around[e].size() == 1) {
        const double length = (at[e.first] - at[e.second]).norm();
        if (length > target(0.5 * (at[e.first] + at[e.second]))) too_long.emplace(length, e);
      }
    }
  };
  for (int c = 0; c < static_cast<int>(cells.size()); ++c) add(c);
  while (!too_long.empty()) {
    const Edge e = too_long.top().second;
    too_long.pop();
    const auto found = around.find(e);
    if (found == around.end()) continue;
    const std::set<int> split = found->second;
    const int middle = static_cast<int>(at.size());
    at.push_back(0.5 * (at[e.first] + at[e.second]));
    for (const int c : split)
      for (const auto& [a, b] : kEdges) around[edge_of(cells[c][a], cells[c][b])].erase(c);
    around.erase(e);
    for (const int c : split) {
      Tetrahedron other = cells[c];
      std::ranges::replace(cells[c], e.first, middle);
      std::ranges::replace(other, e.second, middle);
      cells.push_back(other);
      add(c);
      add(static_cast<int>(cells.size()) - 1);
    }
  }
  Mesh out;
  out.x.resize(3 * static_cast<Eigen::Index>(at.size()));
  for (int i = 0; i < static_cast<int>(at.size()); ++i) node(out.x, i) = at[static_cast<std::size_t>(i)];
  out.tetrahedra = std::move(cells);
  out.triangles = boundary_triangles(out.tetrahedra);
  return out;
}

/// The force of a ball at rest on fine cells.
/// @param normal  from the body to the ball
double fine_force(const Mesh& coarse, BodyOptions options, const Vec3& centre, const Vec3& normal, double radius,
                  int& nodes) {
  constexpr double kFinest = 1.0 / 3, kGrowth = 0.7;
  double nearest_sq = std::numeric_limits<double>::infinity();
  for (const Triangle& t : coarse.triangles)
    nearest_sq = std::min(
        nearest_sq, closest_point_on_triangle(centre, node(coarse.x, t[0]), node(coarse.x, t[1]), node(coarse.x, t[2]))
                        .distance_sq);
  const double depth = radius - std::sqrt(nearest_sq), contact = std::sqrt(radius * depth);
  const Vec3 touched = centre - (radius - depth) * normal;
  Mesh fine = split_near(
      coarse, [&](const Vec3& p) { return std::max(kFinest * contact, kGrowth * ((p - touched).norm() - contact)); });
  nodes = fine.num_nodes();
  options.object.model.element = "tet10";
  options.object.size.reset();
  const Body body(std::move(fine), options);
  const PressResult r = press(body.model(), body.start(), {centre + depth * normal, centre, radius},
                              {.young = options.object.model.young});
  if (!r.settled) std::puts("the press did not settle");
  return r.force.norm();
}

void print_drag(const char* name, Scene scene, const Mesh* mesh, double from, double to) {
  constexpr int kPlaces = 9;
  scene.contact.mu_static = scene.contact.mu_kinetic = 0;
  std::vector<std::vector<LocalFrame>> runs;
  Mesh coarse;
  BodyOptions options = body_options(scene);
  for (const char* refine : {"off", "auto"}) {
    scene.local.refine = refine;
    Session session = mesh ? Session(scene, *mesh) : Session(scene);
    coarse = session.model().mesh();
    const SessionResult r = session.run();
    runs.emplace_back(r.tools[0].frames.begin(), r.tools[0].frames.end());
  }
  std::printf("\n%s: %d nodes\n| t s | fine cells N | as they are | refined |\n|---|---|---|---|\n", name,
              coarse.num_nodes());
  std::array<double, 2> least{1e9, 1e9}, most{}, sum{};
  int nodes = 0;
  for (int i = 0; i < kPlaces; ++i) {
    const double t = from + (to - from) * i / (kPlaces - 1);
    const auto tick = static_cast<std::size_t>(std::lround(1e3 * t)) - 1;
    const LocalFrame& at = runs[1][tick];
    const double truth = fine_force(coarse, options, at.pose.x, at.force.normalized(), scene.tool.radius, nodes);
    std::printf("| %.2f | %.4f |", t, truth);
    for (std::size_t k = 0; k < 2; ++k) {
      const double factor = runs[k][tick].force.norm() / truth;
      std::printf(" %.3f |", factor);
      least[k] = std::min(least[k], factor);
      most[k] = std::max(most[k], factor);
      sum[k] += factor;
    }
    std::puts("");
    std::fflush(stdout);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    double step = 0, mean = 0;
    int ticks = 0;
    for (auto i = static_cast<std::size_t>(1e3 * from); i < static_cast<std::size_t>(1e3 * to); ++i) {
      step = std::max(step, (runs[k][i].force - runs[k][i - 1].force).norm());
      mean += runs[k][i].force.norm();
      ++ticks;
    }
    std::printf("%s: factor %.3f to %.3f, mean %.3f; largest step of a tick %.1f %% of the mean force\n",
                k ? "refined" : "as they are", least[k], most[k], sum[k] / kPlaces, 100 * step * ticks / mean);
  }
  std::printf("fine cells: %d nodes at the last place\n", nodes);
}

void drag_over_the_block() {
  constexpr double kCell = 0.005;
  const Mesh mesh = kuhn_block(16, 12, 4, kCell);
  for (const double depth : {0.0015, 0.003}) {
    Scene s = default_scene();
    s.object.mesh = std::string("block");
    s.object.model.type = "fem";
    s.object.model.material = std::string("linear");
    s.object.fixed.below = FixedBelow{"z", 1e-6};
    s.tool.radius = 0.008;
    s.tool.path.press_drag = PressDrag{
        .at = std::array{0.02, 0.0312}, .depth = depth, .press_time = 0.3, .direction = {1, 0.05, 0}, .speed = 0.03};
    s.duration = 1.7;
    print_drag(depth < 0.002 ? "block, 1.5 mm deep" : "block, 3 mm deep", s, &mesh, 0.45, 1.65);
  }
}

void drag_over_the_organ() {
  Scene s = load_scene(KT_SOURCE_DIR "/scenes/organ_drag.json");
  s.duration = 1.7;
  print_drag("organ, 3 mm deep", s, nullptr, 0.45, 1.65);
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  const auto asks = [&](const char* what) {
    return argc == 1 || std::any_of(argv + 1, argv + argc, [&](const char* a) { return std::strcmp(a, what) == 0; });
  };
  if (asks("block")) kt::drag_over_the_block();
  if (asks("organ")) kt::drag_over_the_organ();
}
