#pragma once
// Places of a body's surface where a sphere can touch it, and ways over the surface from there.
#include <optional>
#include <span>
#include <vector>

#include "core/body/mesh.hpp"
#include "lab/check/surface_query.hpp"

namespace kt {

constexpr double kClearance = 0.0015;  ///< the tool starts so far above the surface [m]

/// Where a sphere touches the body at rest, and how deep it may be pressed in.
struct ContactSpot {
  Vec3 place = Vec3::Zero();   ///< on the surface [m]
  Vec3 normal = Vec3::Zero();  ///< unit, outward
  int triangle = 0;
  double radius = 0;     ///< of the tool [m]
  double depth = 0;      ///< [m]
  double thickness = 0;  ///< of the body below [m]
};

struct SpotOptions {
  int count = 8;
  double radius = 0.004;  ///< of the tool; halved twice where it touches nowhere [m]
  double depth = 0.002;   ///< at most [m]
  int tried = 3000;       ///< triangles, about
  double shell = 0;       ///< thickness of a shell, whose inside no ray finds [m]; 0: solid
};

/// Triangles that are clamped, as a cloud.
class HeldTriangles {
 public:
  /// @param held  nodes of the triangles
  HeldTriangles(const Mesh& body, std::span<const int> held);
  bool is_near(const Vec3& p, double distance) const { return near_ && near_->is_within(p, distance); }

 private:
  std::vector<Triangle> triangles_;
  std::optional<SurfaceQuery> near_;
};

/// Spread over the surface, the same for the same mesh: on parts that are free to move, where the sphere can come from
/// outside without touching elsewhere first. Fewer, or none, where there are no more.
std::vector<ContactSpot> find_contact_spots(const Mesh& body, std::span<const int> held, const SpotOptions& options);

/// Over the undeformed surface from a spot on, at its depth: ends where the surface bends
/// sharply, the body is thin or held, or the sphere would touch elsewhere.
/// @param angle  of the direction, about the normal [rad]
std::vector<Vec3> surface_walk(const SurfaceQuery& surface, const HeldTriangles& held, const ContactSpot& spot,
                               double angle, double length);

}  // namespace kt
