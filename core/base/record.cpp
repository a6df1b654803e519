#include "core/base/record.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr std::size_t kPage = std::size_t{64} << 10;   // of 4, 16 or 64 KiB: a multiple of each
constexpr std::size_t kGrows = std::size_t{32} << 20;  // a file, at a time

[[noreturn]] void fail(const std::string& where, int error) {
  throw RunError(text("records: ", where, ": ", std::strerror(error), "; what was recorded until now is kept"));
}

/// Open for as long as somebody has its number: no name is left behind, however the process ends.
int open_without_name(const std::string& folder) {
  int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0) return file;
  std::string name = folder + "/kilotouch-records-XXXXXX";  // a file system without such files
  file = ::mkostemp(name.data(), O_CLOEXEC);
  if (file < 0) fail(folder, errno);
  ::unlink(name.c_str());
  return file;
}

}  // namespace

std::string RecordBytes::folder() {
  const char* const named = std::getenv("TMPDIR");
  return named && *named ? named : "/var/tmp";  // on a disk, where /tmp may be memory
}

RecordBytes& RecordBytes::operator=(RecordBytes&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(room_, other.room_);
  std::swap(file_, other.file_);
  return *this;
}

RecordBytes::~RecordBytes() {
  if (data_) ::munmap(data_, room_);
  if (file_ >= 0) ::close(file_);
}

void RecordBytes::make_room(std::size_t bytes) {
  if (bytes <= room_) return;
  if (bytes <= kInMemory) {
    const std::size_t room = std::max(bytes, std::min(2 * room_, kInMemory));
    const std::size_t pages = (room + kPage - 1) / kPage * kPage;
    void* const grown = data_ ? ::mremap(data_, room_, pages, MREMAP_MAYMOVE)
                              : ::mmap(nullptr, pages, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (grown == MAP_FAILED) fail("memory", errno);
    data_ = grown;
    room_ = pages;
    return;
  }
  const std::size_t room = (bytes + kGrows - 1) / kGrows * kGrows;
  const int file = file_ >= 0 ? file_ : open_without_name(folder());
  // A page that the disk has no place for would end the process when it is written to.
  int error = ::posix_fallocate(file, 0, static_cast<off_t>(room));
  void* grown = MAP_FAILED;
  if (error == 0) {
    grown = file_ >= 0 ? ::mremap(data_, room_, room, MREMAP_MAYMOVE)
                       : ::mmap(nullptr, room, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    error = errno;
  }
  if (grown == MAP_FAILED) {
    if (file_ < 0) ::close(file);
    fail(folder(), error);
  }
  if (file_ < 0 && data_) {
    std::memcpy(grown, data_, room_);
    ::munmap(data_, room_);
  } else if (file_ >= 0 && room_ > kGrows) {
    // Written and seldom read again: it need not be counted as this process's memory.
    ::madvise(grown, room_ - kGrows, MADV_DONTNEED);
  }
  ::munlock(grown, room);  // where all memory is locked
  data_ = grown;
  room_ = room;
  file_ = file;
}

}  // namespace kt
