#pragma once
// The files of the page, embedded when the program was built.
#include <span>
#include <string_view>

namespace kt {

struct PageFile {
  std::string_view path;  ///< "/live.js"
  std::string_view type;  ///< "text/javascript"
  std::string_view content;
};

std::span<const PageFile> page_files();

}  // namespace kt
