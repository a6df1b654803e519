#pragma once
// KT_WIDE before a function: compiled for several vector widths, the widest that the processor has is taken when the
// program starts. Only for loops whose lanes do not meet, so that every width gives the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define KT_WIDE __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define KT_WIDE
#endif
