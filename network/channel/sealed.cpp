#include "network/channel/sealed.hpp"

#include <sodium.h>

#include <algorithm>
#include <limits>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr std::size_t kCounterBytes = 8;
static_assert(kSealOverhead == kCounterBytes + crypto_aead_chacha20poly1305_ietf_ABYTES);
static_assert(sizeof(SealKey) == crypto_aead_chacha20poly1305_ietf_KEYBYTES);

void start_sodium() {
  static const bool started = sodium_init() >= 0;
  if (!started) throw RunError("libsodium: no random numbers from the system");
}

using Nonce = std::array<std::uint8_t, crypto_aead_chacha20poly1305_ietf_NPUBBYTES>;

/// Direction, three zeros, counter.
Nonce nonce_of(std::uint8_t direction, std::uint64_t counter) {
  Nonce nonce{direction};
  for (std::size_t i = 0; i < kCounterBytes; ++i)
    nonce[nonce.size() - kCounterBytes + i] = static_cast<std::uint8_t>(counter >> (8 * i));
  return nonce;
}

}  // namespace

SealKey new_seal_key() {
  start_sodium();
  SealKey key;
  randombytes_buf(key.data(), key.size());
  return key;
}

Sealer::Sealer(const SealKey& key, std::uint8_t direction) : key_(key), direction_(direction) { start_sodium(); }

Sealer::~Sealer() { sodium_memzero(key_.data(), key_.size()); }

void Sealer::seal(std::span<const std::uint8_t> payload, std::vector<std::uint8_t>& datagram) {
  const Nonce nonce = nonce_of(direction_, counter_++);
  datagram.resize(kSealOverhead + payload.size());
  std::copy_n(nonce.end() - kCounterBytes, kCounterBytes, datagram.begin());
  crypto_aead_chacha20poly1305_ietf_encrypt(datagram.data() + kCounterBytes, nullptr, payload.data(), payload.size(),
                                            nullptr, 0, nullptr, nonce.data(), key_.data());
}

Opener::Opener(const SealKey& key, std::uint8_t direction) : key_(key), direction_(direction) { start_sodium(); }

Opener::~Opener() { sodium_memzero(key_.data(), key_.size()); }

bool Opener::has(std::uint64_t counter) const { return came_[counter % kWindow / 64] >> (counter % 64) & 1; }

/// Of a datagram that was opened: moves the window on to it when it is the newest.
void Opener::mark(std::uint64_t counter) {
  if (next_ == 0) first_ = counter;
  if (counter >= next_) {
    const std::uint64_t steps = std::min(counter - next_, kWindow);
    for (std::uint64_t c = counter - steps; c < counter; ++c)
      came_[c % kWindow / 64] &= ~(std::uint64_t{1} << (c % 64));
    next_ = counter + 1;
  }
  came_[counter % kWindow / 64] |= std::uint64_t{1} << (counter % 64);
}

bool Opener::open(std::span<const std::uint8_t> datagram, std::vector<std::uint8_t>& payload) {
  payload.clear();
  if (datagram.size() < kSealOverhead) return ++counts_.too_short, false;
  std::uint64_t counter = 0;
  for (std::size_t i = 0; i < kCounterBytes; ++i) counter |= static_cast<std::uint64_t>(datagram[i]) << (8 * i);
  if (counter == std::numeric_limits<std::uint64_t>::max()) return ++counts_.forged, false;
  if (counter < next_) {  // cheap, hence before the seal; nothing is marked before the seal has been looked at
    if (next_ - counter > kWindow) return ++counts_.too_old, false;
    if (has(counter)) return ++counts_.replayed, false;
  }
  const Nonce nonce = nonce_of(direction_, counter);
  payload.resize(datagram.size() - kSealOverhead);
  if (crypto_aead_chacha20poly1305_ietf_decrypt(payload.data(), nullptr, nullptr, datagram.data() + kCounterBytes,
                                                datagram.size() - kCounterBytes, nullptr, 0, nonce.data(),
                                                key_.data()) != 0) {
    payload.clear();
    return ++counts_.forged, false;
  }
  mark(counter);
  ++counts_.opened;
  return true;
}

std::optional<double> Opener::loss() const {
  if (next_ < first_ + kLossLate + kLossFirst) return {};
  const std::uint64_t end = next_ - kLossLate, begin = std::max(first_, end - std::min(end, kLossWindow));
  std::uint64_t lost = 0;
  for (std::uint64_t counter = begin; counter < end; ++counter) lost += !has(counter);
  return static_cast<double>(lost) / static_cast<double>(end - begin);
}

}  // namespace kt
