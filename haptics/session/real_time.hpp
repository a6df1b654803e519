#pragma once
// Whether a run keeps up with the wall clock, which part is slow, and the setting that cures it.
#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"
#include "haptics/session/session.hpp"

namespace kt {

/// just_about: all came in time, with less than a fifth of the time left.
enum class Keeps { yes, just_about, no };

struct RealTime {
  Keeps keeps = Keeps::yes;
  std::string slow_part;  ///< haptic tick, global step, linearize, reduce, certify, prepare: what takes longest; link:
                          ///< the body is fast enough, and its local models do not get here
  double part_ms = 0;     ///< of it, median; of the tick its 99th percentile
  double budget_ms = 0;   ///< from one refresh to the next, 1 / global.rate_hz
  double refresh_ms = 0;  ///< global step and local model, median
  double refresh_hz = 0;  ///< refreshes a simulated second, early ones included
  double wanted_hz = 0;   ///< of them, global.rate_hz
  bool lags = false;      ///< ticks are against the clock, and less than nineteen of twenty refreshes came
  bool is_crowded = false;    ///< it lags, though a refresh and a tick would fit: others hold the processor
  double refresh_share = 0;   ///< of a refresh, median, of the time from one to the next
  double tick_share = 0;      ///< CPU time of the haptic tick, 99th percentile, of its period
  std::vector<Cure> cures{};  ///< none: none is needed, or known

  std::string cure() const { return alternatives(cures); }  ///< "set local.reducer to condensed, or ..."
  /// Figures of the slow part: "a refresh takes 68 ms of 33, ...".
  std::string why() const;
  /// One line, with that and the cure: "no: reduce takes 55 of the 68 ms of a refresh, 33 ms are there".
  std::string told() const;
};

const char* name_of(Keeps keeps);

/// What a cure may ask for without costing the forces what they have.
struct PaceLimits {
  bool coarser = true;                                  ///< cells half as long again are fine enough under the tool
  bool linear_elements = true;                          ///< tet4 are
  std::array<std::size_t, kMaxTools> tool_triangles{};  ///< of mesh tools
};

/// Times of a run, or of the last seconds of one that goes on.
struct MeasuredPace {
  double seconds = 0;             ///< that were simulated meanwhile
  double tick_us = 0;             ///< CPU time of a tick, 99th percentile
  std::size_t refreshes = 0;      ///< that arrived
  double wanted_hz = 0;           ///< refreshes that were asked for
  const RefreshRun& refresh;      ///< at least one
  const std::string& reducer;     ///< in use
  bool is_against_clock = false;  ///< ticks were due by the wall clock
  std::span<const ReducerCandidate> candidates{};
};

/// From measured times, of this machine: wall clock, or the processor's time where that is known and less.
RealTime judge_real_time(const Scene& scene, const MeasuredPace& pace, const PaceLimits& limits = {});
RealTime judge_real_time(const Scene& scene, const SessionResult& result, const PaceLimits& limits = {});

}  // namespace kt
