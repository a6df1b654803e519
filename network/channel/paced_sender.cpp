#include "network/channel/paced_sender.hpp"

#include <algorithm>
#include <utility>

namespace kt {

Pace pace_for(std::size_t datagrams, double seconds, double limit) {
  constexpr double kBrisk = 1000, kTogether = 1e-3, kSlowest = 1;  // 1/s: 9.5 Mbit/s; [s]; 1/s
  const double rate = std::max(kSlowest, std::min(limit, std::max(kBrisk, static_cast<double>(datagrams) / seconds)));
  const int together = std::max(1, static_cast<int>(kTogether * rate));
  return {together, std::chrono::microseconds(static_cast<long>(1e6 * together / rate))};
}

void PacedSender::put(std::vector<std::vector<std::uint8_t>> payloads, bool urgent, std::uint8_t kind) {
  if (urgent) {
    for (auto& payload : payloads) urgent_.push_back(std::move(payload));
    for (; urgent_.size() > kMostUrgent; ++counts_.overflown) urgent_.pop_front();
    return;
  }
  Waiting& waiting = paced_[kind];
  counts_.replaced += static_cast<long>(waiting.payloads.size() - waiting.sent);
  waiting = {std::move(payloads), 0};
}

std::optional<std::chrono::microseconds> PacedSender::pump(Time now, const Send& send) {
  for (; !urgent_.empty(); ++counts_.urgent) {
    send(urgent_.front());
    urgent_.pop_front();
  }
  if (idle_) due_ = std::max(due_, now);
  due_ = std::max(due_, now - kMostLate * pace_.interval);
  for (; !paced_.empty() && due_ <= now; due_ += pace_.interval) send_some(send);
  idle_ = paced_.empty();
  if (idle_) return std::nullopt;
  return std::chrono::ceil<std::chrono::microseconds>(due_ - now);
}

/// As many as go at once, of the first kinds first.
void PacedSender::send_some(const Send& send) {
  for (int left = pace_.datagrams; left > 0 && !paced_.empty();) {
    const auto next = paced_.begin();
    Waiting& waiting = next->second;
    for (; left > 0 && waiting.sent < waiting.payloads.size(); --left, ++counts_.paced)
      send(waiting.payloads[waiting.sent++]);
    if (waiting.sent == waiting.payloads.size()) paced_.erase(next);
  }
}

std::size_t PacedSender::num_waiting() const {
  std::size_t waiting = urgent_.size();
  for (const auto& [kind, w] : paced_) waiting += w.payloads.size() - w.sent;
  return waiting;
}

}  // namespace kt
