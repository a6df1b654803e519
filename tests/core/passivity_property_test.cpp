// No reducer makes energy: mass > 0, stiffness and damping >= 0, whatever the body, at rest and deformed.
#include <gtest/gtest.h>

#include "core/local/graded_body.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/linearized_block.hpp"

namespace kt {
namespace {

struct PassivityCase {
  std::string reducer, type;
  double noise;  // of the deformation, in edges
  double grading;
};

class Passivity : public testing::TestWithParam<PassivityCase> {};

double least_eigenvalue(const SparseMatrix& matrix) {
  const VectorX values = symmetric_eigenvalues(matrix);
  return values.minCoeff() / std::max(1e-300, values.cwiseAbs().maxCoeff());
}

TEST_P(Passivity, HoldsByTheEigenvalues) {
  const PassivityCase& p = GetParam();
  const LinearizedBlock b(p.grading > 0 ? 6 : 4, p.type, p.noise);
  GradedBody graded({.slope = p.grading});
  const LocalModel m = find_reducer(p.reducer)(b.tangent, b.patch(), b.site,
                                               {.grading = p.grading, .graded = p.grading > 0 ? &graded : nullptr});
  ASSERT_TRUE(p.grading == 0 || !graded.is_whole());
  EXPECT_GT(least_eigenvalue(m.mass), 0);
  EXPECT_GE(least_eigenvalue(m.stiffness), -1e-12);
  EXPECT_GE(least_eigenvalue(m.damping), -1e-12);
}

std::vector<PassivityCase> passivity_cases() {
  std::vector<PassivityCase> out;
  for (const std::string type : {"msd", "fem"})
    for (const double noise : {0.0, 0.1}) {
      for (const BackendInfo& reducer : reducer_backends()) out.push_back({reducer.name, type, noise, 0});
      out.push_back({"krylov", type, noise, 0.45});
      out.push_back({"krylov", type, noise, 0.8});
    }
  return out;
}

INSTANTIATE_TEST_SUITE_P(Reducers, Passivity, testing::ValuesIn(passivity_cases()), [](const auto& test) {
  const PassivityCase& p = test.param;
  return p.reducer + "_" + p.type + (p.noise > 0 ? "_deformed" : "_at_rest") +
         (p.grading > 0 ? "_graded_" + std::to_string(static_cast<int>(100 * p.grading)) : "");
});

}  // namespace
}  // namespace kt
