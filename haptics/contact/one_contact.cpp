#include "haptics/contact/one_contact.hpp"

#include <limits>

namespace kt {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kImmovable = 1e-13;  // of the trace: a direction that gives way less has lost its digits
constexpr double kNearly = 2e-7;      // relative: its square is rounding, so the last step needs no evaluation
constexpr int kMaxSteps = 120;        // bisection alone ends in 60 from any bracket

/// Orthonormal frame with m as its first column (Duff et al. 2017, branch on the sign).
Mat3 frame_of(const Vec3& m) {
  const double sign = std::copysign(1.0, m.z());
  const double a = -1.0 / (sign + m.z()), b = m.x() * m.y() * a;
  Mat3 frame;
  frame.col(0) = m;
  frame.col(1) = Vec3(1 + sign * m.x() * m.x() * a, sign * b, -sign * m.x());
  frame.col(2) = Vec3(b, sign + m.y() * m.y() * a, -m.y());
  return frame;
}

/// Slip as a function of lambda, in the eigenvectors of S. With D = (s_0 + lambda)(s_1 + lambda) as the denominator of
/// everything, D p_t and D p_m are polynomials, and a step of Newton's method needs one division.
struct Slip {
  double b_m, inverse_m;  // 1 / W_mm
  Vec2 w, s, c;
  const Friction& friction;
  bool weakens;  // else mu is the kinetic one

  double lambda = 0, mu = 0;
  double held = 0, pull = 0;  // D^2 times: (mu p_m)^2, and |p_t|^2; they are equal at the solution
  double slope = 0;           // of held / pull, times pull^2
  double noise = 0;           // rounding of held - pull
  Vec2 q{};                   // p_t
  double p_m = 0;

  void evaluate() {
    const double d0 = s[0] + lambda, d1 = s[1] + lambda, denominator = d0 * d1;
    const double q0 = c[0] * d1, q1 = c[1] * d0, along = w[0] * q0 + w[1] * q1;  // -D p_t
    const double push = (along - b_m * denominator) * inverse_m;                 // D p_m
    const double push_rate = (w.dot(c) - b_m * (d0 + d1)) * inverse_m;
    pull = q0 * q0 + q1 * q1;
    const double pull_rate = 2 * (q0 * c[0] + q1 * c[1]);
    mu = friction.mu_kinetic;
    double mu_rate = 0;
    if (weakens) {
      const double length = std::sqrt(pull), speed = lambda * length / denominator;
      mu = friction.mu_at(speed);
      const double speed_rate =
          (length + lambda * (0.5 * pull_rate / length - length * (d0 + d1) / denominator)) / denominator;
      mu_rate = -2 * speed / (friction.stribeck * friction.stribeck) * (mu - friction.mu_kinetic) * speed_rate;
    }
    const double grip = mu * mu * push;
    held = push > 0 ? grip * push : -pull;  // a pull is further from a solution than no impulse
    slope = 2 * (grip * push_rate + mu * mu_rate * push * push) * pull - held * pull_rate;
    noise = 8 * kEps * (pull + std::abs(grip) * inverse_m * (std::abs(b_m) * denominator + std::abs(along)));
  }

  bool is_solved() const { return std::abs(held - pull) <= noise; }
  bool is_beyond() const { return held >= pull; }

  /// Newton's step for mu p_m / |p_t| - 1, which is nearly a straight line, told from its square without a root.
  double step() const {
    if (!(held > 0)) return kInfinity;
    return -2 * (held - pull) * (held + pull) * pull / ((held + 3 * pull) * slope);
  }

  void find_impulse() {
    const double d0 = s[0] + lambda, d1 = s[1] + lambda, inverse = 1 / (d0 * d1);
    q = Vec2(-c[0] * d1 * inverse, -c[1] * d0 * inverse);
    p_m = -(b_m + w.dot(q)) * inverse_m;
  }

  /// Newton's method, kept between `low` and `high`, where held - pull is negative and positive.
  void solve(double start, double low, double high) {
    lambda = start;
    for (int i = 0; i < kMaxSteps; ++i) {
      evaluate();
      if (is_solved()) return;
      double next = lambda + step();
      if (std::abs(held - pull) < kNearly * pull && !weakens && slope * lambda > 0.2 * pull * pull) {
        lambda = next;
        return;
      }
      (is_beyond() ? high : low) = lambda;
      if (!(next > low && next < high)) next = high < kInfinity ? 0.5 * (low + high) : 2 * lambda + s[0] + s[1];
      if (next == lambda) return;
      lambda = next;
    }
  }

  /// From where the kinetic coefficient alone would have it down to the first speed that suits its own coefficient.
  bool solve_from_above() {
    double high = lambda;
    for (int i = 0; i < kMaxSteps; ++i) {
      evaluate();
      if (is_solved()) return true;
      if (!is_beyond()) {
        solve(0.5 * (lambda + high), lambda, high);
        return true;
      }
      high = lambda;
      if (slope <= 0) return false;
      lambda += step();
      if (!(lambda > 0)) return false;
    }
    return false;
  }
};

}  // namespace

