// Finite elements give the same bits on every build and with any number of threads.
#include <gtest/gtest.h>

#include "core/base/parallel.hpp"
#include "core/body/state.hpp"
#include "core/global/integrator.hpp"
#include "models/fem/material.hpp"
#include "models/model.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"
#include "tests/support/shaken_body.hpp"

namespace kt {
namespace {

std::unique_ptr<DeformableModel> body(const std::string& material, const std::string& element, const Mesh& mesh) {
  return make_model("fem", mesh,
                    {.poisson = 0.4,
                     .damping_mass = 2,
                     .damping_stiffness = 1e-3,
                     .fixed_nodes = nodes_below(mesh, 1e-6),
                     .material = material,
                     .element = element});
}

std::uint64_t hash_after_100_steps(const std::string& material, const std::string& element) {
  const auto model = body(material, element, kuhn_block(2, 2, 2, 0.01));
  State state = rest_state(*model);
  const VectorX push = 1e-2 * random_vector(state.x.size(), 42);
  const auto stepper = make_integrator("symplectic_euler");
  StateHash hash;
  for (int i = 0; i < 100; ++i) {
    stepper->step(*model, push, 1e-4, state);
    hash.add(state.x);
    hash.add(state.v);
  }
  EXPECT_GT((state.x - model->mesh().x).norm(), 1e-4);  // it moved
  return hash.value();
}

// As for springs (msd_determinism_test): IEEE operations in a fixed order. A new value: say so in the CHANGELOG.
TEST(GoldenHash, OfExplicitFemStepsIsTheSameInEveryBuild) {
  EXPECT_EQ(hash_after_100_steps("linear", "tet4"), 18234074557605985542ull);
  EXPECT_EQ(hash_after_100_steps("corotational", "tet4"), 13918443700068828874ull);
  EXPECT_EQ(hash_after_100_steps("stvk", "tet4"), 5356203520380324975ull);
  EXPECT_EQ(hash_after_100_steps("neo_hookean", "tet4"), 14203131483919702851ull);
  EXPECT_EQ(hash_after_100_steps("neo_hookean", "tet10"), 2340401330800113998ull);
}

TEST(Fem, ForcesTangentsAndStepsDoNotDependOnTheNumberOfThreads) {
  for (const BackendInfo& material : material_backends())
    for (const char* element : {"tet4", "tet10"}) {
      const auto model = body(material.name, element, kuhn_block(5, 5, 9, 0.01));  // several slabs
      const State start = shaken(*model, 0.003, 7);
      std::vector<std::uint64_t> hashes;
      for (int threads : {1, 2, 3, 8})
        with_threads(threads, [&] {
          StateHash hash;
          hash.add(force(*model, start));
          for (TangentKind kind : {TangentKind::exact, TangentKind::definite}) {
            const Tangent t = model->tangent(start, kind);
            for (const SparseMatrix* m : {&t.dfdx, &t.dfdv})
              hash.add(VectorX(Eigen::Map<const VectorX>(m->valuePtr(), m->nonZeros())));
          }
          for (const char* solver : {"direct", "pcg"}) {
            State s = start;
            make_integrator("implicit_euler", {.solver = solver})->step(*model, VectorX::Zero(s.x.size()), 0.01, s);
            hash.add(s.x);
          }
          hashes.push_back(hash.value());
        });
      for (std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]) << material.name << ' ' << element;
    }
}

}  // namespace
}  // namespace kt
