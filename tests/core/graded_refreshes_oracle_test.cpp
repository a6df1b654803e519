// The body seen from a contact over refreshes that follow one another, and of a body that is finer than its patch,
// against the whole one.
#include <gtest/gtest.h>

#include "core/linear/sparse_solver.hpp"
#include "core/local/graded_body.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/linearized_block.hpp"

namespace kt {
namespace {

/// Static response of the patch, of the body against the whole one.
double error_at_rest(const LinearizedBlock& b, const FreeBody& body, const SurfacePatch& patch) {
  const FreeBody whole(b.tangent);
  const MatrixX B = whole.inputs(patch), Bc = body.inputs(patch);
  const auto all = make_sparse_solver();
  EXPECT_TRUE(all->factor(whole.stiffness));
  return relative_error(Bc.transpose() * solve_symmetric(body.stiffness, Bc), B.transpose() * all->solve(B));
}

/// Once a local model was made, its factor leads the far motions, also to a patch that has left: to as good a body as
/// the kept nodes' own factor does, which is made where there was no local model.
TEST(GradedBody, LedByTheLastFactorYieldsAsTheWholeOneToo) {
  const LinearizedBlock b(8, "fem");
  const SurfacePatch here = b.patch();
  SurfacePatch away = here;
  for (int& i : away.global_node) i -= 3;
  GradedBody led, own;
  const double first = error_at_rest(b, led.update(b.tangent, here), here);
  for (int refresh = 0; refresh < 12; ++refresh) {
    find_reducer("condensed")(b.tangent, here, b.site, {.graded = &led});
    own.update(b.tangent, here);
  }
  EXPECT_LT(error_at_rest(b, led.update(b.tangent, here), here), first);
  find_reducer("condensed")(b.tangent, here, b.site, {.graded = &led});
  EXPECT_LE(error_at_rest(b, led.update(b.tangent, away), away),
            1.1 * error_at_rest(b, own.update(b.tangent, away), away));
  EXPECT_EQ(led.gradings(), 2);
  EXPECT_EQ(own.gradings(), 2);
}

/// A patch of every other node: beyond an edge of it, nodes between are left out, and it yields nearly as before.
TEST(GradedBody, ThinsOutABodyThatIsFinerThanItsPatch) {
  const LinearizedBlock b(9, "fem");
  SurfacePatch patch = b.patch();
  const int across = 10;
  std::erase_if(patch.global_node, [&](int i) { return i % across % 2 == 1 || i / across % across % 2 == 1; });
  patch.in_reach.assign(patch.global_node.size(), 1);
  GradedBody all({.finest = 0}), thinned;
  const double before = error_at_rest(b, all.update(b.tangent, patch), patch);
  const double after = error_at_rest(b, thinned.update(b.tangent, patch), patch);
  ASSERT_FALSE(all.is_whole());
  EXPECT_LT(thinned.num_kept(), 0.8 * all.num_kept());
  EXPECT_LE(before, 0.003);
  EXPECT_LE(after, 0.006);
}

}  // namespace
}  // namespace kt
