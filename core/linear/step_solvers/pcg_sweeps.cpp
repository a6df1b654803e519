#include "core/linear/step_solvers/pcg_sweeps.hpp"

#include "core/base/wide.hpp"

namespace kt {
namespace {

/// A node's numbers. In a function for a processor without such registers the compiler takes two; never a parameter.
typedef double Four __attribute__((vector_size(8 * kLanes)));

/// a x b; the last lane is zero where both have a zero there.
#define KT_CROSS(a, b)                                           \
  (KT_SHUFFLE(a, a, 1, 2, 0, 3) * KT_SHUFFLE(b, b, 2, 0, 1, 3) - \
   KT_SHUFFLE(a, a, 2, 0, 1, 3) * KT_SHUFFLE(b, b, 1, 2, 0, 3))

}  // namespace

KT_WIDE void pcg_descend(const PcgVectors& v, double step, int first_group, int last_group, double* loads,
                         double* sums) {
  Four rr = {}, rz = {};
  for (int g = first_group; g < last_group; ++g) {
    Four force = {}, moment = {};
    for (int i = v.group_begin[g]; i < v.group_begin[g + 1]; ++i) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(kLanes) * i;
      Four x, r, p, q, arm, c0, c1, c2;
      __builtin_memcpy(&x, v.x + at, sizeof x);
      __builtin_memcpy(&p, v.p + at, sizeof p);
      __builtin_memcpy(&r, v.r + at, sizeof r);
      __builtin_memcpy(&q, v.q + at, sizeof q);
      __builtin_memcpy(&arm, v.arms + at, sizeof arm);
      __builtin_memcpy(&c0, v.inverse + 3 * at, sizeof c0);
      __builtin_memcpy(&c1, v.inverse + 3 * at + kLanes, sizeof c1);
      __builtin_memcpy(&c2, v.inverse + 3 * at + 2 * kLanes, sizeof c2);
      x += step * p;
      r -= step * q;
      const Four z = c0 * r[0] + c1 * r[1] + c2 * r[2];
      __builtin_memcpy(v.x + at, &x, sizeof x);
      __builtin_memcpy(v.r + at, &r, sizeof r);
      __builtin_memcpy(v.z + at, &z, sizeof z);
      rr += r * r;
      rz += r * z;
      force += r;
      moment += KT_CROSS(arm, r);
    }
    double out[2 * kLanes];
    __builtin_memcpy(out, &force, sizeof force);
    __builtin_memcpy(out + kLanes, &moment, sizeof moment);
    for (int c = 0; c < 3; ++c) {
      loads[6 * g + c] = out[c];
      loads[6 * g + 3 + c] = out[kLanes + c];
    }
  }
  __builtin_memcpy(sums, &rr, sizeof rr);
  __builtin_memcpy(sums + kLanes, &rz, sizeof rz);
}

KT_WIDE void pcg_turn(const PcgVectors& v, double share, int first_group, int last_group, const double* motions) {
  for (int g = first_group; g < last_group; ++g) {
    const double* m = motions + 6 * g;
    const Four moved = {m[0], m[1], m[2], 0}, turn = {m[3], m[4], m[5], 0};
    for (int i = v.group_begin[g]; i < v.group_begin[g + 1]; ++i) {
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(kLanes) * i;
      Four p, z, arm;
      __builtin_memcpy(&p, v.p + at, sizeof p);
      __builtin_memcpy(&z, v.z + at, sizeof z);
      __builtin_memcpy(&arm, v.arms + at, sizeof arm);
      p = (z + moved + KT_CROSS(turn, arm)) + share * p;
      __builtin_memcpy(v.p + at, &p, sizeof p);
    }
  }
}

}  // namespace kt
