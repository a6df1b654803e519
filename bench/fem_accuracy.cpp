// Finite elements against the truth: cantilever under refinement and near incompressibility, Hertz, crushed and
// scrambled blocks. Prints one JSON document; scripts/accuracy draws docs/pictures/fem_*.png and the tables from it.
//   ./build/release/bench/fem_accuracy [cantilever] [hertz] [recovery] > accuracy.json
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>

#include "bench/cantilever.hpp"
#include "core/body/wrapping_model.hpp"
#include "core/global/integrator.hpp"

namespace kt {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

State equilibrium(const DeformableModel& model, const State& start, int* not_converged = nullptr) {
  const auto stepper = make_integrator("quasistatic", {.solver = "direct"});
  State s = start;
  stepper->step(model, VectorX::Zero(s.x.size()), 0, s);
  if (not_converged) *not_converged = stepper->statistics().not_converged;
  return s;
}

/// Tip deflections under a thousandth of the weight: small strains, where theory is linear.
void cantilevers() {
  std::printf("\"cantilever\": [\n");
  bool first = true;
  for (double poisson : {0.3, 0.45, 0.49, 0.499})
    for (const char* element : {"tet4", "tet10"}) {
      const bool quadratic = std::string(element) == "tet10";
      for (int cells : quadratic ? std::vector{1, 2, 3, 4, 6} : std::vector{2, 4, 6, 8, 12}) {
        const auto model = cantilever(
            cells, {.young = 1e5, .poisson = poisson, .density = 1, .material = "linear", .element = element});
        const auto start = std::chrono::steady_clock::now();
        const double tip = tip_deflection(*model, equilibrium(*model, rest_state(*model)));
        std::printf(
            "%s  {\"element\": \"%s\", \"poisson\": %g, \"cells\": %d, \"nodes\": %d, \"tip\": %.10e, \"seconds\": "
            "%.3f}",
            first ? "" : ",\n", element, poisson, cells, model->mesh().num_nodes(), tip, seconds_since(start));
        std::fflush(stdout);
        first = false;
      }
    }
  std::printf("\n]");
}

/// A frictionless rigid sphere (or, with radius 0, a node pushed by hand) in the way of the body's top nodes.
class Indented final : public WrappingModel {
 public:
  Indented(const DeformableModel& model, std::vector<int> nodes, const Vec3& centre, double radius, double stiffness)
      : WrappingModel(model), nodes_(std::move(nodes)), centre_(centre), radius_(radius), stiffness_(stiffness) {}
  void force(const State& state, VectorX& out) const override {
    model_.force(state, out);
    for (int i : nodes_) node(out, i) += push(node(state.x, i));
  }
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    model_.update_tangent(state, kind, out);
    for (int i : nodes_) {
      const Vec3 d = Vec3(node(state.x, i)) - centre_;
      if (d.norm() >= radius_) continue;
      const Vec3 n = d.normalized();
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) out.dfdx.coeffRef(3 * i + r, 3 * i + c) -= stiffness_ * n[r] * n[c];
    }
  }
  double force_on_tool(const State& state) const {
    double sum = 0;
    for (int i : nodes_) sum -= push(node(state.x, i)).z();
    return sum;
  }

 private:
  Vec3 push(const Vec3& x) const {
    const Vec3 d = x - centre_;
    const double length = d.norm();
    return length < radius_ ? Vec3(stiffness_ * (radius_ - length) / length * d) : Vec3(Vec3::Zero());
  }
  std::vector<int> nodes_;
  Vec3 centre_;
  double radius_, stiffness_;
};

/// A block 0.4 x 0.4 x 0.4 m, its cells finest at the middle of the top: coordinates bent by sinh.
Mesh graded_block(int cells, double finest) {
  constexpr double kHalf = 0.2;
  Mesh mesh = kuhn_block(2 * cells, 2 * cells, cells + cells / 2, 1.0 / cells);
  double strength = 1;  // of the grading: the first cell has the wanted size
  while (kHalf * std::sinh(strength / cells) / std::sinh(strength) > finest && strength < 20) strength *= 1.01;
  const auto graded = [&](double s) { return kHalf * std::sinh(strength * s) / std::sinh(strength); };
  const double down = graded(1.5) / (2 * kHalf);  // deep as wide
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const Vec3 s = node(mesh.x, i);
    node(mesh.x, i) = Vec3(graded(s.x() - 1), graded(s.y() - 1), -graded(1.5 - s.z()) / std::max(1.0, down));
  }
  return mesh;
}

