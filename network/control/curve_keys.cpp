#include "network/control/curve_keys.hpp"

#include <fcntl.h>
#include <sodium.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr std::size_t kKeyText = 40;
constexpr mode_t kForAll = 0644, kForOwner = 0600;

std::string public_file(const std::string& dir) { return dir + "/public.key"; }
std::string secret_file(const std::string& dir) { return dir + "/secret.key"; }

/// Writes a file that must not be there yet.
void write_new(const std::string& file, const std::string& content, mode_t mode) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (descriptor < 0)
    throw InputError(errno == EEXIST ? text(file, " is there already; a key is never replaced: take another folder")
                                     : text(file, ": cannot be written: ", std::strerror(errno)));
  const bool written = ::write(descriptor, content.data(), content.size()) == static_cast<ssize_t>(content.size());
  if (::close(descriptor) != 0 || !written) {
    ::unlink(file.c_str());
    throw InputError(text(file, ": cannot be written"));
  }
}

/// Who may write there may exchange a key, or add one.
void require_own(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !(status.st_mode & (S_IWGRP | S_IWOTH))) return;
  throw InputError(text(path, ": others may write there, and exchange a key; make it yours alone: chmod go-w ", path));
}

std::ifstream open_file(const std::string& file) {
  std::ifstream in(file);
  if (!in || !std::filesystem::is_regular_file(file)) throw InputError(text(file, ": cannot be read"));
  return in;
}

/// The first word of a file.
std::string read_word(const std::string& file) {
  std::ifstream in = open_file(file);
  std::string word;
  in.width(kKeyText + 1);
  in >> word;
  return word;
}

}  // namespace

CurveKey new_curve_key() {
  std::array<char, kKeyText + 1> open{}, secret{};
  do  // of a key that begins with # or - it would be hard to tell whether it is one, in a file and on a command line
    if (::zmq_curve_keypair(open.data(), secret.data()) != 0) throw RunError("this ZeroMQ library has no CURVE");
  while (open[0] == '#' || open[0] == '-' || secret[0] == '#');
  CurveKey key{open.data(), secret.data()};
  sodium_memzero(secret.data(), secret.size());
  return key;
}

void make_key(const std::string& dir) {
  std::error_code error;
  if (std::filesystem::create_directories(dir, error))
    std::filesystem::permissions(dir, std::filesystem::perms::owner_all, error);
  if (error) throw InputError(text(dir, ": cannot be made: ", error.message()));
  require_own(dir);
  const CurveKey key = new_curve_key();
  if (std::filesystem::exists(public_file(dir)))
    throw InputError(text(public_file(dir), " is there already; a key is never replaced: take another folder"));
  write_new(secret_file(dir), key.secret_key + "\n", kForOwner);
  write_new(public_file(dir), key.public_key + "\n", kForAll);
}

CurveKey read_key(const std::string& dir) {
  struct stat status {};
  if (::stat(secret_file(dir).c_str(), &status) != 0)
    throw InputError(text(secret_file(dir), ": ", std::strerror(errno), "; make a key with: kilotouch key new ", dir));
  if (status.st_mode & (S_IRWXG | S_IRWXO))
    throw InputError(text(secret_file(dir), ": others may read or write it; make it yours alone: chmod 600"));
  require_own(dir);
  require_own(public_file(dir));
  const CurveKey key{read_word(public_file(dir)), read_word(secret_file(dir))};
  for (const auto& [file, one] :
       {std::pair{public_file(dir), key.public_key}, std::pair{secret_file(dir), key.secret_key}})
    if (!is_curve_key(one)) throw InputError(text(file, ": no key; must be 40 characters of Z85"));
  std::array<char, kKeyText + 1> derived{};
  if (::zmq_curve_public(derived.data(), key.secret_key.c_str()) != 0 || key.public_key != derived.data())
    throw InputError(text(dir, ": public.key and secret.key are not a pair"));
  return key;
}

bool is_curve_key(const std::string& key) {
  std::array<std::uint8_t, 32> bytes{};
  return key.size() == kKeyText && key.find('\0') == std::string::npos && ::zmq_z85_decode(bytes.data(), key.c_str());
}

std::string read_public_key(const std::string& key_or_file, const std::string& what) {
  if (is_curve_key(key_or_file)) return key_or_file;
  if (!std::filesystem::is_regular_file(key_or_file))
    throw InputError(
        text(what, ": ", key_or_file, " is neither a public key (40 characters of Z85) nor a file with one"));
  require_own(key_or_file);
  const std::string key = read_word(key_or_file);
  if (!is_curve_key(key)) throw InputError(text(what, ": ", key_or_file, ": no key; must be 40 characters of Z85"));
  return key;
}

std::vector<std::string> read_authorized(const std::string& file) {
  std::ifstream in = open_file(file);
  require_own(file);
  std::vector<std::string> keys;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos) continue;
    const std::string word = line.substr(begin, line.find_first_of(" \t\r", begin) - begin);
    if (is_curve_key(word))  // a key may hold #
      keys.push_back(word);
    else if (word[0] != '#')
      throw InputError(
          text(file, ":", number, ": no key; a line is a public key (40 characters of Z85) or begins with #"));
  }
  return keys;
}

}  // namespace kt
