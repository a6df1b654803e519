// What a fine patch in series with coarse cells is worth, before it is in a tick: a sphere of 8 mm pressed at rest into
// a bonded block of 60 x 60 mm, force over the continuum's, of the coarse cells as they are and with the patch, over
// four places in a cell (node, edge, diagonal, face) and three depths; then what a zone takes of the processor, by
// stage. One row a line.
//   build/release/bench/fine_press_table [force] [time]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "core/base/percentile.hpp"
#include "core/base/stages.hpp"
#include "tests/support/fine_press.hpp"

namespace kt {
namespace {

struct Row {
  const char* name;
  PressBlockOptions block;
  FinePress press;
};

const Row kRows[] = {
    {"tet4 5 mm, 1.0 a", {}, {.fineness = 1.0}},
    {"tet4 5 mm, 0.7 a", {}, {}},
    {"tet4 5 mm, 0.7 a, 2.1 cells", {}, {.cells_around = 2.1}},
    {"tet4 5 mm, 0.5 a", {}, {.fineness = 0.5, .most_nodes = 5000}},
    {"tet4 5 mm, 0.7 a, 2.5 mm of way", {}, {.travel = 0.0025}},
    {"tet4 6.7 mm, 0.7 a", {.cell = 0.02 / 3}, {}},
    {"tet4 10 mm, 0.7 a", {.cell = 0.01}, {}},
    {"tet4 5 mm shaken, 0.7 a", {.shaken = 0.25}, {}},
    {"tet4 5 mm, layer 10 mm, 0.7 a", {.thickness = 0.01}, {}},
    {"tet4 5 mm, layer 5 mm, 0.7 a", {.thickness = 0.005}, {}},
    {"tet4 5 mm, layer 3 mm, 0.7 a", {.thickness = 0.003}, {}},
    {"springs 5 mm, 0.7 a", {.model = "msd"}, {}},
    {"springs 5 mm shaken, 0.7 a", {.model = "msd", .shaken = 0.25}, {}},
    {"tet4 5 mm, nu 0.45, 2.1 cells", {.poisson = 0.45}, {.cells_around = 2.1}},
    {"tet10 10 mm, nu 0.3, 0.7 a", {.element = "tet10", .cell = 0.01}, {}},
    {"tet10 10 mm, nu 0.45, 0.7 a", {.element = "tet10", .cell = 0.01, .poisson = 0.45}, {}},
    {"tet10 10 mm, nu 0.49, 0.7 a", {.element = "tet10", .cell = 0.01, .poisson = 0.49}, {}},
    {"tet10 10 mm, nu 0.49, 0.5 a",
     {.element = "tet10", .cell = 0.01, .poisson = 0.49},
     {.fineness = 0.5, .most_nodes = 5000}},
};

struct Range {
  double least = 1e9, most = -1e9;
  void add(double x) { least = std::min(least, x), most = std::max(most, x); }
};

void print_forces() {
  std::printf("%-34s %8s  %-13s %-13s %-11s %-9s %s\n", "body, leaves", "depth", "coarse", "with patch", "nodes",
              "leaf / a", "least eigenvalue");
  for (const Row& row : kRows) {
    const PressBlock block(row.block);
    for (const double depth : {0.0005, 0.0015, 0.003}) {
      Range coarse, fine, nodes, fineness, least;
      for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.5, 0.0}, {0.5, 0.5}, {0.3333, 0.6667}}) {
        FinePress press = row.press;
        press.depth = depth;
        press.x = x;
        press.y = y;
        const FinePressed p = press_fine(block, press);
        coarse.add(p.coarse);
        fine.add(p.fine);
        nodes.add(p.unknown);
        fineness.add(p.fineness);
        least.add(p.least);
      }
      std::printf("%-34s %5.1f mm  %5.2f - %5.2f %5.3f - %5.3f %4.0f - %4.0f  %.2f-%.2f %9.1e\n", row.name, 1e3 * depth,
                  coarse.least, coarse.most, fine.least, fine.most, nodes.least, nodes.most, fineness.least,
                  fineness.most, least.least);
      std::fflush(stdout);
    }
  }
}

double median_of(const StageTimes& times, const std::string& stage) {
  std::vector<double> all;
  for (const StageTimes::Row& row : times.rows())
    for (const auto& [name, ms] : row)
      if (name == "fine." + stage) all.push_back(ms);
  return percentile(all, 0.5);
}

/// Medians over some zones; "order" is what the first factor of a zone takes longer than the next one of it.
void print_times() {
  std::printf("%-34s %8s %6s %6s %6s  CPU time by stage, median [ms]\n", "body, leaves", "depth", "nodes", "inner",
              "in reach");
  for (const Row& row : kRows) {
    const PressBlock block(row.block);
    const State rest = rest_state(block.model());
    for (const double depth : {0.0005, 0.0015, 0.003}) {
      StageTimes first, again;
      FineZone zone;
      for (int i = 0; i < 9; ++i) {
        const FineZoneOptions options = press_options(block, [&] {
          FinePress press = row.press;
          press.depth = depth;
          press.x = 0.1 * i;
          return press;
        }());
        const auto solver = make_block_solver();
        for (StageTimes* times : {&first, &again}) {
          StageTimes::asked() = times;
          zone = make_fine_zone(block.body(), options);
          find_yield(block.body(), zone, {rest}, block.dfdx(), *solver);
          StageTimes::asked() = nullptr;
          times->close();
        }
      }
      std::printf("%-34s %5.1f mm %6d %6zu %6d ", row.name, 1e3 * depth, zone.num_unknown(), zone.inner.size(),
                  zone.num_yielding);
      double sum = 0;
      for (const char* stage : {"zone", "matrices", "factor", "inverse", "coarse", "definite"}) {
        sum += median_of(again, stage);
        std::printf(" %s %.2f", stage, median_of(again, stage));
      }
      std::printf(" sum %.1f; order %.2f\n", sum, median_of(first, "factor") - median_of(again, "factor"));
      std::fflush(stdout);
    }
  }
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  const auto asks = [&](const char* what) {
    return argc == 1 || std::any_of(argv + 1, argv + argc, [&](const char* a) { return std::strcmp(a, what) == 0; });
  };
  if (asks("force")) kt::print_forces();
  if (asks("time")) kt::print_times();
}
