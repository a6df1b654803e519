#pragma once
// Places of a body's surface where a sphere can touch it, and ways over the surface from there.
#include <span>
#include <vector>

#include "apps/check/surface_query.hpp"
#include "core/mesh.hpp"
#include "haptics/device/haptic_device.hpp"

namespace kt {

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
  double shell = 0;       ///< thickness of a shell, whose inside no ray finds [m]; 0: solid
};

/// Spread over the surface, the same for the same mesh: on parts that are free to move, where the sphere can come from
/// outside without touching elsewhere first. Fewer, or none, where there are no more.
std::vector<ContactSpot> find_contact_spots(const Mesh& body, std::span<const int> held, const SpotOptions& options);

/// Of a line through these points.
double length_of(const std::vector<Vec3>& line);

/// Down onto the spot, in by steps of a quarter of its depth, each from rest to rest as a hand moves, and out again.
struct PressPath {
  std::vector<TimedPoint> path;
  std::vector<double> rests;  ///< when the rest at each depth ends [s]
  double pressed = 0;         ///< when it is all in [s]
};
PressPath press_path(const ContactSpot& spot);

/// Over the undeformed surface from a spot on, at its depth, there and back again: ends where the surface bends
/// sharply, the body is thin or held, or the sphere would touch elsewhere.
/// @param angle  of the direction, about the normal [rad]
std::vector<Vec3> surface_walk(const SurfaceQuery& surface, const Mesh& body, std::span<const int> held,
                               const ContactSpot& spot, double angle, double length);

/// Down to the start of a walk, then along it, there and back, until `duration` [s]: from rest to rest, with `speed`
/// on average [m/s].
std::vector<TimedPoint> drag_path(const ContactSpot& spot, const std::vector<Vec3>& walk, double speed,
                                  double duration);
constexpr double kDragPressTime = 0.12;  ///< [s] until the drag begins

}  // namespace kt
