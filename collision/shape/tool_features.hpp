#pragma once
// The parts of a tool's core that can be the first to touch. A mesh has many that cannot: corners and edges within a
// flat side, corners along a straight edge.
#include <array>
#include <vector>

#include "collision/shape/contact.hpp"

namespace kt {

struct ToolFeatures {
  std::vector<int> corners;               ///< by number in ToolShape::corners; one of those in the same place
  std::vector<std::array<int, 2>> edges;  ///< straight, whole, each once: by the corners at their ends
  /// Of each triangle: its side goes on beyond edge i (bit i), and around corner i (bit 3 + i).
  std::vector<unsigned char> goes_on;
};

/// Corners in the same place count as one, so that triangles meet though a file lists corners anew for each. Left out
/// is only what lies in the plane of its neighbours, or on their line, to 1e-10 of an edge: what the others say about
/// it is as exact.
ToolFeatures find_tool_features(const ToolShape& shape);

}  // namespace kt
