// Steps of a body with held points: as the dense formula has them, and with one tangent of the body for a look ahead
// and the step that follows from the same state.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "core/body/node_weights.hpp"
#include "core/body/wrapping_model.hpp"
#include "core/global/global_simulation.hpp"
#include "core/linear/free_dofs.hpp"
#include "models/model.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/shaken_body.hpp"

namespace kt {
namespace {

/// Counts the tangents that are made of a body.
struct Counting final : WrappingModel {
  using WrappingModel::WrappingModel;
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    ++tangents;
    model_.update_tangent(state, kind, out);
  }
  mutable int tangents = 0;
};

struct Block {
  explicit Block(const std::string& type) {
    const Mesh mesh = kuhn_block(2, 2, 2, 0.01);
    model =
        make_model(type, mesh, {.damping_mass = 1, .damping_stiffness = 1e-3, .fixed_nodes = nodes_below(mesh, 1e-6)});
    for (const Triangle& t : mesh.triangles)  // one on top
      if (std::ranges::all_of(t, [&](int i) { return mesh.x[3 * i + 2] > 0.0199; })) triangle = t;
  }
  /// Pushes down; of nodes that elements join, or of two opposite corners too.
  ContactHold hold(double depth, bool far = false) const {
    ContactHold out;
    out.moves = NodeWeights(triangle, Vec3(0.2, 0.3, 0.5));
    if (far)
      for (const Vec3& corner : {Vec3(0, 0, 0.02), Vec3(0.02, 0.02, 0.02)})
        for (int i = 0; i < model->mesh().num_nodes(); ++i)
          if ((node(model->mesh().x, i) - corner).norm() < 1e-9 && std::ranges::find(triangle, i) == triangle.end())
            out.moves.add(i, 0.1);
    out.normal = Vec3(0, 0, 1);
    out.point = out.moves.of(model->mesh().x) - depth * out.normal;
    return out;
  }
  std::unique_ptr<DeformableModel> model;
  Triangle triangle{};
};

TEST(HeldStep, IsTheDenseFormulaWhereverTheHeldNodesAre) {
  constexpr double kSolver = 1e-8;  // of a step solved to 1e-12
  for (const char* type : {"msd", "fem"})
    for (const bool far : {false, true})
      for (const bool definite : {true, false}) {
        const Block b(type);
        const ContactHold hold = b.hold(1e-3, far);
        const HeldModel held(*b.model, {&hold, 1}, 1e5);
        const State start = shaken(*b.model, 1e-4, 5);
        const double dt = 0.01;
        const VectorX external = random_vector(start.x.size(), 6);
        State s = start;
        make_integrator("implicit_euler", {.solver = "pcg", .tolerance = 1e-12, .definite = definite})
            ->step(held, external, dt, s);
        VectorX f;
        held.force(start, f);
        const Tangent t = held.tangent(start, definite ? TangentKind::definite : TangentKind::exact);
        const FreeDofs dofs = make_free_dofs(b.model->mesh().num_nodes(), b.model->fixed_nodes());
        const MatrixX A = MatrixX(gather(dofs, SparseMatrix(held.mass() - dt * t.dfdv - dt * dt * t.dfdx)));
        const VectorX rhs = dt * gather(dofs, VectorX(f + external + dt * (t.dfdx * start.v)));
        if ((A - A.transpose()).norm() > 1e-9 * A.norm()) continue;  // conjugate gradients are for symmetric matrices
        EXPECT_LE(relative_error(gather(dofs, VectorX(s.v - start.v)), A.llt().solve(rhs)), kSolver)
            << type << far << definite;
      }
}

TEST(GlobalSimulation, MakesOneTangentForALookAheadAndTheStepThatFollows) {
  for (const char* type : {"msd", "fem"}) {
    const Block b(type);
    const Counting looking(*b.model), blind(*b.model);
    GlobalSimulation one(looking, make_integrator("implicit_euler"), 0.1),
        other(blind, make_integrator("implicit_euler"), 0.1);
    for (int i = 1; i <= 4; ++i) {
      const ContactHold hold = b.hold(2e-4 * i), next = b.hold(2e-4 * i + 1e-4);
      one.advance(0.03 * i, {}, {&hold, 1});
      other.advance(0.03 * i, {}, {&hold, 1});
      EXPECT_TRUE(one.foresee(0.015, std::vector(1, std::vector{next})));
    }
    EXPECT_EQ(one.state(), other.state()) << type;  // to the bit
    EXPECT_EQ(blind.tangents, 1 + 4);               // one at rest tells how stiff a hold has to be
    EXPECT_EQ(looking.tangents, 1 + 5);             // the first step's, and one after each step
  }
}

}  // namespace
}  // namespace kt
