#include "io/files/file_claim.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <functional>
#include <utility>

#include "core/base/error.hpp"
#include "io/files/output_file.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

/// The same for each way that leads to the file; empty: it is none that is claimed.
std::string key_of(const std::string& path) {
  struct stat found {};
  if (path.empty() || path == "-" || (::stat(path.c_str(), &found) == 0 && !S_ISREG(found.st_mode))) return {};
  const fs::path place = follow_links(path);
  const fs::path folder = place.has_parent_path() ? place.parent_path() : fs::path(".");
  if (::stat(folder.c_str(), &found) != 0) return {};
  return text("kilotouch writes ", ::getuid(), ' ', found.st_dev, ' ', found.st_ino, ' ',
              std::hash<std::string>{}(place.filename().string()));
}

}  // namespace

FileClaim::FileClaim(const std::string& path, const std::string& told) {
  const std::string key = key_of(path);
  sockaddr_un name{};
  if (key.empty() || key.size() + 1 > sizeof name.sun_path) return;
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path + 1, key.data(), key.size());  // a first byte of zero: a name in no file system
  socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + key.size());
  if (socket_ < 0 || ::bind(socket_, reinterpret_cast<const sockaddr*>(&name), size) == 0 || errno != EADDRINUSE)
    return;
  ::close(socket_);
  throw InputError(text(told, ": another kilotouch is writing to it; wait for its end, or give another file"));
}

FileClaim::FileClaim(FileClaim&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}

FileClaim::~FileClaim() {
  if (socket_ >= 0) ::close(socket_);
}

}  // namespace kt
