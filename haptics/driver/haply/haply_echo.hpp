#pragma once
// Whether Haply's service takes our forces, and under which name: by what it repeats of them. Until a force of a few mN
// has come back, nothing more is sent; a service that stops repeating has to prove itself again.
#include <array>
#include <utility>

#include "core/base/types.hpp"
#include "haptics/driver/haply/haply_messages.hpp"

namespace kt {

class HaplyEcho {
 public:
  static constexpr double kProof = 4e-3;  ///< [N] too little to be felt

  explicit HaplyEcho(HaplyKey first) : key_(first) {}

  HaplyKey key() const noexcept { return key_; }
  bool is_proven() const noexcept { return is_proven_; }
  /// Largest force that was repeated so far [N].
  double most() const noexcept { return most_; }

  /// To be sent until it is proven [N], not more often than every 2 ms: within one of the service's ticks forces add
  /// up.
  Vec3 proof() const noexcept { return {0, 0, key_ == HaplyKey::vector ? kProof : -kProof}; }

  /// @param order_ns  when the tick asked for it; 0: it is none of a tick's
  void sent(const Vec3& force, std::int64_t order_ns, std::int64_t now) noexcept;

  /// What a message repeats; none: it repeats nothing.
  void heard(const std::optional<Vec3>& force, std::int64_t now) noexcept;

  /// [ns] from a tick's order to the message that repeats its force, told once each; none: not now.
  std::optional<std::int64_t> take_delay() noexcept { return std::exchange(delay_, {}); }

 private:
  struct Sent {
    Vec3 force = Vec3::Zero();
    std::int64_t order_ns = 0;
  };
  void begin(std::int64_t now) noexcept;
  void prove(const std::optional<Vec3>& force, std::int64_t now) noexcept;
  void watch(const std::optional<Vec3>& force, std::int64_t now) noexcept;
  void match(const Vec3& force, std::int64_t now) noexcept;

  HaplyKey key_;
  bool is_proven_ = false;
  double most_ = 0;
  int proofs_ = 0;             // sent with this key
  std::int64_t began_ns_ = 0;  // the first of them, about
  int answers_ = 0;            // since then, or since the last force that was repeated
  std::int64_t loud_ns_ = 0;   // all forces since then were large enough to be repeated; 0: the last one was not
  std::int64_t repeated_ns_ = 0;
  double least_loud_ = 0;  // of them [N]
  std::array<Sent, 64> sent_;
  std::size_t sends_ = 0, acknowledged_ = 0;
  std::optional<std::int64_t> delay_;
};

}  // namespace kt
