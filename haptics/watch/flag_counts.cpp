#include "haptics/watch/flag_counts.hpp"

namespace kt {
namespace {

/// What an own loop can do about it; flags that speak of the whole touch are told with its first tool.
struct FlagKind {
  LocalFlag flag;
  std::vector<Cure> cures;
  bool is_of_all = false;
};

std::vector<FlagKind> flag_kinds(bool is_remote, bool keeps_cells) {
  const std::vector<Cure> sooner = sooner_models();
  std::vector<Cure> quicker{advise("take a coarser mesh"), advise("leave the processor to this program")};
  if (is_remote) quicker = {advise("look at the network")};
  return {
      {kEventsExhausted, {advise("move the tool more slowly")}},
      {kContactsExhausted, smaller_contact()},
      {kWorkExhausted, smaller_contact()},
      {kOnApron, sooner},
      {kUnrefined, keeps_cells ? std::vector{set_to("local.refine", "follow")} : sooner},
      {kLeftPatch, sooner},
      {kLostAnchor, sooner},
      {kPushedOut, sooner},
      {kRigidContact, {advise("clamp less")}},
      {kNotFinite, {advise("lower object.model.young"), advise("raise local.rate_hz")}},
      {kStaleModel, quicker, true},
      {kBodyFailed, {}, true},
      {kNoModel, {advise("call place() and start() before")}, true},
      {kBadPose, {}},
      {kLateTick, {advise("call more often")}, true},
  };
}

}  // namespace

std::vector<Cure> sooner_models() { return {advise("move the tool more slowly"), advise("raise global.rate_hz")}; }

void FlagCounts::tell(std::size_t tool, bool is_remote, bool keeps_cells, std::vector<Finding>& out) const {
  for (const FlagKind& kind : flag_kinds(is_remote, keeps_cells))
    if (const TickCount found = ticks(kind.flag); found.count > 0 && (tool == 0 || !kind.is_of_all))
      out.push_back(flag_finding(kind.flag, found, tool, kind.cures));
  if (const TickCount found = unsolved(); found.count > 0 && tool == 0) out.push_back(unsolved_finding(found));
}

}  // namespace kt
