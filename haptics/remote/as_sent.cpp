#include "haptics/remote/as_sent.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace kt {
namespace {

/// By way of memory: of two doubles side by side g++ 12 makes (double)(float) nothing at all, from -O2 on.
void round_to_float(std::span<double> values) noexcept {
  for (double& v : values) {
    const volatile float narrow = static_cast<float>(v);
    v = static_cast<double>(narrow);
  }
}
void round_to_float(Vec3& v) noexcept { round_to_float(std::span(v.data(), 3)); }
void round_to_float(VectorX& v) noexcept { round_to_float(std::span(v.data(), static_cast<std::size_t>(v.size()))); }

}  // namespace

ImpulseCount count_impulse(const Vec3& impulse) noexcept {
  ImpulseCount out{};
  for (int c = 0; c < 3; ++c)
    out[c] = std::llround(std::clamp(impulse[c], -kMostImpulse, kMostImpulse - kImpulseQuantum) / kImpulseQuantum);
  return out;
}

Vec3 impulse_of(const ImpulseCount& count) noexcept {
  return kImpulseQuantum *
         Vec3(static_cast<double>(count[0]), static_cast<double>(count[1]), static_cast<double>(count[2]));
}

LocalReport as_sent(const LocalReport& report, double h) noexcept {
  LocalReport out = report;
  for (ToolReport& tool : out.tools) round_to_float(std::span(tool.pose.r.coeffs().data(), 4));
  for (int i = 0; i < out.count; ++i) {
    TickContact& c = out.samples[static_cast<std::size_t>(i)];
    c.t = report.tick * h;
    round_to_float(c.bary);
    c.impulse = impulse_of(count_impulse(c.impulse));
    round_to_float(c.normal);
    round_to_float(c.point);
  }
  return out;
}

void round_as_sent(LocalMotion& motion) noexcept {
  for (VectorX* values : {&motion.x, &motion.v, &motion.du}) round_to_float(*values);
}

}  // namespace kt
