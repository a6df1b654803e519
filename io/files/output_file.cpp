#include "io/files/output_file.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include "core/base/error.hpp"
#include "io/files/leftovers.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw InputError(text(path, ": cannot be written: ", why));
}

/// An open file; `close` says whether all of it has arrived.
class OpenFile {
 public:
  OpenFile(std::string path, int file) : path_(std::move(path)), file_(file) {
    if (file_ < 0) fail(path_, std::strerror(errno));
  }
  ~OpenFile() {
    if (file_ >= 0) ::close(file_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  void write(std::string_view content) {
    while (!content.empty()) {
      const ssize_t n = ::write(file_, content.data(), content.size());
      if (n < 0 && errno != EINTR) fail(path_, std::strerror(errno));
      if (n > 0) content.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  /// To the disk: a full one says so here at the latest.
  void sync() {
    if (::fsync(file_) != 0 && errno != EINVAL && errno != EROFS) fail(path_, std::strerror(errno));
  }
  void close() {
    if (::close(std::exchange(file_, -1)) != 0) fail(path_, std::strerror(errno));
  }
  int number() const { return file_; }

 private:
  std::string path_;
  int file_;
};

/// Beside `path`, in a name of chance.
std::string temporary_name(const std::string& path) {
  std::uint64_t chance = 0;
  if (::getrandom(&chance, sizeof chance, 0) != sizeof chance) fail(path, std::strerror(errno));
  char name[40];
  std::snprintf(name, sizeof name, ".kilotouch-%016" PRIx64, chance);
  return (fs::path(path).parent_path() / name).string();
}

/// Never one that is there already: it could be a link that somebody has laid.
int open_new(const std::string& path) { return ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); }

void write_parts(OpenFile& file, const Parts& next) {
  for (std::string part; next(part);) file.write(part);
}

Parts in_one(std::string_view content) {
  return [content, is_told = false](std::string& part) mutable {
    if (is_told) return false;
    part = content;
    return is_told = true;
  };
}

/// Opens a pipe without waiting for ever for somebody who reads it.
int open_pipe(const std::string& path) {
  constexpr int kTries = 100;
  for (int i = 0;; ++i) {
    const int file = ::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    if (file >= 0) ::fcntl(file, F_SETFL, 0);  // from now on a slow reader is waited for
    if (file >= 0 || errno != ENXIO) return file;
    if (i == kTries) fail(path, "it is a pipe that nobody reads");
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

/// The file is where this process's own output goes: a new file in its place would lose what was printed.
int own_output(const struct stat& file) {
  for (const int number : {1, 2}) {
    struct stat own {};
    if (::fstat(number, &own) == 0 && own.st_dev == file.st_dev && own.st_ino == file.st_ino) return number;
  }
  return -1;
}

void require_kind(const std::string& path, const struct stat& file) {
  if (S_ISDIR(file.st_mode)) throw InputError(text(path, ": is a directory, cannot be written"));
  if (S_ISBLK(file.st_mode)) throw InputError(text(path, ": is a disk, not a file, and is not written to"));
  if (S_ISSOCK(file.st_mode)) throw InputError(text(path, ": is a socket, not a file, and cannot be written"));
}

/// A file beside `path`: one block of the disk, and gone again.
void try_beside(const std::string& path, const std::string& told) {
  constexpr std::size_t kBlock = 4096;  // [bytes]
  const Leftover temporary(temporary_name(path));
  OpenFile file(told, open_new(temporary.path()));
  file.write(std::string(kBlock, '\0'));
  file.sync();
  file.close();
}

}  // namespace

std::string follow_links(const std::string& path) {
  fs::path at = path;
  std::error_code none;
  constexpr int kMost = 40;  // as Linux
  for (int i = 0; fs::is_symlink(fs::symlink_status(at, none)); ++i) {
    if (i == kMost) fail(path, "too many links, one after the other");
    at = at.parent_path() / fs::read_symlink(at, none);
  }
  return at.string();
}

PendingFile::PendingFile(std::string path, const Parts& next)
    : path_(std::move(path)), temporary_(temporary_name(path_)) {
  struct stat old {};
  const bool is_file = ::lstat(path_.c_str(), &old) == 0 && S_ISREG(old.st_mode);
  OpenFile file(path_, open_new(temporary_.path()));
  write_parts(file, next);
  if (is_file) ::fchmod(file.number(), old.st_mode & 07777);
  file.sync();
  file.close();
}

void PendingFile::commit() {
  require_result_place(path_);
  if (::rename(temporary_.path().c_str(), path_.c_str()) != 0) fail(path_, std::strerror(errno));
  temporary_.keep();
}

void write_file_whole(const std::string& path, std::string_view content) { write_file_whole(path, in_one(content)); }

void write_file_whole(const std::string& path, const Parts& next) {
  require_result_place(path);
  PendingFile(path, next).commit();
}

void write_named_file(const std::string& path, std::string_view content) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return write_file_whole(follow_links(path), content);
  require_kind(path, found);
  if (const int number = own_output(found); number >= 0) {
    OpenFile own(path, ::fcntl(number, F_DUPFD_CLOEXEC, 0));
    own.write(content);
  } else if (S_ISREG(found.st_mode)) {
    write_file_whole(follow_links(path), content);
  } else {
    OpenFile device(path,
                    S_ISFIFO(found.st_mode) ? open_pipe(path) : ::open(path.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC));
    device.write(content);
    device.close();
  }
}

void require_result_place(const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0 || S_ISREG(found.st_mode) || S_ISLNK(found.st_mode)) return;
  require_kind(path, found);
  throw InputError(text(path, ": is a ", S_ISFIFO(found.st_mode) ? "pipe" : "device",
                        ", where a file of the results goes; remove it, or give another folder"));
}

void require_writable(const std::string& path) {
  if (path.empty() || path == "-") return;
  struct stat found {};
  if (::stat(path.c_str(), &found) == 0) {
    require_kind(path, found);
    if (!S_ISREG(found.st_mode) || own_output(found) >= 0) return;  // written to as it is
  }
  const std::string place = follow_links(path);
  const fs::path folder = fs::path(place).parent_path();
  if (!folder.empty() && !fs::is_directory(folder))
    throw InputError(text(path, ": there is no folder ", folder.string()));
  try_beside(place, path);
}

void require_writable_folder(const std::string& path, const std::string& told) {
  std::error_code none;
  fs::path folder = path;
  while (!folder.empty() && !fs::exists(fs::symlink_status(folder, none))) folder = folder.parent_path();
  if (folder.empty()) folder = ".";
  if (!fs::is_directory(folder, none))
    throw InputError(text(told, ": cannot make the folder: ", folder.string(), " is not a folder"));
  try_beside(folder / "x", told);
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw InputError(text(path, ": cannot make the folder: ", error.message()));
}

void make_inner_folder(const std::string& path) {
  if (::mkdir(path.c_str(), 0777) == 0) return;
  struct stat found {};
  if (errno == EEXIST && ::lstat(path.c_str(), &found) == 0) {
    if (S_ISDIR(found.st_mode)) return;
    throw InputError(text(path, ": is ", S_ISLNK(found.st_mode) ? "a link" : "a file",
                          ", where a folder of the results goes; remove it, or give another folder"));
  }
  throw InputError(text(path, ": cannot make the folder: ", std::strerror(errno)));
}

void append_number(std::string& out, double value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  out.append(buffer, result.ptr);
}

}  // namespace kt
