#include "haptics/touch/flag_counts.hpp"

#include "core/base/error.hpp"
#include "haptics/tick/local_frame.hpp"

namespace kt {
namespace {

/// What it says of the ticks, and what cures it.
constexpr std::pair<unsigned, const char*> kWords[] = {
    {kEventsExhausted, "had more impacts than are resolved; move the tool more slowly"},
    {kOnApron,
     "touched outside the local model, on the body around it: the force is a coarse one; move the tool more slowly, or "
     "raise global.rate_hz"},
    {kLeftPatch,
     "touched at the edge of the local model, or left it: the force is a coarse one; move the tool more slowly, or "
     "raise global.rate_hz"},
    {kLostAnchor, "lost the contact at a refresh"},
    {kRigidContact, "touched a part that cannot move: there the force is that of a stiff wall; clamp less"},
    {kNotFinite, "left the finite numbers, the force was 0; lower object.model.young or raise local.rate_hz"},
    {kContactsExhausted, "touched at more places than are resolved; take a smaller tool or a coarser surface"},
    {kPushedOut, "began inside the body, which was pushed off the tool"},
    {kStaleModel, "had an old local model, as the body has not followed; take a coarser mesh"},
    {kBodyFailed, "came after the body's simulation had ended with an error"},
    {kNoModel, "had no local model yet: nothing is touched; call place() and start() before"},
    {kBadPose, "had a pose that was not finite, or beyond 1e6 m: the tool stayed where it was"},
    {kLateTick, "came after more time than is caught up with; call more often"},
};

}  // namespace

std::vector<std::string> FlagCounts::warnings() const {
  std::vector<std::string> out;
  const long ticks = ticks_.load(std::memory_order_relaxed);
  for (const auto& [flag, words] : kWords) {
    const long count = counts_[static_cast<std::size_t>(std::countr_zero(flag))].load(std::memory_order_relaxed);
    if (count > 0) out.push_back(text(count, " of ", ticks, " ticks ", words));
  }
  return out;
}

}  // namespace kt
