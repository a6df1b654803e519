#include "core/base/numbers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace kt {
namespace {

std::string written(double value, std::chars_format format, int precision) {
  std::array<char, 512> room;  // the longest: 309 digits before the point
  const auto [end, error] = std::to_chars(room.data(), room.data() + room.size(), value, format, precision);
  return error == std::errc() ? std::string(room.data(), end) : "number too long";
}

}  // namespace

std::string with_digits(double value, int digits) { return written(value, std::chars_format::general, digits); }

std::string with_decimals(double value, int decimals) { return written(value, std::chars_format::fixed, decimals); }

std::string short_number(double value, int digits) {
  const double size = std::abs(to_double(with_digits(value, digits)).value_or(value));  // as it is going to be written
  if (size >= std::pow(10, digits) && size < 1e6) return std::to_string(std::llround(value));
  if (!(size >= 1e-6 && size < 1e-4)) return with_digits(value, digits);
  std::string out = with_decimals(value, digits + (size < 1e-5 ? 5 : 4));
  out.erase(out.find_last_not_of('0') + 1);
  return out;
}

std::string in_unit(double value, const char* unit, int digits) {
  struct Prefix {
    const char* name;
    double size;
  };
  constexpr Prefix kPrefixes[] = {{"G", 1e9}, {"M", 1e6}, {"k", 1e3}, {"", 1}, {"m", 1e-3}, {"u", 1e-6}, {"n", 1e-9}};
  const double rounded = std::isfinite(value) ? std::abs(to_double(with_digits(value, digits)).value_or(0)) : 0;
  const auto prefix = std::find_if(std::begin(kPrefixes), std::end(kPrefixes) - 1,
                                   [&](const Prefix& p) { return rounded >= p.size || (rounded == 0 && p.size == 1); });
  return text(short_number(value / prefix->size, digits), ' ', prefix->name, unit);
}

std::string in_percent(double share, int digits) {
  return 0 < share && share < 1e-4 ? "< 0.01 %" : short_number(100 * share, digits) + " %";
}

std::string sixteen_digits(std::uint64_t value) {
  std::string out(16, '0');
  for (auto digit = out.rbegin(); digit != out.rend(); ++digit, value >>= 4) *digit = "0123456789abcdef"[value & 15];
  return out;
}

std::optional<double> to_double(std::string_view word) noexcept {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return {};
  return value;
}

double leading_number(std::string_view word) noexcept {
  while (!word.empty() && is_space(word[0])) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() ? value : 0;
}

}  // namespace kt
