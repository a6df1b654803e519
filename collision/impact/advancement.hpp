#pragma once
// Conservative advancement: from one time that is certified free of contact to the next. What tool_impact.cpp and
// hull_impact.cpp share; docs/collision.md.
#include "collision/impact/separating_plane.hpp"

namespace kt {

constexpr double kTimeResolution = 0x1p-42;  // of the step: 2e-13

/// First time in [from, until) not certified free of contact, or -1. `free_until(t)` gives a time until which there is
/// none, t itself when that is not known. When `max_planes` are spent the time reached is the answer: early, never
/// late.
template <class FreeUntil>
double first_contact_time(double from, double until, int max_planes, const FreeUntil& free_until) noexcept {
  double t = from;
  for (int i = 0; i < max_planes; ++i) {
    const double next = free_until(t);
    if (next >= until) return -1;
    if (next - t <= kTimeResolution) return next;
    t = next;
  }
  return t;
}

/// When what touches at `from` is first seen apart, to within kTimeResolution, or -1: steps that double, then halving.
template <class IsOpen>
double opening_time(double from, const IsOpen& is_open) noexcept {
  double touching = from, open = 1;
  for (double step = 0x1p-20; from + step < 1; step *= 2) {
    if (is_open(from + step)) {
      open = from + step;
      break;
    }
    touching = from + step;
  }
  if (open == 1 && !is_open(1)) return -1;
  while (open - touching > kTimeResolution) {
    const double middle = 0.5 * (touching + open);
    (is_open(middle) ? open : touching) = middle;
  }
  return open;
}

}  // namespace kt
