# One place for compiler flags. Contraction stays off everywhere: a recorded tool path must replay bit for bit
# on every machine, and a fused multiply-add that one build uses and another does not would break that.
find_program(KT_CCACHE ccache)
if(KT_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${KT_CCACHE})
endif()

add_library(kt_flags INTERFACE)
target_compile_options(kt_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wconversion
                                          -Wno-sign-conversion)
if(KT_WERROR)
  target_compile_options(kt_flags INTERFACE -Werror)
endif()
add_library(kt_arithmetic INTERFACE)
# Nobody reads errno after a square root: without it that is one instruction, with the same result.
target_compile_options(kt_arithmetic INTERFACE -ffp-contract=off -fno-math-errno)
