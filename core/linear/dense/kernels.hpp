#pragma once
// Which of the loops that exist for several processors run on this one: for summaries, beside figures of speed.
#include <string>

namespace kt {

/// Of the engine's own loops (core/base/wide.hpp): "8 doubles (AVX-512)", "4 doubles (AVX2)" or "2 doubles". They give
/// the same bits at every width.
std::string vector_width_name();

/// What OpenBLAS, which CHOLMOD may use, chose: "Haswell", "SkylakeX" ...; empty with another library or none. Its bits
/// depend on it.
std::string blas_kernels_name();

}  // namespace kt
