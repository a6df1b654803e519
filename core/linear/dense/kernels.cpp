#include "core/linear/dense/kernels.hpp"

#include "core/base/wide.hpp"

#if defined(__linux__)
#include <dlfcn.h>
#endif

namespace kt {
namespace {

template <int Width>
KT_INLINE void find_width_in(int& doubles) {
  doubles = Width;
}
KT_WIDTHS(find_width, (int& doubles), (doubles))

}  // namespace

std::string vector_width_name() {
  int doubles = 0;
  find_width(doubles);
  if (doubles == 8) return "8 doubles (AVX-512)";
  return doubles == 4 ? "4 doubles (AVX2)" : "2 doubles";
}

std::string blas_kernels_name() {
#if defined(__linux__)
  // Looked up while the program runs: which BLAS is behind CHOLMOD is the system's choice.
  if (void* const found = dlsym(RTLD_DEFAULT, "openblas_get_corename")) {
    const auto name = reinterpret_cast<const char* (*)()>(found);
    return name();
  }
#endif
  return {};
}

}  // namespace kt
