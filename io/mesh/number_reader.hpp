#pragma once
// Numbers one after the other, as words of a text or as bytes: a format that comes in both is read by one function.
#include <bit>
#include <string_view>

#include "io/files/text_reader.hpp"
#include "io/mesh/number_type.hpp"

namespace kt {

class NumberReader {
 public:
  /// Words behind the cursor of `in`, whatever their type would be as bytes.
  explicit NumberReader(TextReader& in) : in_(in) {}
  /// From now on bytes.
  void use_bytes(std::endian order) {
    is_binary_ = true;
    order_ = order;
  }

  bool is_binary() const { return is_binary_; }

  /// The next number. @throws InputError naming `what` when it is missing or is no number.
  double real(const NumberType& type, const What& what);
  long long integer(const NumberType& type, const What& what);
  /// A finite coordinate below kLargestCoordinate; with `allow_non_finite` NaN and infinity too.
  double coordinate(const NumberType& type, const What& what, bool allow_non_finite);
  /// An announced number of records of at least `bytes_each` bytes, `words_each` words in a text.
  int count(const NumberType& type, std::string_view what, std::size_t bytes_each, std::size_t words_each);
  void check_count(long long n, std::string_view what, std::size_t bytes_each, std::size_t words_each) const;

  /// Throws InputError, with the line in a text and with the byte (from 0) in a binary file.
  template <class... Args>
  [[noreturn]] void fail(const Args&... args) const {
    if (!is_binary_) in_.fail(args...);
    throw InputError(text(in_.path(), ": byte ", in_.position(), ": ", args...));
  }

 private:
  std::uint64_t take(const NumberType& type, const What& what);

  TextReader& in_;
  bool is_binary_ = false;
  std::endian order_ = std::endian::little;
};

}  // namespace kt
