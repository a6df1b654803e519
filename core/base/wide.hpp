#pragma once
// Loops that are compiled for several vector widths: the widest that the processor has is taken when the program
// starts. Only for loops whose lanes do not meet, so that every width gives the same bits.
//
// Not under a sanitizer: the choice is made before it has started. Nor without optimization, where what such a function
// calls is not a part of it and would take vectors in another way.
//
// KT_WIDE before a function: the compiler finds the vectors by itself.
// KT_WIDTHS(name, (parameters), (arguments)): defines name(parameters) as name_in<W>(arguments), W doubles to a
// register. For sums that must stay in registers: vectors wider than a register would go through memory.
//
// KT_WIDEST: the widest that is compiled, 8, 4 or 2 doubles; tests compile the same loops with less and compare bits.
#ifndef KT_WIDEST
#define KT_WIDEST 8
#endif
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && defined(__OPTIMIZE__) && KT_WIDEST > 2
#if KT_WIDEST > 4
#define KT_WIDE __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#define KT_WIDTHS(name, parameters, arguments)                                               \
  __attribute__((target("arch=x86-64-v4"))) void name parameters { name##_in<8> arguments; } \
  __attribute__((target("avx2"))) void name parameters { name##_in<4> arguments; }           \
  __attribute__((target("default"))) void name parameters { name##_in<2> arguments; }
#else
#define KT_WIDE __attribute__((target_clones("avx2", "default")))
#define KT_WIDTHS(name, parameters, arguments)                                     \
  __attribute__((target("avx2"))) void name parameters { name##_in<4> arguments; } \
  __attribute__((target("default"))) void name parameters { name##_in<2> arguments; }
#endif
#define KT_INLINE __attribute__((always_inline)) inline
#else
#define KT_WIDE
#define KT_WIDTHS(name, parameters, arguments) \
  void name parameters { name##_in<2> arguments; }
#define KT_INLINE inline
#endif

// KT_SHUFFLE(a, b, i, j, k, l): four numbers of the eight in two vectors of four, by their places.
#if defined(__clang__)
#define KT_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
namespace kt {
typedef long long FourPlaces __attribute__((vector_size(32)));
}
#define KT_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, kt::FourPlaces{i, j, k, l})
#endif
