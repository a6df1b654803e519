// The reference against truths of its own: the step that it claims to take, equilibria, and itself at finer steps.
#include "lab/study/reference.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "models/model.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/input_errors.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-9;   // of velocities, over a factored system of condition 1e3
constexpr double kStepError = 5e-3;  // of the mean force: what the reference may be off at 10 kHz

const ToolShape kSphere{ToolShape::Kind::sphere, 0.004};
const ToolShape kPoint{ToolShape::Kind::point, 0};

/// A soft slab, 40 x 40 x 20 mm, glued to the table.
struct Slab {
  explicit Slab(const std::string& type, std::vector<int> also_fixed = {}) {
    ModelOptions options{.young = 1e4, .poisson = 0.4, .density = 1000, .damping_mass = 5, .damping_stiffness = 2e-3};
    options.material = "neo_hookean";
    Mesh mesh = kuhn_block(8, 8, 4, 0.005);
    options.fixed_nodes = std::move(also_fixed);
    for (int i = 0; i < mesh.num_nodes(); ++i)
      if (mesh.x[3 * i + 2] < 1e-6) options.fixed_nodes.push_back(i);
    std::sort(options.fixed_nodes.begin(), options.fixed_nodes.end());
    model = make_model(type, std::move(mesh), options);
    surface = make_surface(model->mesh());
  }
  FullSimulation simulation(const ToolShape& tool, const std::string& law, const FullOptions& options,
                            double mu = 0.5) const {
    return {*model, surface, {&tool, 1}, make_contact_solver(law, {mu, mu}), options, rest_state(*model)};
  }
  std::unique_ptr<DeformableModel> model;
  Surface surface;
};

FullOptions at_rate(double rate_hz, double matrix_time = 0.01) {
  return {.h = 1 / rate_hz, .matrix_time = matrix_time, .max_speed = 0.15, .collision_backend = "brute_force"};
}

/// Down by 3 mm in 40 ms, then across at 50 mm/s: smooth, so that steps and not corners are measured.
Vec3 press_and_drag(double t, double radius) {
  const double down = std::min(t / 0.04, 1.0), across = std::max(0.0, t - 0.04);
  const double depth = -0.0002 + 0.0032 * down * down * (3 - 2 * down);
  return {0.0157 + 0.05 * across * across / (across + 0.01), 0.0213, 0.02 + radius - depth};
}

/// The force at the end of each millisecond.
VectorX forces(const Slab& slab, const ToolShape& tool, const std::string& law, const FullOptions& options,
               double duration = 0.1) {
  FullSimulation full = slab.simulation(tool, law, options);
  const int n = static_cast<int>(std::lround(1e-3 / options.h)), ticks = static_cast<int>(std::lround(duration / 1e-3));
  VectorX out(3 * ticks);
  for (int i = 0; i < n * ticks; ++i) {
    const auto frame =
        full.step({press_and_drag(i * options.h, tool.radius), press_and_drag((i + 1) * options.h, tool.radius)});
    if ((i + 1) % n == 0) out.segment<3>(3 * (i / n)) = frame.force;
  }
  return out;
}

/// Damped in a way that leaves the tangents symmetric, which solvers take for granted.
std::unique_ptr<DeformableModel> symmetric_body(const std::string& type, const std::string& material) {
  ModelOptions options{.young = 1e4, .poisson = 0.4, .density = 1000, .damping_mass = 500};
  options.material = material;
  if (material == "linear") options.damping_stiffness = 2e-3;
  options.fixed_nodes = {0, 1, 2, 3, 4};
  return make_model(type, kuhn_block(4, 3, 3, 0.005), options);
}

TEST(FullSimulation, OneStepIsThatOfLinearlyImplicitEuler) {
  for (const auto& [type, material] : {std::pair{"msd", "neo_hookean"}, {"fem", "neo_hookean"}, {"fem", "linear"}}) {
    const auto model = symmetric_body(type, material);
    const Surface surface = make_surface(model->mesh());
    State state = rest_state(*model);
    const VectorX noise = random_vector(2 * state.x.size(), 3);
    state.x += 5e-4 * noise.head(state.x.size());
    state.v += 0.1 * noise.tail(state.x.size());
    for (int i : model->fixed_nodes()) {
      node(state.x, i) = node(model->mesh().x, i);
      node(state.v, i).setZero();
    }
    FullOptions options = at_rate(10000, 1e-4);  // a new matrix every step
    FullSimulation full(*model, surface, {&kPoint, 1}, make_contact_solver("coulomb", {}), options, state);
    const auto integrator = make_integrator("implicit_euler", {.solver = "direct", .definite = false});
    const Vec3 far(0.02, 0.02, 0.1);
    for (int i = 0; i < 20; ++i) {
      full.step({far, far});
      integrator->step(*model, VectorX::Zero(state.x.size()), options.h, state);
      EXPECT_LT(relative_error(full.state().v, state.v), kRoundoff) << type << ' ' << material << " step " << i;
      EXPECT_LT(relative_error(full.state().x, state.x), kRoundoff) << type << ' ' << material << " step " << i;
    }
    EXPECT_EQ(full.num_matrices(), 20);
  }
}

