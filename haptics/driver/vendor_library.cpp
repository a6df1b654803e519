#include "haptics/driver/vendor_library.hpp"

#include <dlfcn.h>

namespace kt {

VendorLibrary::VendorLibrary(std::string device, const std::string& file, const std::vector<std::string>& usual)
    : device_(std::move(device)) {
  std::vector<std::string> reasons;
  for (const std::string& name : file.empty() ? usual : std::vector<std::string>{file}) {
    library_ = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (library_) {
      file_ = name;
      return;
    }
    reasons.push_back(dlerror());  // begins with the file
  }
  throw InputError(text("tool.path.device: ", device_, ": ", join(reasons),
                        "; install the maker's driver, or name its file in tool.path.device.library"));
}

void VendorLibrary::check() const {
  if (missing_.empty()) return;
  constexpr std::size_t kNamed = 3;
  const std::size_t named = std::min(missing_.size(), kNamed);
  throw InputError(text("tool.path.device: ", device_, ": ", file_, " is of another version: it has no ",
                        join({missing_.begin(), missing_.begin() + static_cast<long>(named)}),
                        missing_.size() > named ? text(" and ", missing_.size() - named, " more") : "",
                        "; name another file in tool.path.device.library"));
}

void* VendorLibrary::address(const char* name) {
  void* const found = dlsym(library_, name);
  if (!found) missing_.push_back(name);
  return found;
}

}  // namespace kt
