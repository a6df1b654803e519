#pragma once
// Sealed datagrams: nobody without the key can read, make, change or repeat one.
//
// ChaCha20-Poly1305 as in RFC 8439 (libsodium). A datagram is a counter (u64, little-endian), the sealed payload and a
// tag of 16 bytes; the nonce is the direction and the counter, so that the two directions share a key and neither
// accepts its own datagrams back. The receiver keeps a window of the last 4096 counters (RFC 6479) and tells from it
// what gets lost.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kt {

using SealKey = std::array<std::uint8_t, 32>;
constexpr std::size_t kSealOverhead = 24;  ///< bytes of a datagram beyond its payload

/// A key from the system's random numbers: one a session, never two sealers of one direction with the same.
SealKey new_seal_key();

/// Seals what goes in one direction. Not to be copied: the same counter must never seal two payloads.
class Sealer {
 public:
  Sealer(const SealKey& key, std::uint8_t direction);
  ~Sealer();
  Sealer(const Sealer&) = delete;
  Sealer& operator=(const Sealer&) = delete;

  /// Seal just before sending: a counter that is never sent is counted as lost by the other side.
  /// @param datagram  replaced
  void seal(std::span<const std::uint8_t> payload, std::vector<std::uint8_t>& datagram);

  std::uint64_t num_sealed() const { return counter_; }

 private:
  SealKey key_;
  std::uint8_t direction_;
  std::uint64_t counter_ = 0;
};

/// What a receiver tells its sender of the datagrams that came.
struct Feedback {
  std::uint64_t newest = 0;  ///< counter after that of the newest
  std::uint64_t came = 0;    ///< all of them, so far
};

struct OpenCounts {
  long opened = 0;
  long too_short = 0;  ///< no counter and tag
  long forged = 0;     ///< changed, of another key or direction
  long replayed = 0;   ///< came before
  long too_old = 0;    ///< behind the window: cannot tell whether it came before
  long refused() const { return too_short + forged + replayed + too_old; }
};

/// Opens what comes from one direction.
class Opener {
 public:
  static constexpr std::uint64_t kWindow = 4096;     ///< counters behind the newest that are still accepted
  static constexpr std::uint64_t kLossWindow = 512;  ///< counters of which loss() tells
  static constexpr std::uint64_t kLossLate = 64;  ///< the newest counters, which loss() leaves out: may be on their way
  static constexpr std::uint64_t kLossFirst = 128;  ///< counters that it needs

  Opener(const SealKey& key, std::uint8_t direction);
  ~Opener();
  Opener(const Opener&) = delete;
  Opener& operator=(const Opener&) = delete;

  /// @param payload  replaced; empty when refused
  /// @returns false: refused and counted
  bool open(std::span<const std::uint8_t> datagram, std::vector<std::uint8_t>& payload);

  OpenCounts counts() const { return counts_; }

  Feedback feedback() const { return {next_, static_cast<std::uint64_t>(counts_.opened)}; }

  /// Share of the datagrams sent that did not come, of the kLossWindow before the newest kLossLate; not known while
  /// there are fewer than kLossFirst. One that comes late counts as come as soon as it does.
  std::optional<double> loss() const;

 private:
  bool has(std::uint64_t counter) const;
  void mark(std::uint64_t counter);

  SealKey key_;
  std::uint8_t direction_;
  std::uint64_t first_ = 0;                         ///< counter that was opened first
  std::uint64_t next_ = 0;                          ///< newest counter + 1
  std::array<std::uint64_t, kWindow / 64> came_{};  ///< bit counter mod kWindow
  OpenCounts counts_;
};

}  // namespace kt
