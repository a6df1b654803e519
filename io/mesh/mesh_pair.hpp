#pragma once
#include <string>

namespace kt {

/// The file that load_mesh() reads beside this one: of x.node x.ele, of x.ele x.node, of others none (empty).
std::string other_of_pair(const std::string& path);

}  // namespace kt
