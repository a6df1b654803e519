// The same bits on every build: a fixed little simulation and the hash it must end with.
#include <gtest/gtest.h>

#include "core/body/state.hpp"
#include "core/global/integrator.hpp"
#include "models/model.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

std::uint64_t hash_after_100_steps(const std::string& integrator) {
  const Mesh mesh = kuhn_block(2, 2, 2, 0.01);
  const auto model = make_model("msd", mesh,
                                {.damping_mass = 2,
                                 .damping_stiffness = 1e-3,
                                 .stiffness = 30.0,
                                 .damper = 0.02,
                                 .fixed_nodes = nodes_below(mesh, 1e-6)});
  State state = rest_state(*model);
  const VectorX push = 1e-3 * random_vector(state.x.size(), 42);
  const auto stepper = make_integrator(integrator);
  StateHash hash;
  for (int i = 0; i < 100; ++i) {
    stepper->step(*model, push, 1e-3, state);
    hash.add(state.x);
    hash.add(state.v);
  }
  EXPECT_GT((state.x - mesh.x).norm(), 1e-4);  // it moved
  return hash.value();
}

// Explicit steps use only IEEE sums, products, quotients and roots in a fixed order: no solver, no math library. A new
// value means that results of recorded runs changed too; say so in the CHANGELOG.
TEST(GoldenHash, OfExplicitMsdStepsIsTheSameInEveryBuild) {
  EXPECT_EQ(hash_after_100_steps("symplectic_euler"), 9046873037001321704ull);
}

TEST(GoldenHash, IsTheSameInTwoRunsOfEachIntegrator) {
  for (const BackendInfo& backend : integrator_backends())
    EXPECT_EQ(hash_after_100_steps(backend.name), hash_after_100_steps(backend.name)) << backend.name;
}

}  // namespace
}  // namespace kt
