#include "io/mesh/number_reader.hpp"

#include <cmath>
#include <limits>

namespace kt {

std::uint64_t NumberReader::take(const NumberType& type, const What& what) {
  const std::string_view bytes = in_.rest();
  if (bytes.size() < type.size) fail("file ends where ", what, " should be");
  in_.skip_bytes(type.size);
  return bits_of(bytes, type.size, order_);
}

double NumberReader::real(const NumberType& type, const What& what) {
  return is_binary_ ? real_of(take(type, what), type) : in_.number(what, true);
}

long long NumberReader::integer(const NumberType& type, const What& what) {
  if (!is_binary_) return in_.integer(what);
  const std::uint64_t bits = take(type, what);
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<long long>::max());
  if (type.kind == NumberType::Kind::unsigned_integer && bits > kMost) fail(what, " is ", bits, ", which is too large");
  return integer_of(bits, type);
}

double NumberReader::coordinate(const NumberType& type, const What& what, bool allow_non_finite) {
  if (!is_binary_) return in_.coordinate(what, allow_non_finite);
  const double value = real_of(take(type, what), type);
  if (!std::isfinite(value) && !allow_non_finite) fail(what, " is ", value, "; must be finite");
  if (std::isfinite(value) && std::abs(value) >= kLargestCoordinate)
    fail(what, " is ", value, "; must be below ", kLargestCoordinate);
  return value;
}

void NumberReader::check_count(long long n, std::string_view what, std::size_t bytes_each,
                               std::size_t words_each) const {
  if (!is_binary_) return in_.check_count(n, what, 2 * words_each);  // a digit and a blank
  if (n < 0) fail("number of ", what, " is ", n, "; must be at least 0");
  constexpr long long kMost = std::numeric_limits<int>::max() / 4;  // 3n and 4n stay ints
  if (n > kMost) fail("header announces ", n, " ", what, "; at most ", kMost, " are possible");
  const std::size_t possible = in_.bytes_left() / bytes_each;
  if (static_cast<std::size_t>(n) > possible)
    fail("header announces ", n, " ", what, ", but the ", in_.bytes_left(), " bytes that follow hold at most ",
         possible);
}

int NumberReader::count(const NumberType& type, std::string_view what, std::size_t bytes_each, std::size_t words_each) {
  const long long n = integer(type, text("the number of ", what));
  check_count(n, what, bytes_each, words_each);
  return static_cast<int>(n);
}

}  // namespace kt
