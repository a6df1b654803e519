#include "core/base/temporary_folder.hpp"

#include <cstdlib>
#include <filesystem>

#include "core/base/error.hpp"

namespace kt {

std::string temporary_folder(const std::string& usual) {
  const char* const named = std::getenv("TMPDIR");
  const bool is_named = named && *named;
  std::string out = is_named ? named : usual;
  std::error_code none;
  if (!std::filesystem::is_directory(out, none))
    throw InputError(text(is_named ? "TMPDIR is \"" + out + "\", which" : out,
                          " is no folder; set the variable TMPDIR to one "
                          "where temporary files can be written"));
  return out;
}

}  // namespace kt
