// The global half of a refresh: the step to the present, the step ahead, and the linearization there, as they follow
// one another while a held point wanders over a clamped block of 0.1 x 0.1 x 0.03 m, 3 mm deep, at 30 Hz. By size and
// model; CPU time of one thread [ms], median and 90th percentile, and iterations of the linear solver.
//   ./build/release/bench/global_half_bench [msd|fem]
#include <cstdio>

#include "core/base/cpu_time.hpp"
#include "core/base/parallel.hpp"
#include "core/body/mesh.hpp"
#include "core/body/node_weights.hpp"
#include "core/global/held_model.hpp"
#include "core/global/integrator.hpp"
#include "core/linear/dense/kernels.hpp"
#include "haptics/session/metrics.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

constexpr double kWidth = 0.1, kHeight = 0.03, kDepth = 0.003, kPressed = 0.2, kSpeed = 0.03, kInterval = 1.0 / 30;

struct Cells {
  int across, up;
};
constexpr Cells kSizes[] = {{11, 5}, {13, 7}, {17, 9}, {31, 9}};  // 864, 1,568, 3,240 and 10,240 nodes

template <class Work>
void time(std::vector<double>& out, const Work& work) {
  const double start = thread_time_ms();
  work();
  out.push_back(thread_time_ms() - start);
}

Mesh block(const Cells& cells) {
  Mesh mesh = kuhn_block(cells.across, cells.across, cells.up, kWidth / cells.across);
  for (Eigen::Index i = 2; i < mesh.x.size(); i += 3) mesh.x[i] *= kHeight / (kWidth / cells.across * cells.up);
  return mesh;
}

/// The middle of the triangle on top that is nearest to where the tool is at time t.
ContactHold hold_at(const Mesh& mesh, double t) {
  const Vec3 place(0.03 + kSpeed * std::max(0.0, t - kPressed), 0.05, kHeight);
  ContactHold out{.normal = Vec3(0, 0, 1), .point = place - kDepth * std::min(1.0, t / kPressed) * Vec3::UnitZ()};
  double nearest = 1;
  for (const Triangle& triangle : mesh.triangles) {
    const Vec3 middle = (node(mesh.x, triangle[0]) + node(mesh.x, triangle[1]) + node(mesh.x, triangle[2])) / 3;
    if ((middle - place).norm() >= nearest) continue;
    nearest = (middle - place).norm();
    out.moves = NodeWeights(triangle, Vec3::Constant(1.0 / 3));
  }
  return out;
}

void drag(const char* type, const Cells& cells) {
  const Mesh mesh = block(cells);
  std::vector<int> bottom;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i + 2] < 1e-9) bottom.push_back(i);
  const auto model = make_model(
      type, mesh, {.young = 8e3, .density = 1060, .damping_mass = 5, .damping_stiffness = 2e-3, .fixed_nodes = bottom});
  const auto integrator = make_integrator("implicit_euler", {.solver = "automatic", .tolerance = 1e-5});
  const VectorX none = VectorX::Zero(mesh.x.size());
  State state = rest_state(*model);
  std::vector<double> step, ahead, linearized;
  int steps = 0, iterations = 0;
  Tangent tangent;
  VectorX force;
  for (double t = kInterval; t < 1.2; t += kInterval, ++steps) {
    const ContactHold now = hold_at(mesh, t), later = hold_at(mesh, t + kInterval / 2);
    const HeldModel held(*model, {&now, 1}, 1e5), held_later(*model, {&later, 1}, 1e5);
    const int before = integrator->statistics().linear_iterations;
    time(step, [&] { integrator->step(held, none, kInterval, state); });
    iterations += integrator->statistics().linear_iterations - before;
    State foreseen = state;
    time(ahead, [&] { integrator->look_ahead(held_later, none, kInterval / 2, foreseen); });
    time(linearized, [&] {
      model->force(foreseen, force);
      model->update_tangent(foreseen, TangentKind::symmetric, tangent);
    });
  }
  std::printf("%-4s %6d %8.2f %6.2f %10.2f %6.2f %10.2f %6.2f %8.1f %16.10g\n", type, mesh.num_nodes(),
              percentile(step, 0.5), percentile(step, 0.9), percentile(ahead, 0.5), percentile(ahead, 0.9),
              percentile(linearized, 0.5), percentile(linearized, 0.9), static_cast<double>(iterations) / steps,
              state.x.norm());
}

}  // namespace
}  // namespace kt

int main(int count, char** arguments) {
  std::printf("kernels: %s\n", kt::vector_width_name().c_str());
  std::printf("model nodes  step ms    p90   ahead ms    p90  linearize    p90     iter.              |x|\n");
  kt::with_threads(1, [&] {
    for (const char* type : {"msd", "fem"})
      for (const kt::Cells& cells : kt::kSizes)
        if (count < 2 || std::string(arguments[1]) == type) kt::drag(type, cells);
  });
}
