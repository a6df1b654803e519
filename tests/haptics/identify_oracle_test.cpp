// What is found out about a device from its release, against the simulated one whose damping and delay are known.
#include "haptics/safety/identify.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "haptics/device/haptic_device.hpp"

namespace kt {
namespace {

struct Truth {
  double damping = 1, delay = 0, mass = 0.1, held = 1e-3, encoder = 1e-5, dry = 0;
};

/// A device at rest 20 mm from where a spring of 100 N/m begins to draw it.
std::vector<ReleaseSample> release(const Truth& truth, double seconds = 1) {
  constexpr double kTick = 1e-3, kAway = 0.02;
  DeviceOptions o;
  o.path = {{0, {kAway, 0, 0}}};
  o.h = kTick;
  o.hand_mass = truth.mass;
  o.hand_stiffness = truth.held;  // tiny: nobody holds it
  o.hand_damping = truth.damping;
  o.hand_delay = truth.delay;
  o.encoder_step = truth.encoder;
  const auto device = make_device("hand", o);
  std::vector<ReleaseSample> out;
  double before = kAway;
  for (int i = 0; i * kTick < seconds; ++i) {
    const double x = device->pose(i * kTick).x.x();
    const double force = -kReleaseStiffness * x;
    const double friction = x > before ? -truth.dry : x < before ? truth.dry : 0;
    before = x;
    out.push_back({i * kTick, x, force});
    device->write({.force = {force + friction, 0, 0}}, kTick);
  }
  return out;
}

TEST(Identify, FindsDampingMassAndDelayOfAFreeDevice) {
  for (const double damping : {0.1, 0.3, 1.0, 3.0})
    for (const double delay : {0.0, 0.4e-3, 0.8e-3, 2e-3, 3e-3})
      for (const double mass : {0.06, 0.3}) {
        const DeviceFit fit = fit_release(release({damping, delay, mass}), 1e-5);
        ASSERT_TRUE(fit.is_good()) << fit.refusal << " b " << damping << " T_d " << delay;
        // Encoder steps of 10 um in a swing of 20 mm; five hundredths of the damping is a twentieth of the coupling.
        EXPECT_NEAR(fit.damping, damping, 0.05 * damping) << damping << ' ' << delay << ' ' << mass;
        EXPECT_NEAR(fit.mass, mass, 0.01 * mass);
        EXPECT_NEAR(fit.delay, delay, 0.1e-3) << damping << ' ' << mass;
      }
}

TEST(Identify, ItsErrorsAreThoseThatItMakes) {
  for (int i = 0; i < 40; ++i) {
    const Truth truth{0.1 + 0.07 * i, 1e-4 * (i % 30), 0.05 + 0.01 * i, 1e-3, 1e-5 * (1 + i % 7)};
    const DeviceFit fit = fit_release(release(truth), truth.encoder);
    ASSERT_TRUE(fit.is_good()) << fit.refusal;
    EXPECT_LT(fit.damping_error, 0.03 * truth.damping) << "worth knowing";
    EXPECT_LE(std::abs(fit.damping - truth.damping), fit.damping_error) << i;
    EXPECT_LE(std::abs(fit.mass - truth.mass), fit.mass_error) << i;
    EXPECT_LE(std::abs(fit.delay - truth.delay), fit.delay_error) << i;
  }
}

TEST(Identify, RefusesWhatIsNoFreeMass) {
  EXPECT_NE(fit_release(release({.held = 300}), 1e-5).refusal.find("was it held"), std::string::npos);
  EXPECT_NE(fit_release(release({.dry = 0.5}), 1e-5).refusal, "") << "dry friction of a quarter of the pull";
  EXPECT_NE(fit_release(release({}, 0.05), 1e-5).refusal.find("too few"), std::string::npos);
  std::vector<ReleaseSample> still = release({});
  for (ReleaseSample& s : still) s.x = 0.02;
  EXPECT_NE(fit_release(still, 1e-5).refusal.find("moved"), std::string::npos);
  std::vector<ReleaseSample> bad = release({});
  bad[50].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(fit_release(bad, 1e-5).refusal.find("sample 50"), std::string::npos);
  bad = release({});
  bad[60].t = bad[59].t;
  EXPECT_NE(fit_release(bad, 1e-5).refusal.find("sample 60"), std::string::npos);
  // A device that its forces do not reach trembles, and drifts.
  for (const double drift : {0.0, 5e-3, -5e-3, 0.03}) {
    std::vector<ReleaseSample> deaf;
    for (int k = 0; k < 1500; ++k) {
      const double t = 1e-3 * k, x = drift * t + 2e-5 * std::sin(60 * t);
      deaf.push_back({t, x, -kReleaseStiffness * (x - 0.015)});
    }
    EXPECT_NE(fit_release(deaf).refusal, "") << drift;
  }
  EXPECT_NE(fit_release({}, 1e-5).refusal, "");
}

}  // namespace
}  // namespace kt
