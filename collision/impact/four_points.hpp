#pragma once
// Four moving points, a vertex and a face or two edges, and the polynomials of time whose signs say when they touch.
//
//   vertex v, face a b c:      e1 = b - a,   e2 = c - a,   d = v - a     touch: d = beta e1 + gamma e2
//   edges a0 a1, b0 b1:        e1 = a1 - a0, e2 = b1 - b0, d = b0 - a0   touch: d = s e1 - r e2
//
// At a time t they touch if and only if
//   distance   (e1 x e2) . d = 0;
//   inside     in each coordinate plane the areas alpha, beta, gamma (or s, 1 - s, r, 1 - r, times e1 x e2) do not have
//              different signs;
//   overlap    on each axis the intervals that the two features cover meet.
// No case is left out: a triangle without area and parallel edges are decided by the last two. Proof:
// docs/collision.md.
#include "collision/impact/bernstein.hpp"
#include "collision/impact/expansion.hpp"
#include "core/base/types.hpp"

namespace kt {

enum class FeaturePair { vertex_face, edge_edge };

/// The four points as passed, and which of them takes which place.
struct MovingPoints {
  const Vec3 (&x_t0)[4];
  const Vec3 (&x_t1)[4];
  int index[4] = {0, 1, 2, 3};
  const Vec3& at(int end, int place) const noexcept { return (end == 0 ? x_t0 : x_t1)[index[place]]; }
};

/// q0 (1-t)^2 + middle t (1-t) + q2 t^2.
template <class Number>
struct Quadratic {
  Number q0, middle, q2;
};

/// The three vectors above at both ends of an interval of time.
template <class Number>
struct MovingVectors {
  Number e1[2][3], e2[2][3], d[2][3];
};

/// Component k of x(t) x y(t).
template <class Number>
Quadratic<Number> cross_component(const Number (&x)[2][3], const Number (&y)[2][3], int k) noexcept {
  const int i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
  return {x[0][i] * y[0][j] - x[0][j] * y[0][i],
          (x[0][i] * y[1][j] - x[0][j] * y[1][i]) + (x[1][i] * y[0][j] - x[1][j] * y[0][i]),
          x[1][i] * y[1][j] - x[1][j] * y[1][i]};
}

/// n . d, as the first coefficient, three times the two in the middle, and the last one.
template <class Number>
void volume_coefficients(const Quadratic<Number> (&n)[3], const Number (&d)[2][3], Number (&out)[4]) noexcept {
  out[0] = n[0].q0 * d[0][0] + n[1].q0 * d[0][1] + n[2].q0 * d[0][2];
  out[1] = (n[0].middle * d[0][0] + n[1].middle * d[0][1] + n[2].middle * d[0][2]) +
           (n[0].q0 * d[1][0] + n[1].q0 * d[1][1] + n[2].q0 * d[1][2]);
  out[2] = (n[0].q2 * d[0][0] + n[1].q2 * d[0][1] + n[2].q2 * d[0][2]) +
           (n[0].middle * d[1][0] + n[1].middle * d[1][1] + n[2].middle * d[1][2]);
  out[3] = n[0].q2 * d[1][0] + n[1].q2 * d[1][1] + n[2].q2 * d[1][2];
}

/// Component k of the normal e1 x e2, rounded, and a bound on its error at any time.
struct NormalComponent {
  Quadratic<double> q;
  double error;
  double value(double s) const noexcept {
    const double r = 1 - s;
    return r * (r * q.q0 + s * q.middle) + s * s * q.q2;
  }
};

/// Which difference of two points, as their places, each vector is.
struct VectorPlaces {
  int e1[2], e2[2], d[2];
};
constexpr VectorPlaces vector_places(FeaturePair pair) noexcept {
  return pair == FeaturePair::vertex_face ? VectorPlaces{{2, 1}, {3, 1}, {0, 1}} : VectorPlaces{{1, 0}, {3, 2}, {2, 0}};
}

/// The polynomials from vectors rounded once. Valid on the whole step; the bounds are those of docs/collision.md.
class RoundedMotion {
 public:
  RoundedMotion(FeaturePair pair, const MovingPoints& x) noexcept;

