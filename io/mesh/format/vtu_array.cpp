#include "io/mesh/format/vtu_array.hpp"

#include "core/base/error.hpp"
#include "io/mesh/format/base64.hpp"
#include "io/mesh/format/inflate.hpp"

namespace kt {
namespace {

/// Bytes from the beginning of an array, as many as are asked for, or an error.
class ArrayStart {
 public:
  ArrayStart(std::string_view source, bool is_base64) : source_(source), is_base64_(is_base64) {}

  std::string_view first(std::size_t n) {
    const std::size_t possible = is_base64_ ? source_.size() / 4 * 3 + 3 : source_.size();
    if (n <= possible) {
      if (!is_base64_) return source_.substr(0, n);
      if (decoded_.size() < n) decoded_ = from_base64(source_, n);
      if (decoded_.size() >= n) return std::string_view(decoded_).substr(0, n);
    }
    throw InputError(text("the array needs ", n, " bytes, more than follow: the file is truncated"));
  }

 private:
  std::string_view source_;
  bool is_base64_;
  std::string decoded_;
};

void check_size(std::uint64_t bytes, std::size_t most) {
  if (bytes > most) throw InputError(text("the array has ", bytes, " bytes; at most ", most, " are possible"));
}

#if KT_WITH_ZLIB
/// The number of blocks, the bytes of a block and of the last one if that is shorter, the compressed bytes of each.
std::string inflated(ArrayStart& array, const VtuEncoding& encoding, std::size_t most) {
  const std::size_t word = encoding.wide ? 8 : 4;
  const auto number = [&](std::size_t i) {
    return bits_of(array.first(word * (i + 1)).substr(word * i), word, encoding.order);
  };
  const std::uint64_t blocks = number(0);
  if (blocks == 0) return "";
  check_size(blocks, most);
  const std::uint64_t size = number(1), last = number(2);
  std::size_t at = word * (3 + static_cast<std::size_t>(blocks));
  array.first(at);  // all lengths are there
  std::size_t end = at;
  for (std::size_t i = 0; i < blocks; ++i) {
    check_size(number(3 + i), most);
    check_size(end += static_cast<std::size_t>(number(3 + i)), most + at);
  }
  array.first(end);  // decoded once
  std::string out;
  for (std::size_t i = 0; i < blocks; ++i) {
    const std::uint64_t length = number(3 + i);
    const std::uint64_t bytes = i + 1 == blocks && last > 0 ? last : size;
    check_size(bytes, most - out.size());
    const std::string_view compressed = array.first(at + static_cast<std::size_t>(length)).substr(at);
    append_inflated(compressed, static_cast<std::size_t>(bytes), out);
    at += static_cast<std::size_t>(length);
  }
  return out;
}
#else
std::string inflated(ArrayStart&, const VtuEncoding&, std::size_t) {
  throw InputError("the arrays are compressed, which needs zlib: configure with -DKT_WITH_ZLIB=ON");
}
#endif

}  // namespace

std::string vtu_array_bytes(std::string_view source, bool is_base64, const VtuEncoding& encoding, std::size_t most) {
  ArrayStart array(source, is_base64);
  if (encoding.compressed) return inflated(array, encoding, most);
  const std::size_t head = encoding.wide ? 8 : 4;
  const std::uint64_t length = bits_of(array.first(head), head, encoding.order);
  check_size(length, most);
  return std::string(array.first(head + static_cast<std::size_t>(length)).substr(head));
}

NumberType vtu_type(std::string_view name) {
  constexpr std::pair<std::string_view, NumberType> kTypes[] = {
      {"Float64", kFloat64}, {"Float32", kFloat32}, {"Int64", kInt64},   {"UInt64", kUInt64}, {"Int32", kInt32},
      {"UInt32", kUInt32},   {"Int16", kInt16},     {"UInt16", kUInt16}, {"Int8", kInt8},     {"UInt8", kUInt8}};
  for (const auto& [known, type] : kTypes)
    if (name == known) return type;
  return {};
}

std::vector<double> values_of(std::string_view bytes, const NumberType& type, std::endian order) {
  std::vector<double> out;
  out.reserve(bytes.size() / type.size);
  for (; bytes.size() >= type.size; bytes.remove_prefix(type.size))
    out.push_back(real_of(bits_of(bytes, type.size, order), type));
  return out;
}

}  // namespace kt
