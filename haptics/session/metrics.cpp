#include "haptics/session/metrics.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/ticks.hpp"

namespace kt {
namespace {

constexpr double kBuzzCutoff = 100;      // [Hz]
constexpr double kAfterRefresh = 0.005;  // [s] the bump of a refresh has its own figure and is no buzz
constexpr double kJump = 0.001;          // [s] over which a sudden change is one: a tick of the usual rate
constexpr double kSeldom = 0.015;        // [s] unless they come more often: then their bumps are what buzzes

/// One pass of the second-order Butterworth high-pass (bilinear transform), started at rest on the first value.
void high_pass_once(std::vector<double>& v, double cutoff_hz, double rate_hz) {
  const double k = std::tan(3.14159265358979323846 * cutoff_hz / rate_hz), q = std::sqrt(2.0);
  const double a0 = 1 + q * k + k * k, a1 = 2 * (k * k - 1) / a0, a2 = (1 - q * k + k * k) / a0, b0 = 1 / a0;
  double x1 = v.empty() ? 0 : v[0], x2 = x1, y1 = 0, y2 = 0;
  for (double& x : v) {
    const double y = b0 * (x - 2 * x1 + x2) - a1 * y1 - a2 * y2;
    x2 = x1;
    x1 = x;
    y2 = y1;
    y1 = y;
    x = y;
  }
}

/// Sum of squares above the cutoff over each unbroken stretch of contact.
double buzz_energy(std::span<const LocalFrame> stretch, double h) {
  double sum = 0;
  std::vector<double> component(stretch.size());
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < stretch.size(); ++i) component[i] = stretch[i].force[c];
    for (double y : high_pass(component, kBuzzCutoff, 1 / h)) sum += y * y;
  }
  return sum;
}

bool in_contact(const LocalFrame& f) { return f.mode != ContactMode::free; }

/// Of the force that was written, faded and limited, about the contact's normal. Several contacts have several normals
/// and no cone of their own.
double largest_felt_ratio(std::span<const LocalFrame> frames) {
  constexpr double kWeak = 0.05;    // of the mean force: below, nobody feels which way it points
  constexpr double kLargest = 100;  // from there on it pulls, or nearly
  const auto is_judged = [](const LocalFrame& f) { return in_contact(f) && f.contacts == 1; };
  double sum = 0, out = 0;
  long count = 0;
  for (const LocalFrame& f : frames)
    if (is_judged(f)) {
      sum += f.force.norm();
      ++count;
    }
  for (const LocalFrame& f : frames) {
    const double size = f.force.norm(), normal = f.force.dot(f.normal);
    if (!is_judged(f) || !(size > kWeak * sum / static_cast<double>(count))) continue;
    const double tangential = (f.force - normal * f.normal).norm();
    out = std::max(out, tangential < kLargest * normal ? tangential / normal : kLargest);
  }
  return out;
}

/// How much the force changes from before tick i to it, over a millisecond: what a contact's impulse is in one tick, in
/// a shorter one is a higher and shorter peak, of which a hand feels as much. At rates of 1 kHz and below: of that
/// tick.
double jump_at(std::span<const LocalFrame> frames, std::size_t i, std::size_t window) {
  const auto mean = [&](std::size_t begin, std::size_t end) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = begin; k < end; ++k) sum += frames[k].force;
    return Vec3(sum / static_cast<double>(end - begin));
  };
  std::size_t begin = i - 1, end = i + 1;
  while (begin > 0 && i - begin < window && in_contact(frames[begin - 1])) --begin;
  while (end < frames.size() && end - i < window && in_contact(frames[end])) ++end;
  return (mean(i, end) - mean(begin, i)).norm();
}

}  // namespace

std::vector<double> high_pass(std::span<const double> values, double cutoff_hz, double rate_hz) {
  std::vector<double> v(values.begin(), values.end());
  if (2 * cutoff_hz >= rate_hz) return std::vector<double>(v.size(), 0);
  high_pass_once(v, cutoff_hz, rate_hz);
  std::reverse(v.begin(), v.end());
  high_pass_once(v, cutoff_hz, rate_hz);
  std::reverse(v.begin(), v.end());
  return v;
}

ForceMetrics measure_forces(std::span<const LocalFrame> frames, double steady_from, double h) {
  ForceMetrics out;
  out.felt_t_over_n = largest_felt_ratio(frames);
  double work = 0, steady_force = 0, buzz = 0;
  int touching = 0, steady = 0;
  const auto window = static_cast<std::size_t>(ticks_in(kJump, 1 / h));
  std::size_t stretch_begin = 0;
  const auto close_stretch = [&](std::size_t end) {
    if (end > stretch_begin + 8) buzz += buzz_energy(frames.subspan(stretch_begin, end - stretch_begin), h);
  };
  bool stretch_open = false;
  double settled_at = 0, refreshed_at = -kSeldom;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const LocalFrame& f = frames[i];
    out.ticks_free += f.mode == ContactMode::free;
    out.ticks_stick += f.mode == ContactMode::stick;
    out.ticks_slide += f.mode == ContactMode::slide;
    out.ticks_frictional_slide += f.mode == ContactMode::frictional_slide;
    out.max_t_over_n = std::max(out.max_t_over_n, f.cone_ratio);
    if (i > 0) work -= f.force.dot(f.pose.x - frames[i - 1].pose.x);  // the tool works against the force on it
    out.energy_min = std::min(out.energy_min, work);
    if (i > 0 && f.model_frame != frames[i - 1].model_frame) {
      if (f.t - refreshed_at > kSeldom) settled_at = f.t + kAfterRefresh;
      refreshed_at = f.t;
    }
    const bool is_steady = in_contact(f) && f.t > steady_from && f.t > settled_at;
    if (is_steady && !stretch_open) stretch_begin = i;
    if (!is_steady && stretch_open) close_stretch(i);
    stretch_open = is_steady;
    if (in_contact(f)) {
      ++touching;
      out.mean_n += f.f_n;
      out.mean_t += f.f_t;
      out.max_n = std::max(out.max_n, f.f_n);
      out.max_t = std::max(out.max_t, f.f_t);
    }
    if (is_steady) {
      ++steady;
      steady_force += f.force.norm();
    }
    if (i == 0 || !in_contact(frames[i - 1])) continue;
    const LocalFrame& before = frames[i - 1];
    if (!in_contact(f)) {
      // Held a moment ago and the tool did not move away from the surface: contact should not have ended.
      const bool backs_off = before.normal.dot(f.pose.x - before.pose.x) >= 0;
      out.lost_contacts += !backs_off;
      continue;
    }
    out.crossings += f.triangle != before.triangle;
    if (f.t <= steady_from) continue;
    if (f.model_frame != before.model_frame)
      out.refresh_jump = std::max(out.refresh_jump, jump_at(frames, i, window));
    else if (f.facet != before.facet)
      out.crossing_jump = std::max(out.crossing_jump, jump_at(frames, i, window));
  }
  if (stretch_open) close_stretch(frames.size());
  if (touching > 0) {
    out.mean_n /= touching;
    out.mean_t /= touching;
  }
  if (steady > 0 && steady_force > 0) {
    const double mean = steady_force / steady;
    out.buzz = std::sqrt(buzz / steady) / mean;
    out.crossing_jump /= mean;
    out.refresh_jump /= mean;
  }
  return out;
}

}  // namespace kt
