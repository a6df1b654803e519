#include "haptics/safety/identify.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/types.hpp"

namespace kt {
namespace {

/// First and second integral of the force, `delay` late, at each sample: exact for a force that is held.
struct ForceIntegrals {
  VectorX once, twice;  // [N s], [N s^2]
};

ForceIntegrals integrals(std::span<const ReleaseSample> s, double delay) {
  const auto n = static_cast<int>(s.size());
  ForceIntegrals out{VectorX::Zero(n), VectorX::Zero(n)};
  double t = s[0].t, once = 0, twice = 0, force = 0;
  int next = 0;  // force that acts next
  const auto go_to = [&](double end) {
    const double d = end - t;
    twice += (once + 0.5 * force * d) * d;
    once += force * d;
    t = end;
  };
  for (int i = 0; i < n; ++i) {
    for (; next < n && s[next].t + delay <= s[i].t; ++next) {
      go_to(s[next].t + delay);
      force = s[next].force;
    }
    go_to(s[i].t);
    out.once[i] = once;
    out.twice[i] = twice;
  }
  return out;
}

/// Columns x, int x and 1, from the first sample on. No column t: it begins at rest.
MatrixX columns(std::span<const ReleaseSample> s) {
  MatrixX out(static_cast<int>(s.size()), 3);
  double sum = 0;
  for (int i = 0; i < out.rows(); ++i) {
    if (i > 0) sum += 0.5 * (s[i].x + s[i - 1].x - 2 * s[0].x) * (s[i].t - s[i - 1].t);
    out.row(i) << s[i].x - s[0].x, sum, 1;
  }
  return out;
}

class Fit {
 public:
  explicit Fit(std::span<const ReleaseSample> s) : samples_(s), a_(columns(s)), solver_(a_) {}

  double squares(double delay) const {
    const VectorX y = integrals(samples_, delay).twice;
    return (y - a_ * solver_.solve(y)).squaredNorm();
  }

  DeviceFit at(double delay) const {
    const ForceIntegrals f = integrals(samples_, delay);
    const VectorX p = solver_.solve(f.twice);
    const double sum = (f.twice - a_ * p).squaredNorm();
    DeviceFit out;
    out.mass = p[0];
    out.damping = p[1];
    out.delay = delay;
    MatrixX jacobian(a_.rows(), 4);  // the second integral falls by the first with the delay
    jacobian << a_, f.once;
    const VectorX size = jacobian.colwise().norm();
    const MatrixX scaled = jacobian * size.cwiseMax(1e-300).cwiseInverse().asDiagonal();
    const double variance = sum / std::max(1.0, static_cast<double>(a_.rows() - 4));
    const MatrixX inverse = (scaled.transpose() * scaled).ldlt().solve(MatrixX::Identity(4, 4));
    const auto error = [&](int i) { return 2 * std::sqrt(variance * std::max(0.0, inverse(i, i))) / size[i]; };
    out.mass_error = error(0);
    out.damping_error = error(1);
    out.delay_error = error(3);
    out.residual = std::sqrt(sum / static_cast<double>(a_.rows())) / std::max(std::abs(out.mass), 1e-12);
    return out;
  }

