#include "io/files/output_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/base/error.hpp"
#include "io/files/output_file.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

/// Of the folder itself: no file of a lock is left behind. Given up with the descriptor, however the process ends.
int lock_folder(const std::string& path, const std::string& told, FolderUse use) {
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) throw InputError(text(told, ": cannot be opened: ", std::strerror(errno)));
  if (::flock(folder, (use == FolderUse::alone ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0 || errno != EWOULDBLOCK)
    return folder;  // some network file systems lock no folder
  ::close(folder);
  throw InputError(
      text(told, ": another kilotouch is writing its results there; wait for its end, or give another folder"));
}

}  // namespace

OutputFolder::Made::Made(const std::string& path) {
  std::error_code none;
  for (fs::path at = fs::absolute(path); !fs::exists(at, none) && at.has_relative_path(); at = at.parent_path())
    if (at.has_filename()) folders.push_back(at);  // not of "DIR/"
  make_folder(path);
}

OutputFolder::Made::~Made() {
  std::error_code none;
  for (const fs::path& folder : folders) fs::remove(folder, none);  // while it is empty
}

OutputFolder::OutputFolder(const std::string& path, const std::string& told, const std::vector<std::string>& names,
                           FolderUse use)
    : made_(path), lock_(lock_folder(path, told, use)) {
  try {
    require_writable_folder(path, told);
    for (const std::string& name : names) require_result_place(path + '/' + name);
  } catch (...) {
    ::close(lock_);
    throw;
  }
}

OutputFolder::~OutputFolder() { ::close(lock_); }

}  // namespace kt
