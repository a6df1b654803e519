// What ticks tell by their flags, their solver, and the check of the whole body after each of them.
#include <algorithm>
#include <iterator>

#include "core/base/error.hpp"
#include "haptics/findings/kinds.hpp"

namespace kt {
namespace {

struct FlagKind {
  LocalFlag flag;
  std::vector<Cure> cures;
};

std::vector<FlagKind> flag_kinds(const Scene& scene, const RealTime& pace) {
  std::vector<Cure> finite{set_to("local.integrator", "implicit_euler")};
  if (scene.local.integrator == "implicit_euler")
    finite = {advise("press less deep"), advise("move the tool more slowly")};
  return {
      {kEventsExhausted, {advise("move the tool more slowly")}},
      {kContactsExhausted, smaller_contact()},
      {kWorkExhausted, smaller_contact()},
      {kLeftPatch, sooner(scene, pace)},
      {kOnApron, sooner(scene, pace)},
      {kUnrefined,
       scene.local.refine == "set-up" ? std::vector{set_to("local.refine", "follow")} : sooner(scene, pace)},
      {kLostAnchor, sooner(scene, pace)},
      {kPushedOut, sooner(scene, pace)},
      {kRigidContact, {advise("clamp less")}},
      {kNotFinite, finite},
      {kBodyFailed, {}},
      {kBadPose, {}},
      {kLateTick, {}},
  };
}

/// How much larger a force is than with refined cells: by what these add to the yield, at most, where one tool touches
/// them.
void weigh_unrefined(const SessionResult& result, Finding& found) {
  double share = -1;
  for (const double its : result.refresh.refined_share) share = std::max(share, its);  // none of those not known
  if (share < 0) return;
  const double larger = 1 / (1 - std::min(0.99, share)) - 1;
  found.what += told(" (by up to ", in_percent(larger), ", as far as contacts on them tell)");
  if (larger < kNoticeableForce && result.tools.size() == 1) found.weight = Finding::Weight::note;
}

void find_flags(const Scene& scene, const SessionResult& result, const RealTime& pace, std::vector<Finding>& out) {
  for (const FlagKind& kind : flag_kinds(scene, pace))
    for (std::size_t k = 0; k < result.tools.size(); ++k) {
      const auto& frames = result.tools[k].frames;
      const auto ticks = std::ranges::count_if(frames, [&](const LocalFrame& f) { return (f.flags & kind.flag) != 0; });
      if (ticks == 0) continue;
      const auto first = std::ranges::find_if(frames, [&](const LocalFrame& f) { return (f.flags & kind.flag) != 0; });
      Finding found = flag_finding(kind.flag, {ticks, static_cast<long>(frames.size()), first->t}, k, kind.cures);
      const bool is_unsolved = kind.flag == kContactsExhausted && std::ranges::any_of(frames, [](const LocalFrame& f) {
                                 return (f.flags & kContactsExhausted) != 0 && f.residual > kNoticeableResidual;
                               });
      if (kind.flag == kUnrefined) weigh_unrefined(result, found);
      if (is_unsolved) found.weight = Finding::Weight::failure;
      out.push_back(std::move(found));
    }
}

void find_unsolved(const SessionResult& result, std::vector<Finding>& out) {
  const auto& frames = result.tools[0].frames;
  const auto ticks =
      std::ranges::count_if(frames, [](const LocalFrame& f) { return f.residual > kNoticeableResidual; });
  if (ticks > 0) out.push_back(unsolved_finding({ticks, static_cast<long>(frames.size())}));
}

void find_depth(const ToolRun& tool, std::size_t k, std::vector<Finding>& out) {
  const auto& depth = tool.penetration;
  const auto ticks = std::ranges::count_if(depth, [](double d) { return d > LostContact::kNoticeableDepth; });
  if (ticks > 0) out.push_back(depth_finding(std::ranges::max(depth), {ticks, static_cast<long>(depth.size())}, k));
}

}  // namespace

void find_in_ticks(const Scene& scene, const SessionResult& result, const RealTime& pace, std::vector<Finding>& out) {
  find_flags(scene, result, pace, out);
  find_unsolved(result, out);
  for (std::size_t k = 0; k < result.tools.size(); ++k) {
    const ToolRun& tool = result.tools[k];
    const auto ticks = static_cast<long>(tool.frames.size());
    if (keeps_outside(scene)) {
      find_depth(tool, k, out);
      std::ranges::move(lost_contact_findings(tool.lost, ticks, 1 / scene.local.rate_hz, k, sooner(scene, pace)),
                        std::back_inserter(out));
    }
    if (auto found = unchecked_finding(tool.lost, ticks, k)) out.push_back(*std::move(found));
  }
}

}  // namespace kt
