#pragma once
// What is said of ticks, contacts and the body's refreshes: in the same words of a scene's run (findings/) and of a
// loop of one's own (Touch::findings()). Who asks adds the cures that he knows.
#include <optional>

#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"
#include "haptics/refresh/inverted_tetrahedra.hpp"
#include "haptics/tick/local_frame.hpp"
#include "haptics/watch/lost_contact.hpp"

namespace kt {

/// "" or "second tool: ".
inline const char* which(std::size_t tool) { return tool == 0 ? "" : "second tool: "; }

/// Its key in the scene.
inline const char* tool_key(std::size_t tool) { return tool == 0 ? "tool" : "second_tool"; }

/// Ticks of a tool that have something in common.
struct TickCount {
  long count = 0, of = 0;
  double first = 0;  ///< end of the first of them [s]
};

/// LocalFrame::residual from which on a tick's contact forces were not found: of the largest impulse. People feel no
/// difference below it.
constexpr double kNoticeableResidual = 0.01;

/// Of more contacts than a tick holds or has time for.
std::vector<Cure> smaller_contact();

Finding flag_finding(LocalFlag flag, const TickCount& ticks, std::size_t tool, std::vector<Cure> cures);
/// Of all tools; those with a residual above kNoticeableResidual.
Finding unsolved_finding(const TickCount& ticks);
/// @param deepest  [m]      @param ticks  that were deeper than LostContact::kNoticeableDepth
Finding depth_finding(double deepest, const TickCount& ticks, std::size_t tool);
/// Nothing where contact was where it should be.
/// @param ticks   all of the run      @param h  of one [s]
/// @param sooner  what brings newer local models under the tool
std::vector<Finding> lost_contact_findings(const LostContact& lost, long ticks, double h, std::size_t tool,
                                           const std::vector<Cure>& sooner);
/// Nothing where all were checked.
std::optional<Finding> unchecked_finding(const LostContact& lost, long ticks, std::size_t tool);
/// Nothing where none turned.
std::optional<Finding> inverted_finding(const InvertedTetrahedra& inverted, std::size_t of, std::vector<Cure> cures);
Finding indefinite_finding(int refreshes, std::size_t of, std::vector<Cure> cures);
/// Of a body with self-contact: pairs of triangles, the most after a global step.
Finding crossed_finding(int crossings);
Finding pressed_finding(int pairs, double stiffness);

}  // namespace kt
