#include "haptics/driver/haply/haply_echo.hpp"

namespace kt {
namespace {

constexpr std::int64_t kPatience_ns = 150'000'000;  // that a force is waited for, and
constexpr int kAnswers = 20;                        // as many messages at least
constexpr double kLoud = 0.02;                      // [N] that a service has to repeat

}  // namespace

void HaplyEcho::sent(const Vec3& force, std::int64_t order_ns, std::int64_t now) noexcept {
  sent_[sends_++ % sent_.size()] = {force, order_ns};
  const double size = force.norm();
  proofs_ += !is_proven_ && size > 0;
  if (!(size >= kLoud)) {
    loud_ns_ = 0;
  } else if (loud_ns_ == 0) {
    loud_ns_ = now;
    least_loud_ = size;
    answers_ = 0;
  } else {
    least_loud_ = std::min(least_loud_, size);
  }
}

void HaplyEcho::heard(const std::optional<Vec3>& force, std::int64_t now) noexcept {
  ++answers_;
  if (force) most_ = std::max(most_, force->norm());
  if (!is_proven_) return prove(force, now);
  watch(force, now);
  if (force) match(*force, now);
}

void HaplyEcho::begin(std::int64_t now) noexcept {
  proofs_ = answers_ = 0;
  began_ns_ = now;
}

/// What comes back points as the proof does; as large it need not be: what the service makes of it is told by `most`.
void HaplyEcho::prove(const std::optional<Vec3>& force, std::int64_t now) noexcept {
  constexpr double kSmallest = 0.05, kLargest = 20;  // shares of the proof
  if (proofs_ == 0) return begin(now);
  if (force) {
    const double size = force->norm();
    if (size > kSmallest * kProof && size < kLargest * kProof && force->dot(proof()) > 0.9 * size * kProof) {
      is_proven_ = true;
      proofs_ = 0;
      loud_ns_ = 0;
      acknowledged_ = sends_;
      return;
    }
  }
  if (now - began_ns_ < kPatience_ns || answers_ < kAnswers) return;
  key_ = key_ == HaplyKey::vector ? HaplyKey::values : HaplyKey::vector;
  begin(now);
}

void HaplyEcho::watch(const std::optional<Vec3>& force, std::int64_t now) noexcept {
  if (loud_ns_ == 0) return;
  if (force && force->norm() > 0.05 * least_loud_) {
    repeated_ns_ = now;
    answers_ = 0;
  }
  if (now - std::max(loud_ns_, repeated_ns_) < kPatience_ns || answers_ < kAnswers) return;
  is_proven_ = false;
  begin(now);
}

/// The force that is repeated was sent some time ago: it is told apart by its value.
void HaplyEcho::match(const Vec3& force, std::int64_t now) noexcept {
  constexpr double kSame = 1e-4;  // [N] the service rounds
  for (std::size_t back = 0; back < sent_.size() - 1 && back + 1 < sends_; ++back) {
    const std::size_t i = sends_ - 1 - back;
    if (i <= acknowledged_) return;
    const Sent &it = sent_[i % sent_.size()], &before = sent_[(i - 1) % sent_.size()];
    if ((it.force - force).norm() > kSame) continue;
    if ((it.force - before.force).norm() < 4 * kSame) continue;  // not told apart from the one before
    acknowledged_ = i;
    if (it.order_ns != 0) delay_ = now - it.order_ns;
    return;
  }
}

}  // namespace kt
