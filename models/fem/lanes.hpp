#pragma once
// Four numbers calculated side by side, in the widest registers that the processor has: the same bits on every machine.
// Eigen matrices of them are four matrices at once.
//
// KT_LANES before a function: it is compiled for several widths, with all that it calls. Lanes do not leave such a
// function by value, in neither direction: how they travel depends on the width.
#include <cmath>
#include <cstring>

#include "core/base/types.hpp"
#include "core/base/wide.hpp"

#define KT_LANES KT_WIDE __attribute__((flatten))

namespace kt {

/// The alignment is said, since it must be the same in functions for all widths: without AVX a vector has less.
struct alignas(32) Lanes {
  static constexpr int kCount = 4;
  using Vector = double __attribute__((vector_size(32)));
  Vector v;

  Lanes() = default;
  KT_INLINE Lanes(double all) : v{all, all, all, all} {}  // NOLINT: a number among lanes is the same in all
  KT_INLINE explicit Lanes(const Vector& all) : v(all) {}
  double operator[](int i) const { return v[i]; }
  void set(int i, double value) { v[i] = value; }

  KT_INLINE Lanes operator-() const { return Lanes(-v); }
  KT_INLINE Lanes& operator+=(const Lanes& b) {
    v += b.v;
    return *this;
  }
  KT_INLINE Lanes& operator-=(const Lanes& b) {
    v -= b.v;
    return *this;
  }
  KT_INLINE Lanes& operator*=(const Lanes& b) {
    v *= b.v;
    return *this;
  }
  KT_INLINE Lanes& operator/=(const Lanes& b) {
    v /= b.v;
    return *this;
  }
  KT_INLINE friend Lanes operator+(const Lanes& a, const Lanes& b) { return Lanes(a.v + b.v); }
  KT_INLINE friend Lanes operator-(const Lanes& a, const Lanes& b) { return Lanes(a.v - b.v); }
  KT_INLINE friend Lanes operator*(const Lanes& a, const Lanes& b) { return Lanes(a.v * b.v); }
  KT_INLINE friend Lanes operator/(const Lanes& a, const Lanes& b) { return Lanes(a.v / b.v); }
};

}  // namespace kt

template <>
struct Eigen::NumTraits<kt::Lanes> : Eigen::GenericNumTraits<kt::Lanes> {
  enum {
    IsInteger = 0,
    IsSigned = 1,
    IsComplex = 0,
    RequireInitialization = 0,
    ReadCost = 2,
    AddCost = 2,
    MulCost = 2
  };
};

namespace kt {

KT_INLINE Lanes sqrt(const Lanes& a) {
  Lanes out;
  for (int i = 0; i < Lanes::kCount; ++i) out.v[i] = std::sqrt(a.v[i]);
  return out;
}
KT_INLINE Lanes abs(const Lanes& a) {
  Lanes out;
  for (int i = 0; i < Lanes::kCount; ++i) out.v[i] = std::abs(a.v[i]);
  return out;
}

/// a < b in every lane; false with NaN.
inline bool all_less(double a, double b) { return a < b; }
KT_INLINE bool all_less(const Lanes& a, const Lanes& b) {
  const auto less = a.v < b.v;
  return less[0] && less[1] && less[2] && less[3];
}
/// a >= 0 in every lane.
KT_INLINE bool none_negative(const Lanes& a) {
  const auto is = a.v >= 0;
  return is[0] && is[1] && is[2] && is[3];
}

/// a where condition < 0, else b.
KT_INLINE Lanes select_negative(const Lanes& condition, const Lanes& a, const Lanes& b) {
  return Lanes(condition.v < 0 ? a.v : b.v);
}
KT_INLINE Lanes positive_part(const Lanes& a) { return select_negative(a, 0, a); }

/// Formulas for one T = double and for four T = Lanes.
template <class T>
using Vec3Of = Eigen::Matrix<T, 3, 1>;
template <class T>
using Mat3Of = Eigen::Matrix<T, 3, 3>;
using LaneVec3 = Vec3Of<Lanes>;
using LaneMat3 = Mat3Of<Lanes>;

template <class Matrix>
Eigen::Matrix<double, Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime> get_lane(const Matrix& m, int lane) {
  Eigen::Matrix<double, Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime> out;
  for (int i = 0; i < m.size(); ++i) out(i) = m(i)[lane];
  return out;
}
template <class Matrix, class Values>
void set_lane(Matrix& m, int lane, const Values& values) {
  for (int i = 0; i < m.size(); ++i) m(i).set(lane, values(i));
}

/// Adds each lane's matrix, column by column, to the nine numbers at to[lane].
inline void add_to(const std::array<double*, Lanes::kCount>& to, const LaneMat3& m) {
  for (int i = 0; i < 8; i += 4) {  // four lanes of four numbers become four numbers of four lanes
    const Lanes::Vector &a = m(i).v, &b = m(i + 1).v, &c = m(i + 2).v, &d = m(i + 3).v;
    const Lanes::Vector ab_even = KT_SHUFFLE(a, b, 0, 4, 2, 6), ab_odd = KT_SHUFFLE(a, b, 1, 5, 3, 7),
                        cd_even = KT_SHUFFLE(c, d, 0, 4, 2, 6), cd_odd = KT_SHUFFLE(c, d, 1, 5, 3, 7);
    const Lanes::Vector rows[4] = {KT_SHUFFLE(ab_even, cd_even, 0, 1, 4, 5), KT_SHUFFLE(ab_odd, cd_odd, 0, 1, 4, 5),
                                   KT_SHUFFLE(ab_even, cd_even, 2, 3, 6, 7), KT_SHUFFLE(ab_odd, cd_odd, 2, 3, 6, 7)};
    for (int lane = 0; lane < Lanes::kCount; ++lane) {
      Lanes::Vector sum;
      std::memcpy(&sum, to[lane] + i, sizeof sum);
      sum += rows[lane];
      std::memcpy(to[lane] + i, &sum, sizeof sum);
    }
  }
  for (int lane = 0; lane < Lanes::kCount; ++lane) to[lane][8] += m(8)[lane];
}

}  // namespace kt
