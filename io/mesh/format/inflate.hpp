#pragma once
#include <string>
#include <string_view>

namespace kt {

/// Appends what zlib compressed to `out`. Defined in inflate_zlib.cpp: call only when KT_WITH_ZLIB.
/// @param size  bytes that must come out, no more and no less
/// @throws InputError (without a place) when it is no such data.
void append_inflated(std::string_view compressed, std::size_t size, std::string& out);

}  // namespace kt