void hertz() {
  constexpr double kYoung = 1e4, kPoisson = 0.3, kRadius = 0.02, kDepth = 0.001;
  const double theory = 4.0 / 3.0 * kYoung / (1 - kPoisson * kPoisson) * std::sqrt(kRadius) * std::pow(kDepth, 1.5);
  std::printf("\"hertz\": {\"theory\": %.8e, \"contact_radius\": %.6e, \"rows\": [\n", theory,
              std::sqrt(kRadius * kDepth));
  bool first = true;
  for (const char* element : {"tet4", "tet10"})
    for (int cells : std::string(element) == "tet4" ? std::vector{6, 8, 12, 16} : std::vector{4, 6, 8}) {
      const double finest = 0.0045 * 3 / cells;
      Mesh mesh = graded_block(cells, finest);
      std::vector<int> fixed, top;
      double bottom = 0;
      for (int i = 0; i < mesh.num_nodes(); ++i) bottom = std::min(bottom, node(mesh.x, i).z());
      for (int i = 0; i < mesh.num_nodes(); ++i)
        if (node(mesh.x, i).z() < bottom + 1e-9) fixed.push_back(i);
      const auto start = std::chrono::steady_clock::now();
      const auto model = make_model(
          "fem", mesh,
          {.young = kYoung, .poisson = kPoisson, .fixed_nodes = fixed, .material = "linear", .element = element});
      const VectorX& rest = model->mesh().x;
      int middle = 0;
      for (int i = 0; i < model->mesh().num_nodes(); ++i) {
        if (node(rest, i).z() > -1e-12 && node(rest, i).head<2>().norm() < 0.012) top.push_back(i);
        if (node(rest, i).norm() < node(rest, middle).norm()) middle = i;
      }
      const Indented body(*model, top, Vec3(0, 0, kRadius - kDepth), kRadius, 3e4);
      int open = 0;
      const State s = equilibrium(body, rest_state(*model), &open);
      const double force = body.force_on_tool(s), seconds = seconds_since(start);
      // The same body under a point tool: a force on one node, and how deep that presses it.
      const Indented alone(*model, {}, Vec3::Zero(), 0, 0);
      const auto stepper = make_integrator("quasistatic", {.solver = "direct"});
      State pressed = rest_state(*model);
      VectorX push = VectorX::Zero(rest.size());
      push[3 * middle + 2] = -1e-3;
      stepper->step(alone, push, 0, pressed);
      const double point = 1e-3 / -(pressed.x - rest)[3 * middle + 2];
      std::printf(
          "%s  {\"element\": \"%s\", \"cells\": %d, \"finest\": %.4e, \"nodes\": %d, \"force\": %.8e, \"off\": %.5f, "
          "\"not_converged\": %d, \"seconds\": %.2f, \"point_stiffness\": %.6e}",
          first ? "" : ",\n", element, cells, finest, model->mesh().num_nodes(), force, force / theory - 1, open,
          seconds, point);
      std::fflush(stdout);
      first = false;
    }
  std::printf("\n]}");
}

/// Largest distance from the rest shape over time, of the block's edge, from a state that turned elements inside out.
void recoveries() {
  std::printf("\"recovery\": [\n");
  bool first = true;
  const Mesh mesh = kuhn_block(5, 5, 5, 0.02);
  std::vector<int> fixed;
  for (int i = 0; i < 36; ++i) fixed.push_back(i);
  for (const char* material : {"neo_hookean", "corotational", "stvk"})
    for (const char* start : {"crushed", "scrambled"}) {
      const auto model = make_model("fem", mesh,
                                    {.young = 1e4,
                                     .poisson = 0.45,
                                     .damping_mass = 5,
                                     .damping_stiffness = 1e-3,
                                     .fixed_nodes = fixed,
                                     .material = material});
      State s = rest_state(*model);
      std::mt19937 random(5);
      std::uniform_real_distribution<double> place(0, 0.1);
      for (int i = 36; i < mesh.num_nodes(); ++i) {
        if (std::string(start) == "crushed")
          s.x[3 * i + 2] *= 0.05;
        else
          node(s.x, i) = Vec3(place(random), place(random), place(random));
      }
      const auto inverted = [&] {
        int count = 0;
        for (const Tetrahedron& t : mesh.tetrahedra) count += tetrahedron_volume(s.x, t) <= 0;
        return count;
      };
      const int before = inverted();
      const auto stepper = make_integrator("newton_euler", {.solver = "direct"});
      std::printf("%s  {\"material\": \"%s\", \"start\": \"%s\", \"inverted\": %d, \"off\": [", first ? "" : ",\n",
                  material, start, before);
      bool failed = false;
      for (int i = 0; i <= 200; ++i) {
        std::printf("%s%.4e", i ? ", " : "", (s.x - mesh.x).lpNorm<Eigen::Infinity>() / 0.1);
        try {
          if (!failed) stepper->step(*model, VectorX::Zero(s.x.size()), 0.02, s);
        } catch (const RunError&) {
          failed = true;
        }
      }
      std::printf("], \"still_inverted\": %d, \"failed\": %s, \"projected\": %d}", inverted(),
                  failed ? "true" : "false", stepper->statistics().projected);
      std::fflush(stdout);
      first = false;
    }
  std::printf("\n]\n");
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  const std::vector<std::pair<std::string, void (*)()>> parts{
      {"cantilever", kt::cantilevers}, {"hertz", kt::hertz}, {"recovery", kt::recoveries}};
  bool first = true;
  std::printf("{\n");
  for (const auto& [name, run] : parts) {
    if (argc > 1 && std::find(argv + 1, argv + argc, name) == argv + argc) continue;
    if (!first) std::printf(",\n");
    first = false;
    run();
  }
  std::printf("}\n");
}
