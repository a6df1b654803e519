#include "haptics/remote/as_sent.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

Vec3 to_float(const Vec3& v) noexcept { return v.cast<float>().cast<double>(); }

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
  for (ToolReport& tool : out.tools) tool.pose.r.coeffs() = tool.pose.r.coeffs().cast<float>().cast<double>();
  for (int i = 0; i < out.count; ++i) {
    TickContact& c = out.samples[static_cast<std::size_t>(i)];
    c.t = report.tick * h;
    c.bary = to_float(c.bary);
    c.impulse = impulse_of(count_impulse(c.impulse));
    c.normal = to_float(c.normal);
    c.point = to_float(c.point);
  }
  return out;
}

void round_as_sent(LocalMotion& motion) noexcept {
  motion.x = motion.x.cast<float>().cast<double>().eval();
  motion.v = motion.v.cast<float>().cast<double>().eval();
  motion.du = motion.du.cast<float>().cast<double>().eval();
}

}  // namespace kt
