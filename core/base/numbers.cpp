#include "core/base/numbers.hpp"

#include <array>
#include <cmath>

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
  if (std::abs(value) >= 1000 && std::abs(value) < 1e6) return std::to_string(std::llround(value));
  return with_digits(value, digits);
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