  FeaturePair pair() const noexcept { return pair_; }
  const MovingVectors<double>& vectors() const noexcept { return v_; }
  const bernstein::Cubic& distance() const noexcept { return distance_; }
  NormalComponent normal(int k) const noexcept {
    return {n_[k], kNormalError * magnitude(e1_max_, e2_max_, k) + bernstein::kUnderflow};
  }
  /// The areas of coordinate plane k; returns how many.
  int inside(int k, bernstein::Cubic (&out)[4]) const noexcept;
  /// On axis k, all differences of a point of one feature and one of the other; returns how many.
  int gaps(int k, bernstein::Cubic (&out)[4]) const noexcept;

 private:
  /// What the coefficients of component k of x x y sum up to at most when no sign cancels.
  static double magnitude(const double (&x)[3], const double (&y)[3], int k) noexcept {
    const int i = k == 2 ? 0 : k + 1, j = k == 0 ? 2 : k - 1;
    return x[i] * y[j] + x[j] * y[i];
  }
  static constexpr double kNormalError = 16 * bernstein::kRoundoff;

  FeaturePair pair_;
  MovingVectors<double> v_;
  double e1_max_[3], e2_max_[3], d_max_[3];
  Quadratic<double> n_[3];
  bernstein::Cubic distance_;
};

/// At the start of the step, exactly: the four points are in one plane and no area of coordinate plane k has another
/// sign than the normal, which is not zero there.
bool touch_at_start(FeaturePair pair, const MovingPoints& x, int k) noexcept;

using ExactVectors = MovingVectors<Expansion>;

ExactVectors exact_vectors(FeaturePair pair, const MovingPoints& x) noexcept;
/// The part [low, high] of their interval of time; both numbers should have few bits.
ExactVectors restricted(const ExactVectors& v, double low, double high) noexcept;

/// The same from exact arithmetic: coefficients are wrong in the last place only. Those that did not fit into the fixed
/// memory have an infinite error. Borrows `vectors`.
class ExactMotion {
 public:
  ExactMotion(FeaturePair pair, const ExactVectors& vectors) noexcept;

  FeaturePair pair() const noexcept { return pair_; }
  const bernstein::Cubic& distance() const noexcept { return distance_; }
  NormalComponent normal(int k) const noexcept { return normal_[k]; }
  int inside(int k, bernstein::Cubic (&out)[4]) const noexcept { return inside_[k].get(*this, k, out); }
  int gaps(int k, bernstein::Cubic (&out)[4]) const noexcept { return gaps_[k].get(*this, k, out); }

 private:
  using Find = int (ExactMotion::*)(int k, bernstein::Cubic (&out)[4]) const noexcept;
  int find_inside(int k, bernstein::Cubic (&out)[4]) const noexcept;
  int find_gaps(int k, bernstein::Cubic (&out)[4]) const noexcept;

  /// Found when first asked for: a search asks for the same ones again and again.
  template <Find find>
  struct Kept {
    int num = 0;
    bernstein::Cubic c[4];
    int get(const ExactMotion& m, int k, bernstein::Cubic (&out)[4]) noexcept {
      if (num == 0) num = (m.*find)(k, c);
      std::copy_n(c, num, out);
      return num;
    }
  };

  FeaturePair pair_;
  const ExactVectors& v_;
  Quadratic<Expansion> n_[3];
  NormalComponent normal_[3];
  bernstein::Cubic distance_;
  mutable Kept<&ExactMotion::find_inside> inside_[3];
  mutable Kept<&ExactMotion::find_gaps> gaps_[3];
};

}  // namespace kt
