#include "haptics/watch/touch_watch.hpp"

#include <algorithm>
#include <iterator>

#include "haptics/watch/flag_counts.hpp"

namespace kt {

TouchWatch::TouchWatch(const Surface& surface, std::span<const ToolShape> tools, double h, ModelObserver* next)
    : tools_(tools.size()), h_(h), next_(next) {
  constexpr bool kLater = true, kKeepsDepths = false;
  if (tools_ > 0) contacts_.emplace(surface, tools, kLater, h, kKeepsDepths);
}

void TouchWatch::ticked(const HapticSide& side, std::span<const LocalFrame> frames) noexcept {
  if (contacts_) contacts_->ticked(side, frames);
}

void TouchWatch::adopted(const PreparedLocalModel& model) noexcept {
  if (next_) next_->adopted(model);
}

bool TouchWatch::look_back(const PreparedLocalModel& model, int most) {
  bool is_more = false;
  if (contacts_) {
    const std::scoped_lock lock(guard_);
    is_more = contacts_->look_back(model, most);
  }
  if (next_ && next_->look_back(model, most)) is_more = true;
  return is_more;
}

void TouchWatch::refreshed(const RefreshRecord& record) {
  {
    const std::scoped_lock lock(guard_);
    ++refreshes_;
    indefinite_ += record.definite_tangent;
    if (record.global_ms) inverted_.add(record.inverted, record.t);
    crossings_ = std::max(crossings_, record.crossings);
    pressed_ = std::max(pressed_, record.pressed);
  }
  if (next_) next_->refreshed(record);
}

void TouchWatch::finish(const PreparedLocalModel& model) {
  const std::scoped_lock lock(guard_);
  if (contacts_) contacts_->finish(model);
}

void TouchWatch::tell(long ticks, std::size_t tetrahedra, double stiffness, std::vector<Finding>& out) const {
  const std::scoped_lock lock(guard_);
  for (std::size_t k = 0; k < tools_; ++k) {
    const LostContact lost = contacts_->lost(k);
    if (lost.deep_ticks > 0) out.push_back(depth_finding(lost.deepest, {lost.deep_ticks, ticks}, k));
    std::ranges::move(lost_contact_findings(lost, ticks, h_, k, sooner_models()), std::back_inserter(out));
    if (auto found = unchecked_finding(lost, ticks, k)) out.push_back(*std::move(found));
  }
  tell_of_body(tetrahedra, stiffness, out);
}

void TouchWatch::tell_of_body(std::size_t tetrahedra, double stiffness, std::vector<Finding>& out) const {
  const Cure gently = advise("press less deep");
  if (indefinite_ > 0) out.push_back(indefinite_finding(indefinite_, refreshes_, {gently}));
  if (auto found = inverted_finding(inverted_, tetrahedra, {gently, advise("take finer cells")}))
    out.push_back(*std::move(found));
  if (crossings_ > 0) out.push_back(crossed_finding(crossings_));
  if (pressed_ > 0) out.push_back(pressed_finding(pressed_, stiffness));
}

}  // namespace kt
