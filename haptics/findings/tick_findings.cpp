// What ticks tell by their flags, their solver, and the check of the whole body after each of them.
#include <algorithm>

#include "core/base/error.hpp"
#include "haptics/findings/kinds.hpp"

namespace kt {
namespace {

constexpr double kNoticeableDepth = 1e-4;     // [m] contact ends at micrometres: more is a fault, or a tool that a new
                                              // patch has found inside
constexpr double kNoticeableResidual = 0.01;  // of the largest impulse: people feel no difference below it

struct FlagKind {
  unsigned flag;
  const char* text;
  std::vector<Cure> cures;
};

std::vector<FlagKind> flag_kinds(const Scene& scene, const RealTime& pace) {
  std::vector<Cure> finite{set_to("local.integrator", "implicit_euler")};
  if (scene.local.integrator == "implicit_euler")
    finite = {advise("press less deep"), advise("move the tool more slowly")};
  return {
      {kEventsExhausted, "more impacts in one tick than are resolved", {advise("move the tool more slowly")}},
      {kContactsExhausted, "as many places touched at once as are resolved, 40: those that say most were kept", {}},
      {kLeftPatch, "the contact reached the edge of the local patch", sooner(scene, pace)},
      {kLostAnchor, "a refresh brought a patch that does not hold the contact", sooner(scene, pace)},
      {kPushedOut, "the tool was inside the body, which was pushed off it over a time, the force growing slowly", {}},
      {kRigidContact, "contact with a clamped part, which cannot give way", {}},
      {kNotFinite, "the local model left the finite numbers and was reset", finite},
      {kBodyFailed, "the body's simulation had ended with an error, and its last local model went on", {}},
      {kBadPose, "the tool's pose was not usable, and it stayed where it was", {}},
      {kLateTick, "more time had passed than is caught up with in one call", {}},
  };
}

void find_flags(const Scene& scene, const SessionResult& result, const RealTime& pace, std::vector<Finding>& out) {
  for (const FlagKind& kind : flag_kinds(scene, pace))
    for (std::size_t k = 0; k < result.tools.size(); ++k) {
      const auto& frames = result.tools[k].frames;
      const auto ticks = std::ranges::count_if(frames, [&](const LocalFrame& f) { return (f.flags & kind.flag) != 0; });
      if (ticks == 0) continue;
      const auto first = std::ranges::find_if(frames, [&](const LocalFrame& f) { return (f.flags & kind.flag) != 0; });
      Finding found{text(which(k), kind.text, ": ", ticks, " of ", frames.size(),
                         " ticks, first at t = ", short_number(first->t), " s"),
                    kind.cures};
      const bool is_unsolved = kind.flag == kContactsExhausted && std::ranges::any_of(frames, [](const LocalFrame& f) {
                                 return (f.flags & kContactsExhausted) != 0 && f.residual > kNoticeableResidual;
                               });
      if (is_unsolved || kind.flag == kBodyFailed) found.weight = Finding::Weight::failure;
      out.push_back(std::move(found));
    }
}

void find_unsolved(const SessionResult& result, std::vector<Finding>& out) {
  const auto& frames = result.tools[0].frames;
  const auto ticks =
      std::ranges::count_if(frames, [](const LocalFrame& f) { return f.residual > kNoticeableResidual; });
  if (ticks > 0)
    out.push_back({text("the contact forces were not found to within 1 %: ", ticks, " of ", frames.size(),
                        " ticks (contacts on the same few nodes, or a tool that drives into what is clamped)")});
}

void find_depth(const ToolRun& tool, std::size_t k, std::vector<Finding>& out) {
  const auto& depth = tool.penetration;
  const auto ticks = std::ranges::count_if(depth, [](double d) { return d > kNoticeableDepth; });
  if (ticks == 0) return;
  out.push_back(
      {text(which(k), "the tool was up to ", short_number(1e3 * std::ranges::max(depth)), " mm inside the body, in ",
            ticks, " of ", depth.size(), " ticks: forces there are not to be trusted"),
       {advise("move the tool more slowly"), advise("press less deep")}});
}

void find_lost(const Scene& scene, const RealTime& pace, const ToolRun& tool, std::size_t k,
               std::vector<Finding>& out) {
  const LostContact& lost = tool.lost;
  const auto& frames = tool.frames;
  if (lost.free_ticks_inside > 0)
    out.push_back({text(which(k), "contact was lost: the tool was inside the body without contact in ",
                        lost.free_ticks_inside, " of ", frames.size(), " ticks"),
                   sooner(scene, pace), Finding::Weight::failure});
  if (lost.pass_throughs == 0) return;
  const auto& [tick, distance] = lost.went_through.front();
  out.push_back({text(which(k), "the tool went into the body or through it unstopped in ", lost.pass_throughs,
                      lost.pass_throughs == 1 ? " tick" : " ticks", ", first in tick ", tick, " (t = ",
                      frames[static_cast<std::size_t>(tick)].t, " s), ", short_number(distance), " m in that one"),
                 {advise("give the path more time there")},
                 Finding::Weight::failure});
}

}  // namespace

void find_in_ticks(const Scene& scene, const SessionResult& result, const RealTime& pace, std::vector<Finding>& out) {
  find_flags(scene, result, pace, out);
  find_unsolved(result, out);
  for (std::size_t k = 0; k < result.tools.size(); ++k) {
    const ToolRun& tool = result.tools[k];
    if (keeps_outside(scene)) {
      find_depth(tool, k, out);
      find_lost(scene, pace, tool, k, out);
    }
    if (tool.lost.unchecked_ticks > 0)
      out.push_back({text(which(k), "contacts were not checked in ", tool.lost.unchecked_ticks, " of ",
                          tool.frames.size(), " ticks: the check fell too far behind")});
  }
}

}  // namespace kt
