#pragma once
// How the two rates are joined. Table: link/link.def; each way is one session_<name>.cpp.
#include <vector>

#include "core/base/backend.hpp"

namespace kt {

std::vector<BackendInfo> link_backends();

}  // namespace kt
