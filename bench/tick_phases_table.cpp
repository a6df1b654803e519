// What collision detection costs in one tick: tools of every shape against a few moving triangles, in the phases that a
// touch goes through.
//   build/release/bench/tick_phases_table [--ticks N] [--backend NAME]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <string>

#include "collision/held/first_contact.hpp"
#include "tests/support/tool_shapes.hpp"

namespace kt {
namespace {

constexpr double kEdge = 2e-3, kStep = 5e-5;  // [m] of a quad, and of the tool in a tick: 50 mm/s
constexpr int kRepeat = 5;                    // the least of them is the tick's time: the rest is the scheduler's

struct Sheet {
  std::vector<Triangle> triangles;
  VectorX x;
};

/// nx x ny quads in the plane z = 0, uneven by `bumps` [m].
Sheet sheet(int nx, int ny, double bumps, std::mt19937_64& random) {
  Sheet out;
  std::uniform_real_distribution<double> bump(-bumps, bumps);
  out.x.resize(3 * (nx + 1) * (ny + 1));
  for (int i = 0; i <= nx; ++i)
    for (int k = 0; k <= ny; ++k) {
      const int a = i * (ny + 1) + k, b = a + ny + 1;
      node(out.x, a) = Vec3(kEdge * (i - 0.5 * nx), kEdge * (k - 0.5 * ny), bump(random));
      if (i == nx || k == ny) continue;
      out.triangles.push_back({a, b, b + 1});
      out.triangles.push_back({a, b + 1, a + 1});
    }
  return out;
}

struct Phase {
  const char* name;
  double gap, way;  // [m] before the tick, and towards the surface during it
  bool surface_moves = false, hits = false;
};

constexpr Phase kPhases[] = {
    {"free", 1e-4, 0},
    {"impact", 2e-5, 4e-5, false, true},
    {"resting, gap 1e-9, sliding", 1e-9, 0},
    {"the same, surface moves", 1e-9, 0, true},
    {"gap 0, sliding in the plane", 0, 0},
    {"separating", 0, -4e-5},
};

struct Row {
  std::vector<double> us;
  int hits = 0;
};

Row measure(const ToolShape& shape, double height, const Phase& phase, int nx, int ny, int ticks,
            const std::string& backend) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Sheet body = sheet(nx, ny, 0, random);
  const auto index = make_triangle_index(backend);
  index->build(body.triangles, body.x);
  MovingTool tool(shape);
  std::vector<int> scratch(body.triangles.size());
  Row out;
  VectorX x_t0 = body.x, x_t1 = body.x;
  for (int i = 0; i < ticks; ++i) {
    const Vec3 drift =
        phase.surface_moves ? Vec3(2e-5 * unit(random), 2e-5 * unit(random), 3e-5 * unit(random)) : Vec3(Vec3::Zero());
    for (int k = 0; k < x_t1.size() / 3; ++k) node(x_t1, k) = node(x_t0, k) + drift;
    const Vec3 from(kEdge * unit(random), kEdge * unit(random), height + phase.gap);
    const double heading = M_PI * unit(random);
    const Vec3 way(kStep * std::cos(heading), kStep * std::sin(heading), -phase.way + drift.z());
    double least = 1e300;
    std::optional<Contact> hit;
    for (int k = 0; k < kRepeat; ++k) {
      const auto start = std::chrono::steady_clock::now();
      tool.move({from, from + way});
      index->refit(x_t0, x_t1);
      hit = find_first_contact(*index, {body.triangles, x_t0, x_t1}, tool, {}, scratch);
      least =
          std::min(least, std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
    }
    out.hits += hit.has_value();
    out.us.push_back(least);
  }
  std::ranges::sort(out.us);
  return out;
}

int run(int ticks, const std::string& backend) {
  struct Tool {
    const char* name;
    ToolShape shape;
    double height;  // of the reference point over a plane that it touches
  };
  const Tool tools[] = {{"point", {}, 0},
                        {"sphere", {ToolShape::Kind::sphere, 2e-3}, 2e-3},
                        {"capsule", lying_capsule(2e-3, 6e-3), 2e-3},
                        {"mesh", box_tool({3e-3, 2e-3, 1e-3}, 4, 5e-4), 1.5e-3}};
  int wrong = 0;
  std::printf("refit and first contact, %s, us: median, p99 (hits of %d ticks)\n", backend.c_str(), ticks);
  std::printf("%-28s", "");
  for (const int n : {24, 200})
    for (const Tool& tool : tools) std::printf(" %13s x %-10d", tool.name, n);
  std::printf("\n");
  for (const Phase& phase : kPhases) {
    std::printf("%-28s", phase.name);
    for (const int n : {24, 200})
      for (const Tool& tool : tools) {
        const Row row = measure(tool.shape, tool.height, phase, n == 24 ? 3 : 10, n == 24 ? 4 : 10, ticks, backend);
        std::printf(" %6.2f %7.2f (%5d)   ", row.us[row.us.size() / 2], row.us[row.us.size() * 99 / 100], row.hits);
        if (phase.hits != (row.hits == ticks) || (!phase.hits && phase.way < 0 && row.hits > 0))
          wrong += phase.way != 0;
      }
    std::printf("\n");
  }
  if (wrong > 0) std::printf("%d cells miss an impact, or lock on separating\n", wrong);
  return wrong > 0 ? 1 : 0;
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  int ticks = 2000;
  std::string backend = "refit_bvh";
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::string(argv[i]) == "--ticks") ticks = std::stoi(argv[i + 1]);
    if (std::string(argv[i]) == "--backend") backend = argv[i + 1];
  }
  return kt::run(ticks, backend);
}
