#include "core/fine/fine_size.hpp"

#include <algorithm>
#include <limits>

#include "core/fine/fine_refinement.hpp"

namespace kt {

double cell_size_at(const FineBody& body, const Vec3& place) {
  const Mesh& mesh = *body.mesh;
  double nearest = std::numeric_limits<double>::infinity(), sum = 0;
  int count = 0;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    std::array<Vec3, 4> p;
    for (int c = 0; c < 4; ++c) p[c] = node(mesh.x, t[c]);
    const double size = leaf_size(p), distance = least_distance(p, place), slack = 1e-9 * size;
    if (distance > nearest + slack) continue;
    if (distance < nearest - slack) sum = count = 0;
    nearest = std::min(nearest, distance);
    sum += size;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

namespace {
constexpr double kLeastFlat = 0.85;    // contact radii
constexpr double kPlacesApart = 0.27;  // contact radii: some twenty places under a ball, in a new zone
}  // namespace

double wide_radius(const FineBody& body, const FineContact& contact) {
  constexpr double kContacts = 4.5, kCells = 2.6;
  return std::min(kContacts * contact.contact_radius, kCells * cell_size_at(body, contact.centre));
}

FineZoneOptions fine_options(const FineBody& body, const FineContact& contact, double fineness) {
  const double a = contact.contact_radius, way = a + contact.travel, cell = cell_size_at(body, contact.centre);
  FineZoneOptions out;
  out.centre = contact.centre;
  out.others = contact.others;
  out.radius = std::max(1.6 * cell, way + 0.5 * cell);
  // Vertices of a scan touch further behind the middle of a contact that is dragged.
  out.reach = (body.mesh->embedded ? 1.4 : 1.15) * a + contact.travel;
  if (body.mesh->embedded) out.apart = kPlacesApart * std::min(a, contact.tool_radius);
  // Pressure falls off to the rim of the contact: cells there may be larger. Not on the way of a tool.
  out.size = {.edge = fineness * a,
              .flat = way,
              .least_flat = kLeastFlat * a + std::max(0.0, contact.travel - kLeastTravel * a),
              .slope = 1};
  return out;
}

}  // namespace kt
