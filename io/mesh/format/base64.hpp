#pragma once
#include <string>
#include <string_view>

namespace kt {

/// The first bytes that base64 text stands for, `most` at most, up to the first character that is none. It may be
/// padded in the middle, where one stream ends and the next begins; blanks are skipped.
std::string from_base64(std::string_view in, std::size_t most);

/// Padded, in one line.
std::string to_base64(std::string_view bytes);

}  // namespace kt