OneContact::OneContact(const Mat3& W, const Vec3& normal) noexcept {
  const Mat3 frame = frame_of(-normal);
  const Vec3 to_m = W * frame.col(0), to_1 = W * frame.col(1), to_2 = W * frame.col(2);
  const double least = std::max(kImmovable * W.trace(), std::numeric_limits<double>::min());
  inverse_m_ = 1 / std::max(frame.col(0).dot(to_m), least);
  const double w1 = frame.col(1).dot(to_m), w2 = frame.col(2).dot(to_m);
  const double s11 = frame.col(1).dot(to_1) - w1 * w1 * inverse_m_, s22 = frame.col(2).dot(to_2) - w2 * w2 * inverse_m_,
               s12 = frame.col(2).dot(to_1) - w1 * w2 * inverse_m_;
  // Jacobi's rotation makes S diagonal.
  double t = 0;
  if (s12 * s12 > 0) {
    const double half = 0.5 * (s22 - s11);
    t = std::copysign(s12, half * s12) / (std::abs(half) + std::sqrt(half * half + s12 * s12));
  }
  const double cosine = 1 / std::sqrt(1 + t * t), sine = t * cosine;
  frame_.col(0) = frame.col(0);
  frame_.col(1) = cosine * frame.col(1) - sine * frame.col(2);
  frame_.col(2) = sine * frame.col(1) + cosine * frame.col(2);
  w_ = Vec2(cosine * w1 - sine * w2, sine * w1 + cosine * w2);
  s_ = Vec2(std::max(s11 - t * s12, least), std::max(s22 + t * s12, least));
  inverse_s_ = Vec2(1 / s_[0], 1 / s_[1]);
}

double OneContact::slip_ratio(const Vec3& b, const Vec3& impulse) const noexcept {
  const Vec2 q(frame_.col(1).dot(impulse), frame_.col(2).dot(impulse));
  const double length_sq = q.squaredNorm(), b_m = frame_.col(0).dot(b) * inverse_m_;
  if (!(length_sq > 0)) return 0;
  const Vec2 c(frame_.col(1).dot(b) - w_[0] * b_m, frame_.col(2).dot(b) - w_[1] * b_m);
  return -(q.dot(c) + q[0] * q[0] * s_[0] + q[1] * q[1] * s_[1]) / length_sq;
}

OneContactSolution OneContact::solve(const Vec3& b_world, const Friction& friction, bool sliding,
                                     double start) const noexcept {
  const double b_m = frame_.col(0).dot(b_world);
  if (b_m >= 0) return {};  // the body leaves the tool by itself
  const double frictionless = -b_m * inverse_m_;
  if (friction.mu_static == 0) return {frame_.col(0) * frictionless, ContactMode::slide};

  const Vec2 c(frame_.col(1).dot(b_world) + w_[0] * frictionless, frame_.col(2).dot(b_world) + w_[1] * frictionless);
  const Vec2 held(-c[0] * inverse_s_[0], -c[1] * inverse_s_[1]);  // sticking
  const double held_m = frictionless - w_.dot(held) * inverse_m_, held_sq = held.squaredNorm();
  const auto holds = [&](double mu) { return held_m >= 0 && held_sq <= mu * mu * held_m * held_m; };
  const auto stick = [&](double mu) -> OneContactSolution {
    return {frame_.col(0) * held_m + frame_.col(1) * held[0] + frame_.col(2) * held[1], ContactMode::stick, mu};
  };
  const bool weakens = friction.stribeck > 0;
  if (!sliding && holds(friction.mu_static)) return stick(friction.mu_static);
  if (sliding && holds(friction.mu_kinetic)) return stick(weakens ? friction.mu_static : friction.mu_kinetic);
  if (friction.mu_kinetic == 0 && !weakens) return {frame_.col(0) * frictionless, ContactMode::frictional_slide};

  if (!(start > 0)) {  // as if normal and tangential impulses were independent
    const double mu = std::max(friction.mu_kinetic, 0.01 * friction.mu_static);
    start = std::max(0.0, c.norm() / (mu * frictionless) - 0.5 * (s_[0] + s_[1]));
  }
  Slip slip{b_m, inverse_m_, w_, s_, c, friction, weakens};
  if (weakens && sliding) {  // of several self-consistent speeds the fastest: it stays on its branch
    slip.weakens = false;
    if (friction.mu_kinetic > 0) slip.solve(start, 0, kInfinity);
    slip.weakens = true;
    const bool found = friction.mu_kinetic > 0 && slip.solve_from_above();
    if (!found && holds(friction.mu_static)) return stick(friction.mu_static);
    if (!found) slip.solve(start, 0, kInfinity);
  } else {
    slip.solve(start, 0, kInfinity);
  }
  slip.find_impulse();
  // Onto the cone to the last digit: slip.q has that length up to the accuracy, so that a root is not needed.
  const double p_m = std::max(slip.p_m, 0.0);
  const double t = 0.5 + 0.5 * slip.mu * slip.mu * p_m * p_m / slip.q.squaredNorm();
  return {frame_.col(0) * p_m + frame_.col(1) * (t * slip.q[0]) + frame_.col(2) * (t * slip.q[1]),
          ContactMode::frictional_slide, slip.mu, slip.lambda};
}

}  // namespace kt
