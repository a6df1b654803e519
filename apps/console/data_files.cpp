#include "apps/console/data_files.hpp"

#include <system_error>

namespace kt {

namespace fs = std::filesystem;

fs::path find_data(const fs::path& name) {
  std::error_code none;
  const fs::path source = KT_SOURCE_DATA, self = fs::read_symlink("/proc/self/exe", none);
  if (!source.empty())
    for (const fs::path& folder : {source, source / "scripts"})
      if (fs::exists(folder / name, none)) return folder / name;
  const fs::path installed = (self.parent_path() / "../share/kilotouch" / name).lexically_normal();
  return fs::exists(installed, none) ? installed : fs::path();
}

}  // namespace kt
