#pragma once
// Numbers from a fuzzer's bytes, for the narrow phase. As raw doubles nearly all of them are of different magnitudes
// and meet nothing; so they can also be small whole numbers, which touch often and are exact, with noise in the last
// place or without.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>

#include "core/base/types.hpp"

namespace kt::fuzz {

class Numbers {
 public:
  enum class Kind { raw, whole, noisy };

  /// The first byte: the kind, and a scale from 2^-42 to 2^43.
  explicit Numbers(std::span<const std::uint8_t> bytes) : bytes_(bytes.subspan(1)) {
    kind_ = Kind{bytes[0] % 3};
    scale_ = bytes[0] / 3 - 42;
  }
  bool is_whole() const { return kind_ == Kind::whole; }
  int scale() const { return scale_; }

  /// Zero when the bytes have run out. Whole ones are -8 .. 7, times 2^scale.
  double next() {
    double x = 0;
    if (kind_ == Kind::raw) {
      if (bytes_.size() < 8) return 0;
      std::memcpy(&x, bytes_.data(), 8);
      bytes_ = bytes_.subspan(8);
      return x;
    }
    if (bytes_.empty()) return 0;
    const int digit = static_cast<std::int8_t>(bytes_[0]);
    bytes_ = bytes_.subspan(1);
    x = std::ldexp(digit >> 4, scale_);
    if (kind_ == Kind::noisy && (digit & 15) < 4) x = std::nextafter(x, digit & 1 ? 1e300 : -1e300);
    return x;
  }
  Vec3 point() {
    const double x = next(), y = next(), z = next();
    return Vec3(x, y, z);
  }

 private:
  std::span<const std::uint8_t> bytes_;
  Kind kind_ = Kind::raw;
  int scale_ = 0;
};

/// What does not hold, and the points of which it does not, as they can be pasted into a test.
inline void require(bool holds, const char* what, std::span<const Vec3> points) {
  if (holds) return;
  std::fprintf(stderr, "not so: %s\n", what);
  for (const Vec3& p : points) std::fprintf(stderr, "Vec3(%a, %a, %a),\n", p[0], p[1], p[2]);
  std::abort();
}

}  // namespace kt::fuzz
