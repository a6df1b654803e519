#pragma once
// Files that appear whole or not at all, and numbers that read back bit for bit.
#include <string>
#include <string_view>

namespace kt {

/// Writes beside `path` under a temporary name, then renames: a reader, a crash or a full disk never sees half a file.
/// @throws InputError naming the file and the reason.
void write_file_whole(const std::string& path, std::string_view content);

/// Shortest decimal text that reads back as exactly this double.
void append_number(std::string& out, double value);

}  // namespace kt
