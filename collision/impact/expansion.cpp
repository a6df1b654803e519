#include "collision/impact/expansion.hpp"

#include <cmath>

namespace kt {
namespace {

struct Two {
  double high, low;  // high: the rounded result, low: its error
};

Two two_sum(double a, double b) noexcept {
  const double x = a + b, b_part = x - a, a_part = x - b_part;
  return {x, (a - a_part) + (b - b_part)};
}

/// With |a| >= |b|.
Two fast_two_sum(double a, double b) noexcept {
  const double x = a + b;
  return {x, b - (x - a)};
}

/// a = high + low, each with at most 26 bits.
Two split(double a) noexcept {
  const double c = 134217729.0 * a;  // 2^27 + 1
  const double high = c - (c - a);
  return {high, a - high};
}

Two two_product(double a, Two a_parts, double b) noexcept {
  const double x = a * b;
  const Two b_parts = split(b);
  const double e = x - a_parts.high * b_parts.high - a_parts.low * b_parts.high - a_parts.high * b_parts.low;
  return {x, a_parts.low * b_parts.low - e};
}

/// Sum of two expansions into `out`, which holds m + n; returns the number of components.
int add(const double* e, int m, const double* f, int n, double* out) noexcept {
  if (m == 0 || n == 0) {
    const int size = m + n;
    std::copy_n(m == 0 ? f : e, size, out);
    return size;
  }
  int i = 0, j = 0, size = 0;
  const auto next = [&] { return j == n || (i < m && std::abs(e[i]) < std::abs(f[j])) ? e[i++] : f[j++]; };
  double q = next();
  while (i < m || j < n) {
    const Two sum = two_sum(q, next());
    if (sum.low != 0) out[size++] = sum.low;
    q = sum.high;
  }
  if (q != 0 || size == 0) out[size++] = q;
  return size == 1 && out[0] == 0 ? 0 : size;
}

/// e times b into `out`, which holds 2 m.
int scale(const double* e, int m, double b, double* out) noexcept {
  if (m == 0 || b == 0) return 0;
  const Two b_parts = split(b);
  int size = 0;
  Two product = two_product(b, b_parts, e[0]);
  if (product.low != 0) out[size++] = product.low;
  double q = product.high;
  for (int i = 1; i < m; ++i) {
    product = two_product(b, b_parts, e[i]);
    const Two sum = two_sum(q, product.low);
    if (sum.low != 0) out[size++] = sum.low;
    const Two top = fast_two_sum(product.high, sum.high);
    if (top.low != 0) out[size++] = top.low;
    q = top.high;
  }
  if (q != 0) out[size++] = q;
  return size;
}

}  // namespace

Expansion Expansion::difference(double a, double b) noexcept {
  Expansion out;
  const Two d = two_sum(a, -b);
  if (d.low != 0) out.x_[out.size_++] = d.low;
  if (d.high != 0) out.x_[out.size_++] = d.high;
  return out;
}

/// Many components are made the fewest that suffice: each is then what all below it round to.
Expansion Expansion::packed(const double* x, int size, bool fits) noexcept {
  Expansion out;
  out.fits_ = fits;
  if (size <= kFew) {
    out.size_ = size;
    std::copy_n(x, size, out.x_);
    return out;
  }
  double g[kScratch];
  int bottom = size - 1;
  double q = x[size - 1];
  for (int i = size - 2; i >= 0; --i) {
    const Two sum = fast_two_sum(q, x[i]);
    q = sum.high;
    if (sum.low != 0) {
      g[bottom--] = q;
      q = sum.low;
    }
  }
  g[bottom] = q;
  int top = 0;
  for (int i = bottom + 1; i < size; ++i) {
    const Two sum = fast_two_sum(g[i], q);
    if (sum.low != 0) {
      if (top == kCapacity - 1) {
        out.fits_ = false;
        return out;
      }
      out.x_[top++] = sum.low;
    }
    q = sum.high;
  }
  if (q != 0) out.x_[top++] = q;
  out.size_ = top;
  return out;
}

double Expansion::estimate() const noexcept {
  double sum = 0;
  for (int i = 0; i < size_; ++i) sum += x_[i];
  return sum;
}

Expansion Expansion::operator-() const noexcept {
  Expansion out;
  out.size_ = size_;
  out.fits_ = fits_;
  for (int i = 0; i < size_; ++i) out.x_[i] = -x_[i];
  return out;
}

Expansion Expansion::operator*(double factor) const noexcept {
  double product[kScratch];
  const int n = scale(x_, size_, factor, product);
  return packed(product, n, fits_);
}

Expansion operator+(const Expansion& a, const Expansion& b) noexcept {
  double sum[Expansion::kScratch];
  const int n = add(a.x_, a.size_, b.x_, b.size_, sum);
  return Expansion::packed(sum, n, a.fits_ && b.fits_);
}

Expansion operator*(const Expansion& a, const Expansion& b) noexcept {
  if (a.size_ > b.size_) return b * a;
  Expansion out;
  out.fits_ = a.fits_ && b.fits_;
  double product[Expansion::kScratch], sum[Expansion::kScratch];
  for (int i = 0; i < a.size_; ++i) {
    const int n = scale(b.x_, b.size_, a.x_[i], product);
    out = Expansion::packed(sum, add(out.x_, out.size_, product, n, sum), out.fits_);
  }
  return out;
}

}  // namespace kt
