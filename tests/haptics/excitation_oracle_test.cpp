// What a force is made of, against closed forms; and the force error that is expected from it, against forces.
#include "core/local/certified_rates.hpp"
#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/excitation.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <numbers>
#include <numeric>
#include <random>

namespace kt {
namespace {

constexpr double kRate = 1000, kForever = std::numeric_limits<double>::infinity();
constexpr double kUse = 1 / 30.0;

double angle(double hz, double t) { return 2 * std::numbers::pi * hz * t; }

template <class Signal>
BandPowers measured(const Signal& signal, double use = kUse, double memory = kForever, int ticks = 20000) {
  SpectrumMeter meter(kRate, use, memory);
  for (int i = 0; i < ticks; ++i) meter.add(signal(i / kRate));
  return meter.powers();
}

/// |H|^2 of a second-order Butterworth high-pass, and of the first-order one that stands for the use.
double above(double hz, double border) { return 1 / (1 + std::pow(border / hz, 4)); }
double changes(double hz, double use) {
  const double x = angle(hz, use) / std::sqrt(3.0);
  return x * x / (1 + x * x);
}

TEST(SpectrumMeter, PutsASwingIntoTheBandOfItsRate) {
  constexpr double kAmplitude = 0.3;
  for (const double hz : {10.0, 30.0, 50.0, 100.0}) {
    const BandPowers p = measured([&](double t) { return Vec3(0, kAmplitude * std::sin(angle(hz, t)), 0); });
    const double square = 0.5 * kAmplitude * kAmplitude;
    EXPECT_NEAR(p.total, square, 1e-3 * square);
    const auto band = static_cast<std::size_t>(std::ranges::find(kCertifiedHz, hz) - kCertifiedHz.begin());
    const double low = band == 1 ? 5 : std::sqrt(kCertifiedHz[band - 1] * hz),
                 high = std::sqrt(hz * kCertifiedHz[band + 1]);
    const double wanted = square * changes(hz, kUse) * (above(hz, low) - above(hz, high));
    EXPECT_NEAR(p.changing[band], wanted, 0.03 * square) << hz << " Hz";  // the bilinear transform bends rates a little
    EXPECT_EQ(std::ranges::max_element(p.changing) - p.changing.begin(), static_cast<std::ptrdiff_t>(band));
  }
}

TEST(SpectrumMeter, LosesNoPowerAndCountsNoneTwice) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  SpectrumMeter meter(kRate, kUse, kForever);
  const double pass = 1 / (1 + std::sqrt(3.0) / kUse / kRate);
  Vec3 y = Vec3::Zero(), before = y;
  double sum = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 x(noise(random), noise(random) + 2, noise(random));
    meter.add(x);
    y = pass * (y + x - before);
    before = x;
    sum += y.squaredNorm() / 5000;
  }
  const BandPowers p = meter.powers();
  EXPECT_NEAR(std::accumulate(p.changing.begin(), p.changing.end(), 0.0), sum, 1e-9 * sum);
}

/// The model is made anew every kUse: what it has to follow is the force since then.
TEST(SpectrumMeter, CountsWhatChangesWithinTheUse) {
  for (const double hz : {0.5, 1.0, 2.0, 4.0, 10.0}) {
    const auto force = [&](double t) { return std::sin(angle(hz, t)); };
    double truth = 0;
    int count = 0;
    for (double start = 0; start < 1 / hz; start += 1e-3 / hz)
      for (double t = 0; t < kUse; t += 1e-3, ++count) truth += std::pow(force(start + t) - force(start), 2);
    truth /= count;
    const BandPowers p = measured([&](double t) { return Vec3(force(t), 0, 0); });
    const double all = std::accumulate(p.changing.begin(), p.changing.end(), 0.0);
    if (hz <= 2) {
      EXPECT_NEAR(all, truth, 0.12 * truth) << hz << " Hz";
    } else {  // a first-order filter lets no more through than there is; the difference of two moments is up to twice
              // that
      EXPECT_GT(all, 0.45 * truth) << hz << " Hz";
      EXPECT_LT(all, truth) << hz << " Hz";
    }
  }
}

