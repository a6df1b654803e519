#include "haptics/remote/report_box.hpp"

#include <algorithm>
#include <ranges>

namespace kt {
namespace {

void add_to(std::array<ImpulseCount, kMaxTools>& sum, const LocalReport& report) {
  for (const TickContact& c : report.contacts()) {
    const ImpulseCount count = count_impulse(c.impulse);
    for (std::size_t i = 0; i < 3; ++i) sum[static_cast<std::size_t>(c.tool)][i] += count[i];
  }
}

/// To the contact of each tool that carries most.
void follow(std::array<ContactPlace, kMaxTools>& place, const LocalReport& report) {
  std::array<double, kMaxTools> most;
  most.fill(-1);
  for (const TickContact& c : report.contacts()) {
    const auto k = static_cast<std::size_t>(c.tool);
    if (c.impulse.squaredNorm() <= most[k]) continue;
    most[k] = c.impulse.squaredNorm();
    place[k] = {c, report.model_frame};
  }
}

}  // namespace

void ReportOutbox::add(const LocalReport& report) {
  Entry& entry = entries_.emplace_back();
  entry.report = as_sent(report, h_);
  add_to(sum_, entry.report);
  follow(place_, entry.report);
  entry.sum = sum_;
  entry.place = place_;
  if (entries_.size() > kept_) entries_.pop_front();
}

ReportBatch ReportOutbox::batch_to(int tick, std::size_t count) const {
  ReportBatch out;
  const auto end = static_cast<std::size_t>(tick - entries_.front().report.tick) + 1;
  for (std::size_t i = end - std::min(count, end); i < end; ++i) out.reports.push_back(entries_[i].report);
  out.sum = entries_[end - 1].sum;
  out.place = entries_[end - 1].place;
  return out;
}

void ReportInbox::take(const ReportBatch& batch) {
  for (const LocalReport& report : batch.reports) {
    const bool is_late = report.tick < next_, is_absurd = report.tick >= next_ + kMostAhead;
    if (is_late || is_absurd || !waiting_.try_emplace(report.tick, report).second) {
      ++counts_.again;
      continue;
    }
    ++counts_.received;
    if (report.left_patch) edge_ = std::max(edge_, report.tick);
  }
}

std::span<const LocalReport> ReportInbox::close(const ReportBatch& at) {
  take(at);
  out_.clear();
  lost_.clear();
  const int end = at.last() + 1;
  if (end <= next_ || end > next_ + kMostAhead) return out_;
  int tick = next_;
  for (auto it = waiting_.begin(); it != waiting_.end() && it->first < end; it = waiting_.erase(it), ++tick) {
    for (; tick < it->first; ++tick) lost_.push_back(tick);
    out_.push_back(it->second);
  }
  next_ = end;
  for (const LocalReport& report : out_) {
    add_to(given_, report);
    follow(place_, report);
  }
  counts_.lost += static_cast<int>(lost_.size());
  if (!lost_.empty()) book(at);
  return out_;
}

/// As one more report at the first tick that was lost.
void ReportInbox::book(const ReportBatch& at) {
  LocalReport extra;
  const auto next = std::ranges::lower_bound(out_, lost_.front(), {}, &LocalReport::tick);
  extra = next == out_.begin() ? *next : *std::prev(next);
  extra.tick = lost_.front();
  extra.left_patch = false;
  extra.count = 0;
  for (std::size_t k = 0; k < kMaxTools; ++k) {
    ImpulseCount missing{};
    for (std::size_t i = 0; i < 3; ++i) missing[i] = at.sum[k][i] - given_[k][i];
    const ContactPlace& place = place_[k].is_known() ? place_[k] : at.place[k];
    if (missing == ImpulseCount{} || !place.is_known()) continue;
    TickContact& c = extra.samples[static_cast<std::size_t>(extra.count++)];
    c = place.contact;
    c.t = extra.tick * h_;
    c.tool = static_cast<int>(k);
    c.impulse = impulse_of(missing);
    extra.model_frame = place.model_frame;
    counts_.booked_size += c.impulse.norm();
    given_[k] = at.sum[k];
  }
  if (extra.count > 0) out_.insert(next, extra);
}

std::array<ImpulseCount, kMaxTools> ReportInbox::sum() const {
  std::array<ImpulseCount, kMaxTools> out = given_;
  for (const LocalReport& report : waiting_ | std::views::values) add_to(out, report);
  return out;
}

}  // namespace kt
