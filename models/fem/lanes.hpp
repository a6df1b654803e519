#pragma once
// Four numbers calculated side by side, in two SIMD registers of two doubles, as x86-64 and ARM64 always have: the same
// bits on every machine. Eigen matrices of them are four matrices at once.
#include <cmath>

#include "core/types.hpp"

namespace kt {

struct Lanes {
  static constexpr int kCount = 4;
  using Pair = double __attribute__((vector_size(16)));
  Pair low, high;

  Lanes() = default;
  Lanes(double all) : low{all, all}, high{all, all} {}  // NOLINT: a number among lanes is the same in all
  Lanes(Pair l, Pair h) : low(l), high(h) {}
  double operator[](int i) const { return i < 2 ? low[i] : high[i - 2]; }
  void set(int i, double value) { (i < 2 ? low : high)[i % 2] = value; }

  Lanes operator-() const { return {-low, -high}; }
  Lanes& operator+=(const Lanes& b) { return *this = {low + b.low, high + b.high}; }
  Lanes& operator-=(const Lanes& b) { return *this = {low - b.low, high - b.high}; }
  Lanes& operator*=(const Lanes& b) { return *this = {low * b.low, high * b.high}; }
  Lanes& operator/=(const Lanes& b) { return *this = {low / b.low, high / b.high}; }
  friend Lanes operator+(Lanes a, const Lanes& b) { return a += b; }
  friend Lanes operator-(Lanes a, const Lanes& b) { return a -= b; }
  friend Lanes operator*(Lanes a, const Lanes& b) { return a *= b; }
  friend Lanes operator/(Lanes a, const Lanes& b) { return a /= b; }
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

template <class Function>
Lanes each_lane(const Lanes& a, const Function& f) {
  return {Lanes::Pair{f(a.low[0]), f(a.low[1])}, Lanes::Pair{f(a.high[0]), f(a.high[1])}};
}
inline Lanes sqrt(const Lanes& a) {
  return each_lane(a, [](double v) { return std::sqrt(v); });
}
inline Lanes abs(const Lanes& a) {
  return each_lane(a, [](double v) { return std::abs(v); });
}

/// a < b in every lane; false with NaN.
inline bool all_less(double a, double b) { return a < b; }
inline bool all_less(const Lanes& a, const Lanes& b) {
  const auto low = a.low < b.low, high = a.high < b.high;
  return low[0] && low[1] && high[0] && high[1];
}
/// a >= 0 in every lane.
inline bool none_negative(const Lanes& a) { return a.low[0] >= 0 && a.low[1] >= 0 && a.high[0] >= 0 && a.high[1] >= 0; }

/// a where condition < 0, else b.
inline Lanes select_negative(const Lanes& condition, const Lanes& a, const Lanes& b) {
  return {condition.low < 0 ? a.low : b.low, condition.high < 0 ? a.high : b.high};
}
inline Lanes positive_part(const Lanes& a) { return select_negative(a, 0, a); }

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
  const auto add = [](double* at, double first, double second) {
    at[0] += first;
    at[1] += second;
  };
  for (int i = 0; i < 8; i += 2) {
    const Lanes a = m(i), b = m(i + 1);
    add(to[0] + i, a.low[0], b.low[0]);
    add(to[1] + i, a.low[1], b.low[1]);
    add(to[2] + i, a.high[0], b.high[0]);
    add(to[3] + i, a.high[1], b.high[1]);
  }
  for (int lane = 0; lane < Lanes::kCount; ++lane) to[lane][8] += m(8)[lane];
}

}  // namespace kt