TEST(SpectrumMeter, DoesNotCountWhatLasts) {
  const BandPowers p = measured([](double) { return Vec3(0, 0, 2); }, kUse, 0.5);
  EXPECT_NEAR(p.total, 4, 1e-9);
  EXPECT_LT(std::ranges::max(p.changing), 1e-9);
}

TEST(SpectrumMeter, ForgetsWhatIsOver) {
  const auto at_first = [](double t) { return Vec3(t < 1 ? std::sin(angle(100, t)) : 0, 0, 1); };
  const double now = measured(at_first, kUse, 0.5, 1000).changing[4];
  EXPECT_NEAR(measured(at_first, kUse, 0.5, 1500).changing[4],
              std::exp(-1.0) * now / (1 - std::exp(-3.0)) * (1 - std::exp(-2.0)), 0.1 * now);
}

TEST(ExpectedForceError, IsTheWeightedOne) {
  Excitation shares{};
  shares[0] = 0.04;
  shares[3] = 0.01;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DOUBLE_EQ(expected_force_error(shares, std::vector<double>{1, 9, 9, 0.5, 9, 9, 9}), std::sqrt(0.0425));
  EXPECT_DOUBLE_EQ(expected_force_error(shares, std::vector<double>{nan, 9, 9, 0.5, 9, 9, 9}), 0.05);
  EXPECT_TRUE(std::isinf(expected_force_error(shares, std::vector<double>{kForever, 0})));
}

/// A spring with a mass behind it that is held by another spring, and what is left of it without the mass: both driven
/// by a press that trembles. The error of the force, by the forces themselves.
TEST(ExpectedForceError, IsThatOfForcesOfTwoBodies) {
  using Complex = std::complex<double>;
  constexpr double kNear = 300, kFar = 100, kMass = 0.01, kDamper = 2;  // N/m, N/m, kg, N s/m
  const auto impedance = [&](double hz, double mass) {
    const double w = angle(hz, 1);
    const Complex far = kFar + Complex(0, w * kDamper) - w * w * mass;
    return kNear * far / (kNear + far);
  };
  constexpr double kUseLong = 1e3;  // all of it counts, at any rate
  for (const double hz : {10.0, 30.0, 50.0, 100.0}) {
    const double depth = 2e-3, tremor = 3e-4;
    const auto force = [&](double mass) {
      return [=](double t) {
        const Complex swing = tremor * impedance(hz, mass) * std::polar(1.0, angle(hz, t));
        return Vec3(0, 0, depth * impedance(0, mass).real() + swing.real());
      };
    };
    std::vector<double> errors;
    for (const double f : kCertifiedHz) errors.push_back(std::abs(impedance(f, 0) / impedance(f, kMass) - 1.0));
    double wrong = 0, all = 0;
    for (int i = 0; i < 20000; ++i) {
      wrong += (force(0)(i / kRate) - force(kMass)(i / kRate)).squaredNorm();
      all += force(kMass)(i / kRate).squaredNorm();
    }
    // In bands the neighbours' errors have a part in it.
    const double truth = std::sqrt(wrong / all);
    const BandPowers p = measured(force(kMass), kUseLong);
    EXPECT_NEAR(expected_force_error(excitation_of(p), errors), truth, 0.35 * truth) << hz << " Hz";

    // From the motion, not knowing the force.
    const BandPowers motion =
        measured([&](double t) { return Vec3(0, 0, depth + tremor * std::sin(angle(hz, t))); }, kUseLong);
    std::array<double, kBands> z;
    for (std::size_t i = 0; i < kBands; ++i) z[i] = std::abs(impedance(kCertifiedHz[i], kMass));
    // What leaks into a neighbour's band is taken with the neighbour's impedance: the error is rather seen too large.
    const double from_motion = expected_force_error(excitation_of(motion, z), errors);
    EXPECT_GT(from_motion, 0.65 * truth) << hz << " Hz";
    EXPECT_LT(from_motion, 3 * truth) << hz << " Hz";
  }
}

}  // namespace
}  // namespace kt
