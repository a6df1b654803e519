#include "haptics/refresh/excitation.hpp"

#include <cmath>
#include <numbers>

#include "core/local/certified_rates.hpp"
#include "haptics/options/band_powers.hpp"

namespace kt {
namespace {

/// Between the band of this index and the next [Hz].
double upper_border(std::size_t band) {
  const double below = kCertifiedHz[band], above = kCertifiedHz[band + 1];
  return below > 0 ? std::sqrt(below * above) : 0.5 * above;
}

}  // namespace

SpectrumMeter::SpectrumMeter(double rate_hz, double use, double memory) : rate_hz_(rate_hz) {
  const double h = 1 / rate_hz, corner = std::sqrt(3.0) / use;  // [rad/s]: (x^2)/3 = (w / corner)^2
  keep_ = std::exp(-h / memory);
  pass_ = 1 / (1 + h * corner);
  for (std::size_t i = 0; i < borders_.size(); ++i) {
    const double hz = upper_border(i);
    Border border{0, 0, 0, Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), 0};
    if (hz < 0.5 * rate_hz) {
      const double k = std::tan(std::numbers::pi * hz / rate_hz), q = std::numbers::sqrt2;
      const double a0 = 1 + q * k + k * k;
      border.b0 = 1 / a0;
      border.a1 = 2 * (k * k - 1) / a0;
      border.a2 = (1 - q * k + k * k) / a0;
    }
    borders_[i] = border;
  }
}

void SpectrumMeter::add(const Vec3& value) {
  changing_ = pass_ * (changing_ + value - last_);
  last_ = value;
  count_ += 1;
  weight_ = keep_ * weight_ + 1;
  total_ = keep_ * total_ + value.squaredNorm();
  all_changing_ = keep_ * all_changing_ + changing_.squaredNorm();
  for (Border& b : borders_) {
    const Vec3 y = b.b0 * (changing_ - 2 * b.x1 + b.x2) - b.a1 * b.y1 - b.a2 * b.y2;
    b.x2 = b.x1;
    b.x1 = changing_;
    b.y2 = b.y1;
    b.y1 = y;
    b.sum = keep_ * b.sum + y.squaredNorm();
  }
}

BandPowers SpectrumMeter::powers() const {
  BandPowers out{};
  if (!(weight_ > 0)) return out;
  out.total = total_ / weight_;
  double above = all_changing_;
  for (std::size_t i = 0; i < kBands; ++i) {
    const double next = i < borders_.size() ? borders_[i].sum : 0;
    out.changing[i] = std::max(0.0, above - next) / weight_;
    above = next;
  }
  return out;
}

Excitation excitation_of(const BandPowers& force) {
  Excitation out{};
  if (!(force.total > 0)) return out;
  for (std::size_t i = 0; i < kBands; ++i) out[i] = force.changing[i] / force.total;
  return out;
}

Excitation excitation_of(const BandPowers& motion, const std::array<double, kBands>& impedance) {
  double slowest = std::numeric_limits<double>::quiet_NaN();
  for (const double z : impedance)
    if (std::isfinite(z) && std::isnan(slowest)) slowest = z;
  BandPowers force{slowest * slowest * motion.total, {}};
  for (std::size_t i = 0; i < kBands; ++i) {
    const double square = std::isfinite(impedance[i]) ? impedance[i] * impedance[i] : slowest * slowest;
    force.changing[i] = square * motion.changing[i];
    force.total += std::max(0.0, square - slowest * slowest) * motion.changing[i];
  }
  return excitation_of(force);
}

double expected_force_error(const Excitation& shares, std::span<const double> errors) {
  double sum = 0;
  for (std::size_t i = 0; i < std::min(errors.size(), shares.size()); ++i) {
    if (std::isnan(errors[i])) continue;
    if (std::isinf(errors[i])) return errors[i];
    sum += shares[i] * errors[i] * errors[i];
  }
  return std::sqrt(sum);
}

}  // namespace kt
