#pragma once
// Files that appear whole or not at all, and numbers that read back bit for bit.
#include <string>
#include <string_view>

namespace kt {

/// Writes beside `path` under a temporary name, then renames: a reader, a crash or a full disk never sees half a file.
/// @throws InputError naming the file and the reason.
void write_file_whole(const std::string& path, std::string_view content);

/// Throws InputError unless the folder that `path` lies in is there: to be asked before long work, not after it.
void require_folder_of(const std::string& path);

/// Makes the folder and those above it. @throws InputError naming the folder and the reason.
void make_folder(const std::string& path);

/// Shortest decimal text that reads back as exactly this double.
void append_number(std::string& out, double value);

}  // namespace kt
