#pragma once
// Narrow phase with a thickness: the first time at which two features come within a distance of each other. A sphere is
// a vertex with its radius, a capsule an edge with its radius and its two ends, a thick sheet its triangles.
#include "core/types.hpp"

namespace kt {

struct OffsetToi {
  enum class Status : unsigned char {
    none,
    hit,
    already_inside,
    invalid_input,
    budget_exhausted
  } status = Status::none;
  double toi = 1;  ///< fraction of the step, never later than the true time
  bool is_contact() const noexcept { return status != Status::none && status != Status::invalid_input; }
};

/// First time in [0, 1] at which vertex x[0] is no further than `distance` from the face x[1], x[2], x[3].
/// Conservative: never late, never a miss; what rounding leaves open is a hit. distance: >= 0, same unit and range as
/// the coordinates (collision/toi.hpp, whose exact mode is the one to use for a distance of 0). No allocation, no
/// exception.
OffsetToi vertex_face_offset_toi(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], double distance) noexcept;

/// The same for the edges x[0], x[1] and x[2], x[3].
OffsetToi edge_edge_offset_toi(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], double distance) noexcept;

}  // namespace kt
