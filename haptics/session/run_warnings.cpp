#include "haptics/session/run_warnings.hpp"

#include <algorithm>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr double kNoticeableDepth = 1e-4;     // [m] contact ends at micrometres: more is a fault, or a tool that a new
                                              // patch has found inside
constexpr double kNoticeableResidual = 0.01;  // of the largest impulse: people feel no difference below it

}  // namespace

std::vector<std::string> run_warnings(const SessionResult& result, bool keeps_outside) {
  std::vector<std::string> warnings = result.warnings;
  struct Kind {
    unsigned flag;
    const char* text;
  };
  const auto who = [&](const ToolRun& tool) { return &tool == &result.tools[0] ? "" : "second tool: "; };
  constexpr Kind kKinds[] = {
      {kEventsExhausted, "more impacts in one tick than are resolved"},
      {kContactsExhausted, "as many places touched at once as are resolved, 40: those that say most were kept"},
      {kLeftPatch, "the contact reached the edge of the local patch (raise global.rate_hz or move slower)"},
      {kLostAnchor, "a refresh brought a patch that does not hold the contact"},
      {kPushedOut, "the tool was inside the body, which was pushed off it over a time, the force growing slowly"},
      {kRigidContact, "contact with a clamped part, which cannot give way"},
      {kNotFinite, "the local model left the finite numbers and was reset (use local.integrator implicit_euler)"}};
  for (const Kind& kind : kKinds) {
    for (const ToolRun& tool : result.tools) {
      const auto ticks =
          std::ranges::count_if(tool.frames, [&](const LocalFrame& f) { return (f.flags & kind.flag) != 0; });
      if (ticks > 0) warnings.push_back(text(who(tool), kind.text, ": ", ticks, " of ", tool.frames.size(), " ticks"));
    }
  }
  for (const ToolRun& tool : result.tools)
    if (tool.limited_forces > 0)
      warnings.push_back(text(who(tool), "the force was cut to the device's limit in ", tool.limited_forces, " ticks"));
  const auto unsolved = std::ranges::count_if(result.tools[0].frames,
                                              [](const LocalFrame& f) { return f.residual > kNoticeableResidual; });
  if (unsolved > 0)
    warnings.push_back(text("the contact forces were not found to within 1 %: ", unsolved, " of ",
                            result.tools[0].frames.size(),
                            " ticks (contacts on the same few nodes, or a tool that drives into what is clamped)"));
  if (const StepStatistics& steps = result.global_steps; steps.projected + steps.not_converged > 0)
    warnings.push_back(
        text("global steps: ", steps.projected, " of ", steps.iterations,
             " systems were not positive definite and were solved with the element stiffness projected, and ",
             steps.not_converged, " of ", result.refresh.global_ms.size(), " steps did not converge"));
  if (result.self_contact && result.self_contact->crossings > 0)
    warnings.push_back(text("the surface crossed itself, in up to ", result.self_contact->crossings,
                            " pairs of triangles after a global step: a fault of this program, please report it"));
  if (result.refresh.definite_tangents > 0)
    warnings.push_back(
        text("the exact tangent was indefinite at ", result.refresh.definite_tangents, " of ", result.refreshes.size(),
             " refreshes: clamped there, the local model is stiffer than the body; set object.model.type to fem "
             "with object.model.material neo_hookean, or press less deep"));
  const auto warn_of_depth = [&](const ToolRun& tool) {
    const std::span<const double> depth = tool.penetration;
    if (depth.empty() || !keeps_outside) return;
    const auto ticks = std::ranges::count_if(depth, [](double d) { return d > kNoticeableDepth; });
    if (ticks > 0)
      warnings.push_back(text(
          who(tool), "the tool was up to ", 1e3 * std::ranges::max(depth), " mm inside the body, in ", ticks, " of ",
          depth.size(), " ticks: forces there are not to be trusted; move the tool more slowly, or press less deep"));
  };
  std::ranges::for_each(result.tools, warn_of_depth);
  const auto warn_of_loss = [&](const ToolRun& tool) {
    const LostContact& lost = tool.lost;
    const std::span<const LocalFrame> frames = tool.frames;
    if (lost.free_ticks_inside > 0 && keeps_outside)
      warnings.push_back(text(who(tool), "contact was lost: the tool was inside the body without contact in ",
                              lost.free_ticks_inside, " of ", frames.size(), " ticks; move slower, use a coarser mesh ",
                              "or raise global.rate_hz"));
    if (lost.pass_throughs > 0 && keeps_outside) {
      const auto& [tick, distance] = lost.went_through.front();
      warnings.push_back(text(who(tool), "the tool went into the body or through it unstopped in ", lost.pass_throughs,
                              lost.pass_throughs == 1 ? " tick" : " ticks", ", first in tick ", tick,
                              " (t = ", frames[static_cast<std::size_t>(tick)].t, " s), ", distance,
                              " m in that one: give the path more time there"));
    }
    if (lost.unchecked_ticks > 0)
      warnings.push_back(text(who(tool), "contacts were not checked in ", lost.unchecked_ticks, " of ", frames.size(),
                              " ticks: the check fell too far behind"));
  };
  std::ranges::for_each(result.tools, warn_of_loss);
  for (const ToolRun& tool : result.tools) {
    if (!tool.device) continue;
    const SafetyCounts& s = tool.device->safety;
    if (s.shut > 1 || tool.device->gate != GateReason::put_down)  // once at the end
      warnings.push_back(text(who(tool), "the device's gate was shut: ", s.gated, " of ", s.ticks,
                              " ticks had no force or a part of it, it shut ", s.shut, " times, the last time because ",
                              name_of(tool.device->last_gate), "; kilotouch device test ", tool.device->name,
                              " says what stands in the way"));
  }
  if (result.device_lost)
    warnings.push_back(text("the device was lost in tick ", result.tools[0].frames.size(),
                            ", after 10 s without it: the force was zero; is it still plugged in and switched on?"));
  if (result.stopped) warnings.push_back(text("stopped early, after ", result.tools[0].frames.size(), " ticks"));
  return warnings;
}

bool contacts_were_too_many(const SessionResult& result) {
  const auto fails = [](const LocalFrame& f) {
    return (f.flags & kContactsExhausted) != 0 && f.residual > kNoticeableResidual;
  };
  return std::ranges::any_of(result.tools, [&](const ToolRun& t) { return std::ranges::any_of(t.frames, fails); });
}

bool contact_was_lost(const SessionResult& result, bool keeps_outside) {
  return keeps_outside && std::ranges::any_of(result.tools, [](const ToolRun& t) { return t.missed_impacts > 0; });
}

}  // namespace kt
