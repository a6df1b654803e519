#pragma once
// Where a tool at rest relative to a surface touches it: the contacts that the solver holds as constraints.
#include <algorithm>
#include <array>
#include <optional>

#include "collision/shape/closest_point.hpp"
#include "collision/shape/contact.hpp"
#include "core/local/local_model.hpp"

namespace kt {

constexpr int kMaxContacts = 40;  ///< simultaneous contacts, of all tools together; those that say most are kept

/// A small fixed-capacity list, so that the haptic tick allocates nothing.
struct ContactSet {
  std::array<Contact, kMaxContacts> contacts;
  int count = 0;
  ContactSet() = default;
  ContactSet(const ContactSet& other) noexcept { *this = other; }
  ContactSet& operator=(const ContactSet& other) noexcept {  // what is there, not all the room: ticks copy many sets
    std::copy_n(other.contacts.data(), other.count, contacts.data());
    count = other.count;
    return *this;
  }
  const Contact* begin() const { return contacts.data(); }
  const Contact* end() const { return contacts.data() + count; }
  /// When full, lets go of the one that its neighbours say most about: shallow, or close to a deeper one.
  void add(const Contact& contact) noexcept;
};

/// Area-weighted unit normal of a patch vertex at positions x (3p).
Vec3 vertex_normal(const SurfacePatch& patch, const VectorX& x, int vertex) noexcept;

/// Unit normal blended from the vertex normals (Phong): continuous across edges, but not grooves (find_walls).
Vec3 blended_normal(const SurfacePatch& patch, const VectorX& x, int triangle, const Vec3& bary) noexcept;

/// Unit normal of the flat triangle; zero for a degenerate one.
Vec3 face_normal(const SurfacePatch& patch, const VectorX& x, int triangle) noexcept;

/// Contact of a point tool at p: the closest point of the surface reached by descent from `start` over neighbouring
/// triangles, so that the far side of a thin body is never mistaken for the near one. Normal: blended;
/// gap: signed distance.
Contact track_point_contact(const SurfacePatch& patch, const VectorX& x, const Vec3& p, int start) noexcept;

/// The same from the nearest triangle of the whole patch.
Contact nearest_point_contact(const SurfacePatch& patch, const VectorX& x, const Vec3& p) noexcept;

/// The same, and where it stands in a groove or a corner (find_walls), the other walls there: each with the distance
/// from its plane as the gap, which is positive where the point is clear of it.
void find_point_contacts(const SurfacePatch& patch, const VectorX& x, const Vec3& p, int start,
                         ContactSet& out) noexcept;

/// Contact of a sphere with one triangle, if that is nearer to its centre than the neighbours that share the nearest
/// place, and seen from outside. Normal: from the surface to the centre; on a curved patch the blended one.
std::optional<Contact> find_sphere_contact(const SurfacePatch& patch, const VectorX& x, const Vec3& centre,
                                           double radius, double margin, int triangle) noexcept;

/// The contact of a sphere at the place of a triangle that is nearest to its centre, if that is seen from outside.
/// @param outward  normal of what is nearest, of any length: the sum of those of the faces there
std::optional<Contact> make_sphere_contact(const SurfacePatch& patch, const VectorX& x, const Vec3& centre,
                                           double radius, int triangle, const ClosestPoint& at,
                                           const Vec3& outward) noexcept;

/// Contacts of a sphere: every local minimum of the distance from its centre to the surface with a gap below `margin`
/// [m], among `candidates` and their neighbours, seen from outside. Normal: from the surface to the centre; on a curved
/// patch the blended one.
/// `start` (or -1): a triangle touched before; when the centre has gone through the surface there, its plane counts.
/// `way` [m]: displacement of the centre since it was last outside the body. It may lead through a thin body: triangles
/// that the ball would have come to from within are on the far side, and none of its contacts. `overlap` [m]: how deep
/// it may be behind `start` besides, as one that is pushed out.
void find_sphere_contacts(const SurfacePatch& patch, const VectorX& x, const Vec3& centre, double radius, double margin,
                          std::span<const int> candidates, int start, ContactSet& out, const Vec3& way = Vec3::Zero(),
                          double overlap = 0) noexcept;

/// The same two places that touched, of the surface and of the core of a tool with a radius, with the surface at x: the
/// gap between them, and the normal that goes with it. None: they have turned away from each other.
std::optional<Contact> same_contact(const SurfacePatch& patch, const VectorX& x, const Contact& contact,
                                    double radius) noexcept;

}  // namespace kt
