#pragma once
// One array of a VTU file: its bytes out of base64 text or raw data, compressed or not, and its values.
#include <bit>
#include <string>
#include <string_view>
#include <vector>

#include "io/mesh/number_type.hpp"

namespace kt {

struct VtuEncoding {
  bool wide = false;                        ///< lengths have 8 bytes, else 4
  std::endian order = std::endian::little;  ///< of lengths and values
  bool compressed = false;                  ///< by zlib, in blocks
};

/// The bytes of the array that starts at the beginning of `source`, without what precedes them.
/// @param most  more bytes than this are refused
/// @throws InputError (without a place) when they are not there.
std::string vtu_array_bytes(std::string_view source, bool is_base64, const VtuEncoding& encoding, std::size_t most);

/// By VTK's name of the type, "Float64"; its size is 0 when there is no such type.
NumberType vtu_type(std::string_view name);

std::vector<double> values_of(std::string_view bytes, const NumberType& type, std::endian order);

}  // namespace kt
