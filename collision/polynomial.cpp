#include "collision/polynomial.hpp"

namespace kt::bernstein {
namespace {

constexpr int kMaxHalvings = 46;
constexpr int kMaxPieces = 300;
constexpr double kBinomial[7][7] = {
    {1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}, {1, 6, 15, 20, 15, 6, 1}};

Polynomial with_size(Polynomial p, double error) noexcept {
  p.size = 0;
  for (int i = 0; i <= p.degree; ++i) p.size = std::max(p.size, std::abs(p.b[i]));
  p.error = error + kUnderflow;
  return p;
}

Polynomial raised(const Polynomial& p, int degree) noexcept {
  if (p.degree == degree) return p;
  Polynomial one;
  one.degree = degree - p.degree;
  std::fill_n(one.b, one.degree + 1, 1.0);
  one.size = 1;
  return p * one;
}

/// The parts of p before and after s: `degree` levels of (1-s) x + s y, each within 3 u of the larger.
void subdivide(const Polynomial& p, double s, Polynomial& left, Polynomial& right) noexcept {
  double row[Polynomial::kMaxDegree + 1];
  std::copy_n(p.b, p.degree + 1, row);
  left.degree = right.degree = p.degree;
  for (int level = 0; level <= p.degree; ++level) {
    left.b[level] = row[0];
    right.b[p.degree - level] = row[p.degree - level];
    for (int i = 0; i < p.degree - level; ++i) row[i] = (1 - s) * row[i] + s * row[i + 1];
  }
}

/// How much of [0, 1] is proven to have p > level, from 0 on, by halving; each halving rounds by less than `rounding`.
double proven_above(const Polynomial& p, double level, double rounding, int depth, int& pieces) noexcept {
  if (*std::min_element(p.b, p.b + p.degree + 1) > level) return 1;
  if (depth == 0 || !(p.b[0] > level) || --pieces < 0) return 0;
  Polynomial left, right;
  subdivide(p, 0.5, left, right);
  level += rounding;
  const double first = proven_above(left, level, rounding, depth - 1, pieces);
  return first < 1 ? 0.5 * first : 0.5 + 0.5 * proven_above(right, level, rounding, depth - 1, pieces);
}

}  // namespace

Polynomial line(double a, double b, double error) noexcept {
  Polynomial out;
  out.degree = 1;
  out.b[0] = a, out.b[1] = b;
  return with_size(out, error);
}

Polynomial operator+(const Polynomial& p, const Polynomial& q) noexcept {
  if (p.degree != q.degree) {
    const int degree = std::max(p.degree, q.degree);
    return raised(p, degree) + raised(q, degree);
  }
  Polynomial out;
  out.degree = p.degree;
  for (int i = 0; i <= p.degree; ++i) out.b[i] = p.b[i] + q.b[i];
  return with_size(out, p.error + q.error + kRoundoff * (p.size + q.size));
}

Polynomial operator-(const Polynomial& p, const Polynomial& q) noexcept { return p + (-1.0) * q; }

Polynomial operator*(double factor, const Polynomial& p) noexcept {
  Polynomial out = p;
  for (int i = 0; i <= p.degree; ++i) out.b[i] *= factor;
  const double f = std::abs(factor);
  return with_size(out, f * (p.error + (f == 1 ? 0 : 2 * kRoundoff) * p.size));
}

Polynomial operator*(const Polynomial& p, const Polynomial& q) noexcept {
  Polynomial out;
  out.degree = p.degree + q.degree;
  // Each coefficient is a mean of products: at most 7 terms, 4 roundings each, and their sum, in all below 12 u.
  for (int k = 0; k <= out.degree; ++k) {
    double sum = 0;
    for (int i = std::max(0, k - q.degree); i <= std::min(k, p.degree); ++i)
      sum += kBinomial[p.degree][i] * kBinomial[q.degree][k - i] * (p.b[i] * q.b[k - i]);
    out.b[k] = sum / kBinomial[out.degree][k];
  }
  const double p_most = p.size + p.error, q_most = q.size + q.error;
  return with_size(out, p_most * q.error + q_most * p.error + 12 * kRoundoff * p.size * q.size);
}

double next_nonpositive(const Polynomial& p, double from) noexcept {
  if (from > 1) return kNever;
  Polynomial left, right = p;
  if (from > 0) subdivide(p, from, left, right);
  // One subdivision at `from`, of which each of at most six levels rounds by 3 u.
  const double level = p.error + 20 * kRoundoff * p.size;
  if (!(right.b[0] > 2 * level)) return from;
  int pieces = kMaxPieces;
  const double proven = proven_above(right, level, 8 * kRoundoff * p.size, kMaxHalvings, pieces);
  return proven == 1 ? kNever : std::max(from, (from + proven * (1 - from)) * (1 - 4 * kRoundoff));
}

}  // namespace kt::bernstein
