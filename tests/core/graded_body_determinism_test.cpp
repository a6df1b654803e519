// A reduction gives the same bits with any number of threads.
#include <gtest/gtest.h>

#include "core/base/parallel.hpp"
#include "core/body/state.hpp"
#include "core/local/graded_body.hpp"
#include "tests/support/linearized_block.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

/// Of local models that follow one another, of a patch that moves on.
std::uint64_t hash_of_models(const LinearizedBlock& b, const std::string& reducer) {
  GradedBody graded;
  StateHash hash;
  for (int refresh = 0; refresh < 4; ++refresh) {
    SurfacePatch patch = b.patch();
    for (int& i : patch.global_node) i -= refresh;
    const LocalModel model = find_reducer(reducer)(b.tangent, patch, b.site, {.graded = &graded});
    EXPECT_FALSE(graded.is_whole());
    for (const SparseMatrix* m : {&model.stiffness, &model.damping, &model.basis, &model.fit})
      hash.add(VectorX(Eigen::Map<const VectorX>(m->valuePtr(), m->nonZeros())));
    hash.add(model.f0);
  }
  EXPECT_GT(graded.gradings(), 1);
  return hash.value();
}

TEST(GradedBody, ModelsDoNotDependOnTheNumberOfThreads) {
  for (const char* type : {"msd", "fem"}) {
    const LinearizedBlock b(8, type);
    for (const char* reducer : {"condensed", "krylov"}) {
      std::vector<std::uint64_t> hashes;
      for (int threads : {1, 2, 8}) with_threads(threads, [&] { hashes.push_back(hash_of_models(b, reducer)); });
      for (std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]) << type << ' ' << reducer;
    }
  }
}

}  // namespace
}  // namespace kt
