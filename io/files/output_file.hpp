#pragma once
// Files that appear whole or not at all, and numbers that read back bit for bit.
#include <functional>
#include <string>
#include <string_view>

namespace kt {

/// A file, new or old: written beside `path` under a name that nobody can guess, to the disk, then renamed; a reader, a
/// crash or a full disk never sees half of it. A link stays a link: what it points at is written. A device or a pipe is
/// written to and never replaced; a pipe that nobody reads is refused after a while.
/// @throws InputError naming the file and the reason.
void write_file_whole(const std::string& path, std::string_view content);
/// The same in parts, for what need not be in memory at once.
/// @param next  sets the part that comes next, and returns false when there is none
void write_file_whole(const std::string& path, const std::function<bool(std::string&)>& next);

/// Throws InputError unless the folder that `path` lies in is there, and `path` is no folder, disk or socket: to be
/// asked before long work, not after it.
void require_folder_of(const std::string& path);

/// Makes the folder and those above it. @throws InputError naming the folder and the reason.
void make_folder(const std::string& path);

/// Shortest decimal text that reads back as exactly this double.
void append_number(std::string& out, double value);

}  // namespace kt
