#pragma once
// Narrow phase for any two meshes: the first time at which a vertex touches a face, or an edge an edge, while all their
// points move on straight lines over the step. Two-sided and without conditions on the direction: do they touch at any
// time of the closed interval [0, 1]? (collision/impact/tool_impact.hpp answers for a tool and a body with an outside.)
// Method and derivation of the bounds: docs/collision.md.
#include "core/base/types.hpp"

namespace kt {

enum class ToiMode {
  conservative,  ///< what rounding leaves open is a hit, at the lower end of the times that it leaves open
  exact          ///< what rounding leaves open is decided in exact arithmetic, to 2^-56 of the step
};

/// Part of one of the two that touch.
struct ToiFeature {
  enum class Kind : unsigned char { vertex, edge, face } kind = Kind::face;
  /// Vertex: its number; edge of a face: that of the opposite vertex; else 0. Vertices are numbered as passed, 0 .. 3.
  unsigned char index = 0;
  bool operator==(const ToiFeature&) const = default;
};

struct ToiResult {
  enum class Status : unsigned char {
    none,              ///< certainly no contact
    hit,               ///< contact at `toi`
    already_inside,    ///< contact at the very start: toi = 0
    invalid_input,     ///< not finite, or out of the valid range; says nothing about contact
    budget_exhausted,  ///< no contact before `toi`; contact after it was not excluded: treat as a hit
  } status = Status::none;
  bool is_certain = false;          ///< of a hit: proven. Otherwise rounding, or the resolution in time, left it open
  double toi = 1;                   ///< fraction of the step, never later than the true time
  double toi_upper = 1;             ///< never earlier than the true time, if there is contact
  ToiFeature first, second;         ///< of the vertex or edge a; of the face or edge b
  double weight[4] = {0, 0, 0, 0};  ///< of the four points: 1 | face's sum 1, or edge a's sum 1 | edge b's sum 1
  Vec3 normal = Vec3::Zero();       ///< unit, from the second to the first, before they touch

  bool is_contact() const noexcept { return status != Status::none && status != Status::invalid_input; }
};

/// Largest coordinate that is valid; and the smallest that the largest one of a query may be, unless all are zero.
constexpr double kLargestCoordinate = 0x1p100, kSmallestExtent = 0x1p-100;

/// x_t0, x_t1: vertex, then the three of the face [any unit of length], at the start and at the end of the step.
/// The times do not depend on the order of the face's vertices. No allocation, no exception.
ToiResult vertex_face_toi(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], ToiMode mode = ToiMode::exact) noexcept;

/// x_t0, x_t1: the two ends of edge a, then those of edge b. The times do not depend on the order of the ends or edges.
ToiResult edge_edge_toi(const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], ToiMode mode = ToiMode::exact) noexcept;

}  // namespace kt
