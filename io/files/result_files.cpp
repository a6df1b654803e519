#include "io/files/result_files.hpp"

#include <filesystem>

namespace kt {

void ResultFiles::add(const std::string& name, const Parts& next) {
  const std::string path = folder_ + '/' + name;
  require_result_place(path);
  files_.emplace_back(path, next);
}

void ResultFiles::add(const std::string& name, const std::string& content) {
  add(name, [&content, is_told = false](std::string& part) mutable {
    if (is_told) return false;
    part = content;
    return is_told = true;
  });
}

void ResultFiles::commit() {
  for (PendingFile& file : files_) file.commit();
  std::error_code none;
  for (const std::string& path : dropped_)
    if (!std::filesystem::is_directory(path, none)) std::filesystem::remove(path, none);
}

}  // namespace kt
