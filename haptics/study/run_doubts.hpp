#pragma once
// What speaks against the forces of a run, each with the setting that cures it: the answer to "can I trust this?"
#include <string>
#include <vector>

#include "haptics/session/session.hpp"
#include "haptics/study/metrics.hpp"

namespace kt {

struct Doubt {
  std::string what;  ///< with its value
  std::string cure;  ///< with its setting; empty: none is known
};

/// "what; cure", as warnings are written.
Doubt doubt_of(const std::string& warning);

/// What the measures of a run show, of one tool.
/// @param flat   the tool touches the mesh's own triangles
std::vector<Doubt> find_doubts(const ForceMetrics& force, const Scene& scene);

/// Everything: the warnings that are no notes, and the measures of all tools.
/// @param warnings  of run_warnings()
std::vector<Doubt> find_doubts(const Scene& scene, const SessionResult& result,
                               const std::vector<std::string>& warnings, const std::vector<ForceMetrics>& forces);

}  // namespace kt
