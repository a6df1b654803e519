#pragma once
// Numbers as text and back, the same whatever locale the host program has set: a point for decimals, no grouping. What
// reads the locale (stod, strtod, sscanf, printf's %f and %g, streams without the classic one, isspace) is not used.
#include <charconv>
#include <cmath>
#include <cstdint>
#include <locale>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/error.hpp"

namespace kt {

/// As printf's %.{digits}g.
std::string with_digits(double value, int digits);
/// As printf's %.{decimals}f.
std::string with_decimals(double value, int decimals);
/// A figure for people: three digits, "0.0376", "2380"; no exponent from a millionth to a million.
std::string short_number(double value, int digits = 3);
/// The same with the prefix of its unit, from nano to giga: "2.23 ms", "80 um", "1.5 GB".
std::string in_unit(double value, const char* unit, int digits = 3);
/// Of a share: "3.76 %", "243 %"; "< 0.01 %".
std::string in_percent(double share, int digits = 3);
/// What people are told: the arguments one after the other, as text() has them, but numbers as short_number().
template <class... Args>
std::string told(const Args&... args) {
  const auto shown = [](const auto& arg) -> decltype(auto) {
    if constexpr (std::is_floating_point_v<std::remove_cvref_t<decltype(arg)>>)
      return short_number(arg);
    else
      return (arg);
  };
  return text(shown(args)...);
}
/// Sixteen hexadecimal digits.
std::string sixteen_digits(std::uint64_t value);

/// The whole word as a number; none: it is no number, or beyond the range of a double. "inf" and "nan" are numbers.
std::optional<double> to_double(std::string_view word) noexcept;
/// The number that a word begins with, as a file of the system's has it; 0: it begins with none.
double leading_number(std::string_view word) noexcept;

/// Of ASCII; other bytes are none of these, and stay.
constexpr bool is_space(char c) noexcept { return c == ' ' || (c >= '\t' && c <= '\r'); }
constexpr bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }
constexpr char lower(char c) noexcept { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
constexpr char upper(char c) noexcept { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }
constexpr bool is_letter(char c) noexcept { return lower(c) >= 'a' && lower(c) <= 'z'; }
constexpr bool is_hex_digit(char c) noexcept { return is_digit(c) || (lower(c) >= 'a' && lower(c) <= 'f'); }

/// A stream that reads and writes numbers as C does.
template <class Stream>
Stream classic(Stream stream) {
  stream.imbue(std::locale::classic());
  return stream;
}

}  // namespace kt