 private:
  std::span<const ReleaseSample> samples_;
  MatrixX a_;
  Eigen::ColPivHouseholderQR<MatrixX> solver_;
};

/// Of the smallest sum of squares: the best of a grid, then by golden section.
double best_delay(const Fit& fit, double most) {
  constexpr int kSteps = 80;
  double best = 0, least = fit.squares(0);
  for (int i = 1; i <= kSteps; ++i)
    if (const double sum = fit.squares(most * i / kSteps); sum < least) {
      least = sum;
      best = most * i / kSteps;
    }
  const double golden = 0.5 * (std::sqrt(5.0) - 1);
  double low = std::max(0.0, best - most / kSteps), high = std::min(most, best + most / kSteps);
  while (high - low > 1e-7) {
    const double a = high - golden * (high - low), b = low + golden * (high - low);
    const bool is_left = fit.squares(a) < fit.squares(b);
    (is_left ? high : low) = is_left ? b : a;
  }
  return 0.5 * (low + high);
}

/// What sums of rounded positions are off by, all in one direction, and no spread tells of: a step of the swing.
void add_rounding(std::span<const ReleaseSample> samples, double encoder_step, DeviceFit& fit) {
  constexpr double kMass = 1e-3, kDamping = 5e-4, kDelay = 2e-5;  // [-], [N s/m], [s] at least
  double force = 0;
  for (const ReleaseSample& s : samples) force = std::max(force, std::abs(s.force));
  const double rounding = encoder_step / fit.swing, stiffness = 2 * force / fit.swing;
  const double impedance = std::sqrt(stiffness * std::max(fit.mass, 0.0));  // of the swing [N s/m]
  fit.mass_error = std::hypot(fit.mass_error, kMass * fit.mass, rounding * fit.mass);
  fit.damping_error = std::hypot(fit.damping_error, kDamping, rounding * impedance);
  if (stiffness > 0) fit.delay_error = std::hypot(fit.delay_error, kDelay, rounding * impedance / stiffness);
}

std::string refusal_of(const DeviceFit& fit, double encoder_step, double most_delay) {
  constexpr double kMostResidual = 0.02;  // of the swing: five times that of the worst encoder that is let in here
  constexpr double kMostError = 0.5;
  constexpr double kMostMass = 5;  // [kg] of a device that a hand moves
  const double noise = std::max(kMostResidual * fit.swing, 2 * encoder_step);
  if (!(fit.residual <= noise))
    return text("a free mass with a damper leaves ", 1e3 * fit.residual, " mm of a swing of ", 1e3 * fit.swing,
                " mm: was it held, or does it stick?");
  if (!(fit.mass > 0 && fit.mass <= kMostMass))
    return text("a mass of ", fit.mass, " kg fits best: do the forces reach its motors?");
  if (!(fit.mass_error <= kMostError * fit.mass))
    return text("the mass is known to ", fit.mass_error, " of ", fit.mass, " kg only");
  if (fit.delay > 0.99 * most_delay) return text("a delay of more than ", 1e3 * most_delay, " ms fits best");
  if (!(fit.damping > 0)) return text("a damping of ", fit.damping, " N.s/m fits best");
  if (!(fit.damping_error <= kMostError * fit.damping))
    return text("the damping is known to ", fit.damping_error, " of ", fit.damping, " N.s/m only");
  return {};
}

}  // namespace

DeviceFit fit_release(std::span<const ReleaseSample> samples, double encoder_step, double most_delay) {
  constexpr std::size_t kLeastSamples = 100;
  constexpr double kLeastTime = 0.1;    // [s]
  constexpr double kLeastSteps = 100;   // of the encoder, of swing
  constexpr double kLeastSwing = 1e-3;  // [m]: a hand at rest trembles, and a device without force drifts
  DeviceFit out;
  if (samples.size() < kLeastSamples || !(samples.back().t - samples.front().t >= kLeastTime)) {
    out.refusal = text(samples.size(), " samples are too few: at least ", kLeastSamples, " over ", kLeastTime, " s");
    return out;
  }
  double low = samples[0].x, high = low;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const ReleaseSample& s = samples[i];
    if (!std::isfinite(s.t + s.x + s.force) || (i > 0 && !(s.t > samples[i - 1].t))) {
      out.refusal = text("sample ", i, ": not finite, or not later than the one before");
      return out;
    }
    low = std::min(low, s.x);
    high = std::max(high, s.x);
  }
  const double swing = high - low;
  if (!(swing > std::max(kLeastSteps * encoder_step, kLeastSwing))) {
    out.refusal = text("it moved by ", 1e3 * swing, " mm only");
    return out;
  }
  const Fit fit(samples);
  out = fit.at(best_delay(fit, most_delay));
  out.swing = swing;
  add_rounding(samples, encoder_step, out);
  out.refusal = refusal_of(out, encoder_step, most_delay);
  return out;
}

}  // namespace kt