TEST(FullSimulation, ConvergesWithTheStep) {
  for (const char* type : {"msd", "fem"})
    for (const ToolShape& tool : {kSphere, kPoint}) {
      const Slab slab(type);
      std::vector<VectorX> f;
      for (double rate : {1000, 2000, 5000, 10000, 20000}) f.push_back(forces(slab, tool, "coulomb", at_rate(rate)));
      const auto change = [&](int a, int b) { return (f[a] - f[b]).norm() / f.back().norm(); };
      const double error = 2 * change(3, 4);  // Richardson, first order
      std::printf("%s, %s: force changes from 1 to 2 kHz by %.3g, 5 to 10 %.3g, 10 to 20 %.3g; error at 10 kHz %.3g\n",
                  type, tool.radius > 0 ? "sphere" : "point", change(0, 1), change(2, 3), change(3, 4), error);
      EXPECT_LT(error, kStepError) << type;
      // First order: the changes are as 1/1 - 1/2 to 1/5 - 1/10; below is what contact is iterated to.
      EXPECT_LT(change(2, 3), 0.3 * change(0, 1)) << type;
    }
}

TEST(FullSimulation, OldMatricesChangeTheForceByLessThanTheStepDoes) {
  const Slab slab("fem");
  constexpr double kDuration = 0.06;
  const VectorX fresh = forces(slab, kSphere, "coulomb", at_rate(10000, 1e-4), kDuration);
  const VectorX fine = forces(slab, kSphere, "coulomb", at_rate(20000), kDuration);
  const double step = 2 * (fresh - fine).norm() / fine.norm();
  for (double matrix_time : {1e-3, 1e-2, 3e-2}) {
    const VectorX held = forces(slab, kSphere, "coulomb", at_rate(10000, matrix_time), kDuration);
    const double change = (held - fresh).norm() / fresh.norm();
    std::printf("matrix held for %g ms: force changes by %.3g (error of the step %.3g)\n", 1e3 * matrix_time, change,
                step);
    EXPECT_LT(change, step) << matrix_time;
  }
}

/// The node under the tool, held where the tool is, in a body that knows nothing of contact.
TEST(FullSimulation, StaticPressIsTheEquilibriumOfTheBody) {
  for (const char* type : {"msd", "fem"}) {
    const Slab slab(type);
    int top = 0;
    for (int i = 0; i < slab.model->mesh().num_nodes(); ++i)
      if ((node(slab.model->mesh().x, i) - Vec3(0.02, 0.02, 0.02)).norm() < 1e-6) top = i;
    const Vec3 start = node(slab.model->mesh().x, top) + Vec3(0, 0, 1e-4), end = start - Vec3(0, 0, 0.0021);
    FullOptions options = at_rate(2000);
    FullSimulation full = slab.simulation(kPoint, "coulomb", options, 10);
    LocalFrame frame;
    for (int i = 0; i < 1600; ++i) {
      const auto place = [&](int k) { return Vec3(start + std::min(1.0, k / 100.0) * (end - start)); };
      frame = full.step({place(i), place(i + 1)});
    }
    const Slab held(type, {top});
    State state = rest_state(*held.model);
    node(state.x, top) = end;
    make_integrator("quasistatic")->step(*held.model, VectorX::Zero(state.x.size()), 1, state);
    VectorX force;
    held.model->force(state, force);
    const Vec3 truth = node(force, top);
    std::printf("%s: static press %.6g N, equilibrium %.6g N\n", type, frame.force.norm(), truth.norm());
    EXPECT_LT((frame.force - truth).norm(), kStepError * truth.norm()) << type;
  }
}

TEST(Reference, TellsWhereMorePlacesTouchThanATickHolds) {
  Scene scene = small_scene("capsule");
  scene.object.model.type = "fem";
  scene.tool.radius = 0.006;
  scene.tool.length = 0.03;
  const auto warnings = [&](int cells) {  // along 40 mm, half of them across, 10 mm thick
    const Session session(scene, kuhn_block(cells, cells / 2, cells / 4, 0.04 / cells));
    PosePath down;
    const Quaternion lying(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()));
    for (int i = 0; i <= 40; ++i)
      down.push_back({Vec3(0.0203, 0.0101, 0.0161 - 8e-4 * std::min(i / 30.0, 1.0)), lying});
    return run_reference(session, {&down, 1}, {.rate_hz = 2000}).warnings;
  };
  EXPECT_TRUE(warnings(4).empty());
  const std::vector<std::string> fine = warnings(16);
  ASSERT_EQ(fine.size(), 1u);
  EXPECT_TRUE(fine[0].starts_with(text("reference: ", kMaxContacts, " places or more touch in "))) << fine[0];
}

}  // namespace
}  // namespace kt
