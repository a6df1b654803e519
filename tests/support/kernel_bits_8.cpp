// The loops with at most 8 doubles to a register.
#define KT_WIDEST 8
#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#if KT_WITH_TBB
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif
#define kt kt_width_8
#include "tests/support/kernel_bits.inc"
