#pragma once
// A device maker's library, loaded when a device is opened: nothing of it is needed to build or to run without one.
#include <string>
#include <vector>

#include "core/base/error.hpp"

namespace kt {

/// Loaded, and never unloaded: such libraries start threads of their own.
class VendorLibrary {
 public:
  /// Loads `file`, or, when that is empty, the first of the usual names that is there. Throws InputError: what was
  /// tried, why it failed, and the key that names another file.
  VendorLibrary(std::string device, const std::string& file, const std::vector<std::string>& usual);

  /// Points `function` to the library's function of that name; what is missing is said by check().
  template <class Function>
  void find(Function*& function, const char* name) {
    function = reinterpret_cast<Function*>(address(name));
  }
  /// The same of a function that some versions lack: null then.
  template <class Function>
  void find_if_there(Function*& function, const char* name) {
    const std::size_t known = missing_.size();
    find(function, name);
    missing_.resize(known);
  }
  /// Throws InputError with the first names that were not there.
  void check() const;

  const std::string& file() const { return file_; }

 private:
  void* address(const char* name);

  std::string device_, file_;
  void* library_ = nullptr;
  std::vector<std::string> missing_;
};

}  // namespace kt
