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

using Parts = std::function<bool(std::string&)>;

void write_parts(OpenFile& file, const Parts& next) {
  for (std::string part; next(part);) file.write(part);
}

void replace_file(const std::string& path, const Parts& next) {
  struct stat old {};
  const bool is_there = ::stat(path.c_str(), &old) == 0;
  Leftover temporary(temporary_name(path));
  // Never one that is there already: it could be a link that somebody has laid.
  OpenFile file(path, ::open(temporary.path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  write_parts(file, next);
  if (is_there) ::fchmod(file.number(), old.st_mode & 07777);
  file.sync();
  file.close();
  if (::rename(temporary.path().c_str(), path.c_str()) != 0) fail(path, std::strerror(errno));
  temporary.keep();
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

/// What a link points at, also when that is not there yet.
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

}  // namespace

void write_file_whole(const std::string& path, std::string_view content) {
  bool is_told = false;
  write_file_whole(path, [&](std::string& part) {
    if (is_told) return false;
    part = content;
    return is_told = true;
  });
}

void write_file_whole(const std::string& path, const std::function<bool(std::string&)>& next) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) return replace_file(follow_links(path), next);
  require_kind(path, found);
  if (const int number = own_output(found); number >= 0) {
    OpenFile own(path, ::fcntl(number, F_DUPFD_CLOEXEC, 0));
    write_parts(own, next);
  } else if (S_ISREG(found.st_mode)) {
    replace_file(follow_links(path), next);
  } else {
    OpenFile device(path,
                    S_ISFIFO(found.st_mode) ? open_pipe(path) : ::open(path.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC));
    write_parts(device, next);
    device.close();
  }
}

void require_folder_of(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  if (!folder.empty() && !fs::is_directory(folder))
    throw InputError(text(path, ": there is no folder ", folder.string()));
  struct stat found {};
  if (!path.empty() && ::stat(path.c_str(), &found) == 0) require_kind(path, found);
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw InputError(text(path, ": cannot make the folder: ", error.message()));
}

void append_number(std::string& out, double value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  out.append(buffer, result.ptr);
}

}  // namespace kt
