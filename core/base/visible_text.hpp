#pragma once
// Text of others (file names, file content, words of libraries) in one line of ours: nothing in it may break the line,
// steer a terminal or turn the reading direction.
#include <string>
#include <string_view>

namespace kt {

/// Control characters as \n or \x1b, those beyond ASCII (C1, line and paragraph separators, marks of direction, zero
/// widths) as \u2028, bytes that are not UTF-8 as \xff. All else, backslashes too, stays.
std::string visible(std::string_view text);

constexpr std::size_t kLongestLine = 400;  ///< [bytes]

/// What somebody else has said, for a log: visible, and cut where it is too long. Never two lines, never a flood.
std::string one_line(std::string_view text, std::size_t most = kLongestLine);

/// As visible(), for a text of several lines: line ends and tabs stay.
std::string visible_lines(std::string_view text);

/// A file's name, which may be any bytes, as UTF-8 from which unescape_bytes() has the bytes back: those that are not
/// UTF-8 become \xff. A name that is UTF-8 stays, but for a backslash that would read as such an escape (\x5cxff).
std::string escape_bytes(std::string_view name);
std::string unescape_bytes(std::string_view name);

}  // namespace kt
