#include "haptics/remote/yield_memory.hpp"

#include <algorithm>

namespace kt {
namespace {

constexpr std::size_t kMostKept = 256;  // as many models as the body's computer keeps

}  // namespace

void YieldMemory::add(const PreparedLocalModel& model) {
  patches_[model.model.frame] = model.surface.fine;
  while (patches_.size() > kMostKept) patches_.erase(patches_.begin());
}

void YieldMemory::note(const LocalMotion& motion) {
  const auto patch = patches_.find(motion.frame);
  if (patch == patches_.end() || !patch->second) return;
  kept_.push_back({motion.tick, patch->second, motion.yielded.head(3 * patch->second->num_yielding())});
  if (kept_.size() > kMostKept) kept_.pop_front();
}

void YieldMemory::start(PreparedLocalModel& model, int tick) const {
  if (!model.surface.fine) return;
  const auto kept = std::ranges::find(kept_, tick, &Kept::tick);
  if (kept == kept_.end())
    model.state.yielded.setZero();
  else
    carry_yield(kept->patch.get(), kept->yielded, *model.surface.fine, model.state.yielded);
}

void YieldMemory::clear() {
  patches_.clear();
  kept_.clear();
}

}  // namespace kt
