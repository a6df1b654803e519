#pragma once
// A family of backends is a .def table: one line a backend. `kilotouch list`, the factories and the conformance tests
// all read that one table, so a new backend is one file and one line. Each defines FAMILY before it includes the table,
// whose last line undefines it.
//   FAMILY(name, available, "option that turns it on", "what it is")     available: 1, or a KT_WITH_... macro (0 or 1)
#include <string>
#include <vector>

#include "core/base/error.hpp"

namespace kt {

struct BackendInfo {
  std::string name, what;
  bool available = true;
  std::string option;  ///< the CMake option that turns it on, when it can be off
  bool operator==(const BackendInfo&) const = default;
};

/// Throws InputError unless `name` is in the table and available: names the known ones, or the option to turn on.
inline void require_backend(const std::string& family, const std::string& name, const std::vector<BackendInfo>& table) {
  std::vector<std::string> known;
  for (const BackendInfo& b : table) {
    if (b.name == name && !b.available)
      throw InputError(text(family, " \"", name, "\" is not in this build: configure with -D", b.option, "=ON"));
    if (b.name == name) return;
    known.push_back(b.name);
  }
  throw_unknown(family, name, known);
}

}  // namespace kt
