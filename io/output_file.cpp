#include "io/output_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "core/error.hpp"

namespace kt {

void write_file_whole(const std::string& path, std::string_view content) {
  if (std::filesystem::is_directory(path)) throw InputError(text(path, ": is a directory, cannot be written"));
  const std::string temporary = text(path, ".tmp", ::getpid());
  std::FILE* file = std::fopen(temporary.c_str(), "wb");
  if (!file) throw InputError(text(path, ": cannot be written: ", std::strerror(errno)));
  bool good = std::fwrite(content.data(), 1, content.size(), file) == content.size();
  good = std::fclose(file) == 0 && good;
  good = good && std::rename(temporary.c_str(), path.c_str()) == 0;
  if (!good) {
    const std::string reason = std::strerror(errno);
    std::remove(temporary.c_str());
    throw InputError(text(path, ": cannot be written: ", reason));
  }
}

void require_folder_of(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder))
    throw InputError(text(path, ": there is no folder ", folder.string()));
}

void make_folder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw InputError(text(path, ": cannot make the folder: ", error.message()));
}

void append_number(std::string& out, double value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  out.append(buffer, result.ptr);
}

}  // namespace kt
