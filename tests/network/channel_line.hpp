#pragma once
// A line of datagrams in virtual time, and ways to spoil what travels on it.
#include <cstdint>
#include <map>
#include <random>
#include <vector>

namespace kt {

using Bytes = std::vector<std::uint8_t>;

inline double uniform(std::mt19937_64& random) { return std::uniform_real_distribution<double>(0, 1)(random); }

struct LineOptions {
  double loss = 0, duplicate = 0;
  double delay = 0.025, jitter = 0;  ///< [s]; jitter lets them overtake each other
};

/// What is sent arrives later, perhaps, perhaps twice, in another order.
class VirtualLine {
 public:
  VirtualLine(const LineOptions& options, std::uint64_t seed) : options_(options), random_(seed) {}

  void send(double now, const Bytes& datagram) {
    const int copies = uniform(random_) < options_.duplicate ? 2 : 1;
    for (int i = 0; i < copies; ++i)
      if (uniform(random_) >= options_.loss)
        on_way_.emplace(now + options_.delay + options_.jitter * uniform(random_), datagram);
  }

  /// Hands over what has arrived until `now`, in order of time.
  template <class Take>
  void arrive(double now, const Take& take) {
    while (!on_way_.empty() && on_way_.begin()->first <= now) {
      take(on_way_.begin()->second);
      on_way_.erase(on_way_.begin());
    }
  }

 private:
  LineOptions options_;
  std::mt19937_64 random_;
  std::multimap<double, Bytes> on_way_;
};

/// Flips bits, cuts, lengthens, exchanges bytes, mixes two or makes up another.
inline Bytes mutated(const Bytes& one, const Bytes& other, std::mt19937_64& random) {
  Bytes out = one;
  const auto at = [&](std::size_t size) { return static_cast<std::size_t>(random() % std::max<std::size_t>(size, 1)); };
  const int changes = 1 + static_cast<int>(random() % 3);
  for (int i = 0; i < changes; ++i) {
    const std::size_t head = random() % 2 ? std::min<std::size_t>(out.size(), 40) : out.size();  // headers oftener
    switch (random() % 7) {
      case 0:
      case 1:
        if (!out.empty()) out[at(head)] ^= static_cast<std::uint8_t>(1U << random() % 8);
        break;
      case 2:
        if (!out.empty()) out[at(head)] = static_cast<std::uint8_t>(random());
        break;
      case 3:
        out.resize(at(out.size() + 1));
        break;
      case 4:
        out.resize(out.size() + 1 + random() % 40, static_cast<std::uint8_t>(random()));
        break;
      case 5:
        if (!out.empty()) std::swap(out[at(head)], out[at(out.size())]);
        break;
      default: {
        const std::size_t n = std::min(out.size(), other.size()), from = at(n);
        std::copy(other.begin() + static_cast<std::ptrdiff_t>(from), other.begin() + static_cast<std::ptrdiff_t>(n),
                  out.begin() + static_cast<std::ptrdiff_t>(from));
      }
    }
  }
  return out;
}

}  // namespace kt
