#pragma once
// The kinds of findings, one function each: they append what a run shows.
#include "core/base/numbers.hpp"
#include "haptics/findings/run_findings.hpp"
#include "haptics/watch/tick_words.hpp"

namespace kt {

/// What the ticks' flags, their solver and the check of the whole body show.
void find_in_ticks(const Scene& scene, const SessionResult& result, const RealTime& pace, std::vector<Finding>& out);
/// Local models that were old while a tool touched.
void find_old_models(const Scene& scene, const SessionResult& result, const RealTime& pace, std::vector<Finding>& out);
/// What the hands were given of the forces, and why it was less.
void find_withheld_forces(const Scene& scene, const SessionResult& result, std::vector<Finding>& out);
/// The body: its steps, its tangent, elements and surface.
void find_in_body(const Session& session, const SessionResult& result, std::vector<Finding>& out);
/// The tools' way, and the energy of a hand's loop.
void find_in_motion(const Scene& scene, const SessionResult& result, std::vector<Finding>& out);
/// Jumps, buzz, lost contacts, the end of the linear range.
void find_in_forces(const Scene& scene, const SessionResult& result, const MeasuredRun& measured,
                    std::vector<Finding>& out);
/// Of one tool's metrics alone.
std::vector<Finding> find_in_force(const ForceMetrics& force, const Scene& scene, const RealTime& pace);

/// Newer local models under a moving tool: faster refreshes, where there is time for them, or a slower tool.
std::vector<Cure> sooner(const Scene& scene, const RealTime& pace);

inline bool touches(const LocalFrame& frame) { return frame.mode != ContactMode::free; }

}  // namespace kt
