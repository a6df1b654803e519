// Soft bodies pressed, sheared, folded, stacked and thrown for a thousand global steps: intersections (found by CGAL),
// momentum, kinetic energy, what Newton's method took, time.
//   build/release/bench/self_contact_table [--steps N] [--every N] [--scene N]     every: steps between two searches
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <string>

#include "bench/pressed_bodies.hpp"
#include "io/surface/mesh_doctor.hpp"

namespace kt {
namespace {

struct Options {
  int steps = 1000, every = 1, scene = 0;
};

std::size_t intersections(const PressedBodies& scene) {
#if KT_WITH_CGAL
  Mesh now = scene.model->mesh();
  now.x = scene.state.x;
  bool complete = false;
  return find_self_intersections(now, 1000, complete).size();
#else
  (void)scene;
  return 0;
#endif
}

Vec3 momentum(const PressedBodies& scene) {
  const VectorX p = scene.model->mass() * scene.state.v;
  return p.reshaped(3, p.size() / 3).rowwise().sum();
}

double kinetic_energy(const PressedBodies& scene) {
  return 0.5 * scene.state.v.dot(scene.model->mass() * scene.state.v);
}

void run(PressedBodies scene, const Options& options) {
  SelfContact contact(*scene.model, {.mu = 0.3});
  TouchingEuler integrator(contact, {.convergence = 1e-9});
  std::size_t met = intersections(scene);
  int contacts = 0;
  double nearest = std::numeric_limits<double>::infinity(), slowest = 0, seconds = 0;
  const Vec3 momentum_before = momentum(scene);
  const double energy_before = kinetic_energy(scene);
  for (int i = 1; i <= options.steps; ++i) {
    const auto start = std::chrono::steady_clock::now();
    scene.step(integrator);
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    seconds += took;
    slowest = std::max(slowest, took);
    contacts = std::max(contacts, integrator.report().contacts);
    nearest = std::min(nearest, integrator.report().nearest);
    if (i % options.every == 0) met += intersections(scene);
  }
  const StepStatistics s = integrator.statistics();
  std::printf("%-31s %5d %6d | %13zu | %8d %8.1e | %6.1f %6d | %7.0f %7.0f", scene.name.c_str(),
              scene.model->mesh().num_nodes(), options.steps, met, contacts, nearest,
              static_cast<double>(s.iterations) / options.steps, s.not_converged, 1e3 * seconds / options.steps,
              1e3 * slowest);
  if (scene.holds.empty() && scene.model->fixed_nodes().empty()) {
    const double scale = std::sqrt(2 * energy_before * scene.model->mass().diagonal().sum() / 3);
    std::printf(" | %8.1e %10.2f", (momentum(scene) - momentum_before).norm() / scale,
                kinetic_energy(scene) / energy_before);
  }
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  CLI::App app;
  app.add_option("--steps", options.steps)->check(CLI::PositiveNumber);
  app.add_option("--every", options.every)->check(CLI::PositiveNumber);
  app.add_option("--scene", options.scene)->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  std::printf("%-31s %5s %6s | %13s | %8s %8s | %6s %6s | %7s %7s | %8s %10s\n", "scene", "nodes", "steps",
              "intersections", "contacts", "nearest", "Newton", "not", "ms a", "slowest", "momentum", "kinetic");
  std::printf("%-31s %5s %6s | %13s | %8s %8s | %6s %6s | %7s %7s | %8s %10s\n", "", "", "", "", "at most", "[m]",
              "a step", "conv.", "step", "", "drift", "energy left");
  const std::function<kt::PressedBodies()> scenes[] = {
      [] { return kt::sheared_blocks(); }, [] { return kt::folded_sheet(); }, [] { return kt::stacked_blocks(); },
      [] { return kt::flying_blocks(); }};
  for (int k = 0; k < 4; ++k)
    if (options.scene == 0 || options.scene == k + 1) kt::run(scenes[k](), options);
}
