#pragma once
// Numbers as binary files store them: 1 to 8 bytes, signed, unsigned or floating, in either order.
#include <bit>
#include <cstdint>
#include <string_view>

namespace kt {

struct NumberType {
  enum class Kind { signed_integer, unsigned_integer, real } kind = Kind::real;
  std::size_t size = 0;  ///< bytes; 0: none
  bool is_integer() const { return kind != Kind::real; }
};

inline constexpr NumberType kInt8{NumberType::Kind::signed_integer, 1}, kUInt8{NumberType::Kind::unsigned_integer, 1},
    kInt16{NumberType::Kind::signed_integer, 2}, kUInt16{NumberType::Kind::unsigned_integer, 2},
    kInt32{NumberType::Kind::signed_integer, 4}, kUInt32{NumberType::Kind::unsigned_integer, 4},
    kInt64{NumberType::Kind::signed_integer, 8}, kUInt64{NumberType::Kind::unsigned_integer, 8},
    kFloat32{NumberType::Kind::real, 4}, kFloat64{NumberType::Kind::real, 8};

/// The first `size` bytes (1 to 8) as one unsigned number.
inline std::uint64_t bits_of(std::string_view bytes, std::size_t size, std::endian order) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint64_t byte = static_cast<unsigned char>(bytes[i]);
    bits |= byte << 8 * (order == std::endian::big ? size - 1 - i : i);
  }
  return bits;
}

/// The integer that the bits of an integer type stand for; one beyond the range of the result wraps round to below 0.
inline long long integer_of(std::uint64_t bits, const NumberType& type) {
  const bool is_negative =
      type.kind == NumberType::Kind::signed_integer && type.size < 8 && (bits >> (8 * type.size - 1)) != 0;
  return static_cast<long long>(bits) - (is_negative ? 1LL << 8 * type.size : 0);
}

/// The value that the bits of any type stand for.
inline double real_of(std::uint64_t bits, const NumberType& type) {
  if (type.kind == NumberType::Kind::unsigned_integer) return static_cast<double>(bits);
  if (type.is_integer()) return static_cast<double>(integer_of(bits, type));
  return type.size == 8 ? std::bit_cast<double>(bits)
                        : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
}

}  // namespace kt
