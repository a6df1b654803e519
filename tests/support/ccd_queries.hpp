#pragma once
// Files of collision queries, in the format of the continuous-collision benchmark's exact truths (docs/collision.md).
#include <array>
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

struct CcdQueries {
  enum class Kind { vertex_face, edge_edge } kind = Kind::vertex_face;
  /// Four points at the start, then at the end: vertex and face, or edge a and edge b.
  std::vector<std::array<Vec3, 8>> points;
  std::vector<char> collides;  ///< 1: at some time of the closed step

  struct ExactTime {
    bool is_known = false;
    double toi = 0;  ///< rounded down
  };
  std::vector<ExactTime> times;  ///< empty where there is no file PATH.oracle
};

/// Reads PATH and, where there is one, PATH.oracle. Throws InputError: what is wrong, where, and what is allowed.
CcdQueries load_ccd_queries(const std::string& path);

}  // namespace kt
