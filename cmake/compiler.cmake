# One place for compiler flags. Contraction stays off everywhere: a recorded tool path must replay bit for bit
# on every machine, and a fused multiply-add that one build uses and another does not would break that.
find_program(KT_CCACHE ccache)
if(KT_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${KT_CCACHE})
  if(KT_PCH)  # else it would not keep what used a precompiled header (its manual, "Precompiled headers")
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${KT_CCACHE})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      add_compile_options(-fpch-preprocess)
    endif()
  endif()
endif()
find_program(KT_LLD ld.lld)
if(KT_LLD AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  add_link_options(-fuse-ld=lld)  # links a program of many templates in a third of the time
endif()

add_library(kt_flags INTERFACE)
target_compile_options(kt_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wconversion
                                          -Wno-sign-conversion)
if(KT_WERROR)
  target_compile_options(kt_flags INTERFACE -Werror)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
    target_compile_options(kt_flags INTERFACE -Wno-error=maybe-uninitialized)  # guessed wrongly of Eigen's storage
  endif()
endif()
add_library(kt_arithmetic INTERFACE)
# Nobody reads errno after a square root: without it that is one instruction, with the same result.
target_compile_options(kt_arithmetic INTERFACE -ffp-contract=off -fno-math-errno)

# Hardening. The engine's loops over small matrices stay as they are: only buffers of characters get a canary there, and
# the standard library's own assertions are for what reads files (kt_hardened: io/, apps/, tests/).
add_library(kt_hardened INTERFACE)
if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  target_compile_options(kt_flags INTERFACE -fstack-protector)
  target_compile_options(kt_hardened INTERFACE -fstack-protector-strong)
  target_compile_definitions(kt_hardened INTERFACE _GLIBCXX_ASSERTIONS)
  if(NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")  # a sanitizer checks more, and does not see through fortified calls
    target_compile_options(kt_flags INTERFACE
                           $<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:-U_FORTIFY_SOURCE;-D_FORTIFY_SOURCE=2>)
  endif()
  if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
    add_link_options(-Wl,-z,relro,-z,now,-z,noexecstack)
  endif()
endif()

# A program finds libraries outside the system's folders by their full path, in the build as installed. CMake
# would otherwise leave room for another path in the build's, as an empty entry: that is the current folder, from which
# anybody's library would be loaded.
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)
set(CMAKE_INSTALL_RPATH_USE_LINK_PATH ON)

# kt_unity(target [EXCEPT pattern...]): several sources of a target in one compiled file, but for those that match.
# Most of a file's time goes into the headers and templates that its neighbours need too.
function(kt_unity target)
  cmake_parse_arguments(ARG "" "SIZE" "EXCEPT" ${ARGN})
  if(NOT KT_UNITY)
    return()
  endif()
  if(NOT ARG_SIZE)
    set(ARG_SIZE 8)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${ARG_SIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)  # of headers; here sources are included
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(pattern ${ARG_EXCEPT})
    set(alone ${sources})
    list(FILTER alone INCLUDE REGEX "${pattern}")
    set_source_files_properties(${alone} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endforeach()
endfunction()

# kt_join(target name pattern): of a target's sources those that match are compiled as one file, apart from their other neighbours
# (KT_UNITY). For files that kt_unity leaves alone because they share the name of a local helper with one of those.
function(kt_join target name pattern)
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "${pattern}")
  list(LENGTH sources count)
  if(NOT KT_UNITY OR count LESS 2)
    return()
  endif()
  set_source_files_properties(${sources} PROPERTIES HEADER_FILE_ONLY ON)
  list(TRANSFORM sources REPLACE "(.+)" "#include \"\\1\"\n")
  list(JOIN sources "" content)
  set(joined ${PROJECT_BINARY_DIR}/joined/${target}_${name}.cpp)
  file(CONFIGURE OUTPUT ${joined} CONTENT "${content}" @ONLY)
  set_source_files_properties(${joined} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  target_sources(${target} PRIVATE ${joined})
endfunction()

# kt_not_hot(target...): -O1 in a release build, which compiles in two thirds of the time. For programs whose own code computes little.
# From GCC 13 on -O1 is another target than -O3, which refuses headers compiled for that, but with these two options of -O3.
include(CheckCXXCompilerFlag)
check_cxx_compiler_flag(-munroll-only-small-loops KT_HAS_SMALL_LOOPS)
function(kt_not_hot)
  foreach(target ${ARGN})
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
    if(KT_HAS_SMALL_LOOPS)
      target_compile_options(${target} PRIVATE "$<$<CONFIG:Release>:-munroll-only-small-loops;-mvzeroupper>")
    endif()
  endforeach()
endfunction()

# kt_quick(target...): kt_not_hot where KT_QUICK_BUILD asks for it, for what neither a tick nor a refresh runs (readers, reports, commands,
# pages). Not for what multiplies matrices by Eigen: of a template that two files instantiate the linker keeps one.
function(kt_quick)
  if(KT_QUICK_BUILD)
    kt_not_hot(${ARGN})
  endif()
endfunction()

# kt_precompile(target [FROM other] [header...]): Eigen, the standard library and the headers named are compiled once for all
# files of a target; FROM: they were, for another with the same flags, which defines no macro that this one does not. Each
# file saves 1 to 4 s (docs/architecture.md#build-and-tests).
function(kt_precompile target)
  cmake_parse_arguments(ARG "" "FROM" "" ${ARGN})
  if(NOT KT_PCH)
    return()
  endif()
  if(ARG_FROM)
    target_precompile_headers(${target} REUSE_FROM ${ARG_FROM})
    return()
  endif()
  target_precompile_headers(${target} PRIVATE <Eigen/Core> <Eigen/Geometry> <Eigen/SparseCore> <algorithm> <array> <atomic>
                            <chrono> <cmath> <complex> <filesystem> <functional> <limits> <map> <memory> <mutex> <numeric>
                            <optional> <ostream> <random> <set> <span> <sstream> <string> <string_view> <thread>
                            <unordered_map> <utility> <vector> ${ARG_UNPARSED_ARGUMENTS})
endfunction()
