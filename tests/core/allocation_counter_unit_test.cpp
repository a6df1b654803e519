// The malloc counter that the haptic tick's "no allocation" rests on: blind, it would let everything pass.
#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "core/base/types.hpp"
#include "tests/support/allocations.hpp"

namespace kt {
namespace {

TEST(AllocationCounter, SeesNewVectorsAndEigenOfThisThreadOnly) {
  if (thread_allocations() < 0) GTEST_SKIP() << "this build's sanitizer brings its own malloc";
  std::unique_ptr<int> held;
  VectorX x;
  EXPECT_EQ(allocations_during([&] { held = std::make_unique<int>(1); }), 1);
  EXPECT_EQ(allocations_during([&] { x = VectorX::Zero(100); }), 1);
  EXPECT_EQ(allocations_during([&] { x *= 2; }), 0);
  long long here = 0, there = 0;
  std::thread other([&] { there = allocations_during([&] { x = VectorX::Zero(200); }); });
  here = allocations_during([&] { other.join(); });
  EXPECT_EQ(here, 0);
  EXPECT_EQ(there, 1);
}

}  // namespace
}  // namespace kt
