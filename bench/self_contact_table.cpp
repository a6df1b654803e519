// Soft bodies pressed, sheared, folded and stacked for a thousand global steps: intersections (by CGAL), momentum,
// energy, time.
//   build/release/bench/self_contact_table [--steps N] [--every N]     every: steps between two searches by CGAL
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bench/pressed_bodies.hpp"
#include "io/mesh_doctor.hpp"

namespace kt {
namespace {

std::size_t intersections(const PressedBodies& scene) {
#if KT_WITH_CGAL
  Mesh now = scene.model->mesh();
  now.x = scene.state.x;
  bool complete = false;
  return find_self_intersections(now, 1000, complete).size();
#else
  return 0;
#endif
}

void run(PressedBodies scene, int steps, int every) {
  TouchingEuler integrator({.mu = 0.3}, {.convergence = 1e-6});
  std::size_t met = intersections(scene);
  int contacts = 0;
  double nearest = 1, drift = 0, slowest = 0, seconds = 0;
  for (int i = 1; i <= steps; ++i) {
    const State before = scene.state;
    const auto start = std::chrono::steady_clock::now();
    scene.step(integrator);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    seconds += took;
    slowest = std::max(slowest, took);
    contacts = std::max(contacts, integrator.report().contacts);
    nearest = std::min(nearest, integrator.report().nearest);
    if (i % every == 0) met += intersections(scene);
    if (getenv("KT_TRACE") && i % 10 == 0)
      std::printf("  %5d contacts %4d nearest %.2e normal %.3f N  iterations %d not converged %d  %.0f ms\n", i,
                  integrator.report().contacts, integrator.report().nearest, integrator.report().normal,
                  integrator.statistics().iterations, integrator.statistics().not_converged, 1e3 * took);
  }
  const StepStatistics s = integrator.statistics();
  std::printf(
      "%-34s %6d nodes %5d steps | intersections %zu | contacts <= %d, nearest %.1e m | Newton %.1f a step, "
      "%d not converged | %.0f ms a step, slowest %.0f\n",
      scene.name.c_str(), scene.model->mesh().num_nodes(), steps, met, contacts, nearest,
      static_cast<double>(s.iterations) / steps, s.not_converged, 1e3 * seconds / steps, 1e3 * slowest);
  std::fflush(stdout);
  (void)drift;
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  int steps = 1000, every = 1, only = 0;
  for (int i = 1; i + 1 < argc; i += 2) {
    if (std::string(argv[i]) == "--steps") steps = std::atoi(argv[i + 1]);
    if (std::string(argv[i]) == "--every") every = std::atoi(argv[i + 1]);
    if (std::string(argv[i]) == "--only") only = std::atoi(argv[i + 1]);
  }
  if (only == 0 || only == 1) kt::run(kt::sheared_blocks(), steps, every);
  if (only == 0 || only == 2) kt::run(kt::folded_sheet(), steps, every);
  if (only == 0 || only == 3) kt::run(kt::stacked_blocks(), steps, every);
}
