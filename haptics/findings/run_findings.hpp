#pragma once
// Everything that was found out about a run: by its scene as it was built, by what is known to fail, by its ticks,
// devices, refreshes and forces. The one place: the first screen, the exit code, summary.json, the page's recordings
// and Python's trace.warnings take them from here.
#include <optional>

#include "haptics/cells/contact_width.hpp"
#include "haptics/session/metrics.hpp"
#include "haptics/session/real_time.hpp"

namespace kt {

/// What findings are made from, measured once.
struct MeasuredRun {
  std::vector<ForceMetrics> forces;   ///< of each tool
  std::optional<ContactWidth> width;  ///< of the first tool's contact
  RealTime pace;
};

MeasuredRun measure_run(const Session& session, const SessionResult& result);

std::vector<Finding> all_findings(const Session& session, const SessionResult& result, const MeasuredRun& measured);
std::vector<Finding> all_findings(const Session& session, const SessionResult& result);

/// Nothing speaks against the forces.
bool is_trustworthy(const std::vector<Finding>& findings);
/// The forces are not those of the scene: what an exit code of 1 stands for.
bool has_failed(const std::vector<Finding>& findings);

/// Time after which the first tool's contact is steady [s].
double steady_from(const Scene& scene, const SessionResult& result);

/// The method keeps tools outside: the baselines and the paper's laws let them in.
bool keeps_outside(const Scene& scene);
/// A tool was inside the body without contact, or went through it, in a run that has to keep it outside.
bool contact_was_lost(const Scene& scene, const SessionResult& result);

}  // namespace kt
