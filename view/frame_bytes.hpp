#pragma once
// What goes to a page many times a second, as bytes: little-endian, fields one after another as the page's reader
// (page/frame.js) takes them.
#include <span>
#include <string>
#include <vector>

#include "haptics/halves/touch_status.hpp"
#include "haptics/tick/local_frame.hpp"
#include "view/body_shape.hpp"

namespace kt {

/// One tick of the first tool, for the plot.
struct TickForce {
  float f_n = 0, f_t = 0;
  ContactMode mode = ContactMode::free;
};

/// Positions in 65,536 steps of the box around them: an error of at most 1 / 131,070 of its edge.
struct PackedPositions {
  std::array<float, 3> least{}, step{};
  std::vector<std::uint16_t> x;  ///< (3n)
};
PackedPositions pack_positions(const VectorX& x, const std::vector<int>& nodes);

struct PageFrame {
  double t = 0;       ///< [s]
  unsigned echo = 0;  ///< number of the last pointer message
  double stamp = 0;   ///< the time that was in it [ms], the page's clock
  int refreshes = 0;
  Vec3 target = Vec3::Zero();  ///< of the first tool's hand [m]
  std::span<const LocalFrame> tools{};
  std::span<const TickForce> ticks{};  ///< since the frame before
  const PackedPositions* positions = nullptr;
};

/// Type 1.
std::string frame_bytes(const PageFrame& frame);

/// Type 2: the surface at rest and its clamped nodes, once.
std::string body_bytes(const BodyShape& shape, const VectorX& x_rest);

/// Type 3: patch, error and refined cells of the last refresh.
std::string refresh_bytes(const RefreshPicture& picture, const BodyShape& shape);

/// Type 4: every tick of a session, for its time line.
std::string trace_bytes(double h, std::span<const TickForce> ticks);

}  // namespace kt
