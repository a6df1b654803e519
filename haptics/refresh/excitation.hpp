#pragma once
// Which rates a force is made of, and how much of it a local model has to get right by itself: the whole body finds its
// own balance at each refresh, so that only what changes while a local model is in use counts against the model.
// docs/method.md#4-the-local-model-section-iii
#include <array>
#include <span>

#include "core/base/types.hpp"
#include "core/local/certified_rates.hpp"
#include "haptics/options/band_powers.hpp"

namespace kt {

/// Share of the force's mean square that changes while a local model is in use, about each of kCertifiedHz [-].
using Excitation = std::array<double, kBands>;

/// Of a signal, sample by sample. A band reaches to the geometric mean with its neighbours (the lowest to half the
/// second's frequency): second-order Butterworth high-passes at these borders, whose powers are subtracted, so that
/// none is lost or counted twice.
class SpectrumMeter {
 public:
  /// @param use     how long a local model serves [s]: of a swing at f it has to follow 2 (1 - sin(x)/x), x = 2 pi f
  /// use,
  ///                on average, (x^2)/3 where that is small; a first-order high-pass with that limit stands for it
  /// @param memory  after which a sample counts 1/e [s]; infinity: all count alike
  SpectrumMeter(double rate_hz, double use, double memory);
  void add(const Vec3& value);
  BandPowers powers() const;
  double seconds() const { return count_ / rate_hz_; }  ///< of the signal so far

 private:
  struct Border {
    double b0, a1, a2;    // of the high-pass; none above half the rate
    Vec3 x1, x2, y1, y2;  // its state
    double sum;           // of squares above it
  };
  double rate_hz_, keep_, pass_;  // of the sums, a sample; of the first-order high-pass
  Vec3 last_ = Vec3::Zero(), changing_ = Vec3::Zero();
  std::array<Border, kBands - 1> borders_;
  double count_ = 0, weight_ = 0, total_ = 0, all_changing_ = 0;
};

/// Of a force as it is.
Excitation excitation_of(const BandPowers& force);
/// Of the force that a motion of the surface asks for.
/// @param impedance  of the body at kCertifiedHz [N/m]; NaN: not known there
Excitation excitation_of(const BandPowers& motion, const std::array<double, kBands>& impedance);

/// Relative error of the force to expect, RMS over RMS, from relative errors of the impedance: sqrt(sum share error^2).
/// @param errors  at the first of kCertifiedHz, ascending; NaN: not known, left out
double expected_force_error(const Excitation& shares, std::span<const double> errors);

}  // namespace kt
