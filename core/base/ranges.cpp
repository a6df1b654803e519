#include "core/base/ranges.hpp"

#include <cmath>

#include "core/base/error.hpp"

namespace kt {

bool is_within(const NumberRange& n) noexcept {
  if (!std::isfinite(n.value)) return false;
  if (n.above ? !(n.value > n.least) : !(n.value >= n.least)) return false;
  return n.below ? n.value < n.most : n.value <= n.most;
}

namespace {

std::string allowed(const NumberRange& n) {
  std::string out;
  if (std::isfinite(n.least)) out = text(n.above ? "above " : "at least ", n.least);
  if (std::isfinite(n.most)) out += text(out.empty() ? "" : ", ", n.below ? "below " : "at most ", n.most);
  return out.empty() ? "finite" : out;
}

}  // namespace

void require_within(std::initializer_list<NumberRange> numbers) {
  for (const NumberRange& n : numbers)
    if (!is_within(n)) throw InputError(text(n.key, " is ", n.value, ", must be ", allowed(n)));
}

}  // namespace kt
