#pragma once
// Exact sums and products: a number as the unevaluated sum of doubles (Shewchuk 1997, "Adaptive precision
// floating-point arithmetic and fast robust geometric predicates"). Fixed memory; a result that does not fit is marked.
// Exact as long as nothing underflows, with rounding to nearest.
#include <algorithm>

namespace kt {

/// x[0] + x[1] + ... + x[size - 1], by increasing magnitude, no two bits overlapping, no component zero.
class Expansion {
 public:
  static constexpr int kCapacity = 40;

  Expansion() noexcept = default;
  explicit Expansion(double value) noexcept : size_(value != 0) { x_[0] = value; }
  Expansion(const Expansion& other) noexcept { *this = other; }
  Expansion& operator=(const Expansion& other) noexcept {
    size_ = other.size_;
    fits_ = other.fits_;
    std::copy_n(other.x_, size_, x_);
    return *this;
  }
  static Expansion difference(double a, double b) noexcept;

  int size() const noexcept { return size_; }
  /// False: too many components were needed somewhere on the way; the value means nothing.
  bool fits() const noexcept { return fits_; }
  /// Nearest double to within 2 u; zero only for zero, and of the right sign.
  double estimate() const noexcept;

  Expansion operator-() const noexcept;
  Expansion operator*(double factor) const noexcept;
  friend Expansion operator+(const Expansion& a, const Expansion& b) noexcept;
  friend Expansion operator-(const Expansion& a, const Expansion& b) noexcept { return a + (-b); }
  friend Expansion operator*(const Expansion& a, const Expansion& b) noexcept;

 private:
  static constexpr int kFew = 8;
  static constexpr int kScratch = 3 * kCapacity;  // an expansion and one scaled
  static Expansion packed(const double* x, int size, bool fits) noexcept;

  int size_ = 0;
  bool fits_ = true;
  double x_[kCapacity];
};

}  // namespace kt
