// Loops that are compiled for several vector widths give the same bits at each of them.
#include <gtest/gtest.h>

#include <cstdint>

#include "core/linear/dense/kernels.hpp"

namespace kt_width_2 {
std::uint64_t kernel_bits();
}
namespace kt_width_4 {
std::uint64_t kernel_bits();
}
namespace kt_width_8 {
std::uint64_t kernel_bits();
}

namespace kt {
namespace {

/// A processor without the wider registers runs the narrower loops in all three: it then shows nothing, and says so.
TEST(VectorWidth, DoesNotChangeABitOfTheLoops) {
  std::printf("widest: %s\n", vector_width_name().c_str());
  const std::uint64_t narrow = kt_width_2::kernel_bits();
  EXPECT_EQ(kt_width_4::kernel_bits(), narrow);
  EXPECT_EQ(kt_width_8::kernel_bits(), narrow);
}

TEST(VectorWidth, IsNamedAsTheProcessorHasIt) {
  const std::string name = vector_width_name();
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && defined(__OPTIMIZE__)
  const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                    __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
  EXPECT_EQ(name, wide ? "8 doubles (AVX-512)" : __builtin_cpu_supports("avx2") ? "4 doubles (AVX2)" : "2 doubles");
#else
  EXPECT_EQ(name, "2 doubles");
#endif
}

}  // namespace
}  // namespace kt
