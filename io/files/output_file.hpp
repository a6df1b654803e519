#pragma once
// Files that appear whole or not at all, and numbers that read back bit for bit.
#include <functional>
#include <string>
#include <string_view>

#include "io/files/leftovers.hpp"

namespace kt {

/// Content in parts, for what need not be in memory at once: sets the next part, or returns false when there is none.
using Parts = std::function<bool(std::string&)>;

/// Written beside `path` under a name that nobody can guess, to the disk. It takes its place when it is committed, else
/// it is gone: a reader, a crash or a full disk never sees half of it.
class PendingFile {
 public:
  /// @throws InputError naming the file and the reason
  PendingFile(std::string path, const Parts& next);
  void commit();

 private:
  std::string path_;
  Leftover temporary_;
};

/// A file of ours, new or old, as PendingFile. A link in its place is replaced and never followed: whoever may write to
/// the folder could have laid it. What is neither file nor link is refused.
/// @throws InputError naming the file and the reason.
void write_file_whole(const std::string& path, std::string_view content);
void write_file_whole(const std::string& path, const Parts& next);

/// A file that the user has named, as --json: a link stays a link, and what it points at is written whole. A device or
/// a pipe is written to and never replaced; a pipe that nobody reads is refused after a while.
void write_named_file(const std::string& path, std::string_view content);

/// Where a link leads, over all links; the path itself where it is none. @throws InputError for a ring of links
std::string follow_links(const std::string& path);

// To be asked before long work, not after it. All throw InputError with the reason.
/// A file that the user has named can be written, tried by a file beside it: rights, a full disk, one that is only
/// read.
void require_writable(const std::string& path);
/// The folder, or the nearest one above that is there, takes files.
/// @param told  names it in the message
void require_writable_folder(const std::string& path, const std::string& told);
/// No folder, pipe or device lies where write_file_whole() is to put a file.
void require_result_place(const std::string& path);

/// Makes the folder and those above it. @throws InputError naming the folder and the reason.
void make_folder(const std::string& path);
/// One folder inside a folder of results. @throws InputError also for a link in its place, which could lead elsewhere.
void make_inner_folder(const std::string& path);

/// Shortest decimal text that reads back as exactly this double.
void append_number(std::string& out, double value);

}  // namespace kt
