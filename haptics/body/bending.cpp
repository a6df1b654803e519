#include "haptics/body/bending.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/body/embedded_surface.hpp"

namespace kt {

double cells_across(const Mesh& mesh) {
  if (mesh.tetrahedra.empty()) return 0;
  double length = 0;
  long edges = 0;
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (int i = 0; i < 4; ++i)
      for (int k = i + 1; k < 4; ++k, ++edges) length += (node(mesh.x, t[i]) - node(mesh.x, t[k])).norm();
  // Cubes of a lattice reach beyond the body.
  const auto body = mesh.x.tail(mesh.x.size() - (mesh.embedded ? 3 * mesh.embedded->first : 0))
                        .reshaped(3, mesh.embedded ? mesh.embedded->num_vertices() : mesh.num_nodes());
  const Vec3 size = body.rowwise().maxCoeff() - body.rowwise().minCoeff();
  const double thinnest = mesh.embedded ? std::min(size.minCoeff(), mesh.embedded->thickness) : size.minCoeff();
  return thinnest * static_cast<double>(edges) / length;
}

double tet4_stiffening(double cells, double distance) { return 1 + (2.0 + 0.19 / distance) / (cells * cells); }

double spring_stiffening(double cells, double distance) {
  return (0.47 + 0.11 / distance) * (1 + 0.7 / (cells * cells));
}

double hex8_stiffening(double cells) { return 1 + 0.13 / std::pow(cells, 2.5); }

double tet4_distance(double cells, double factor) {
  const double left = (factor - 1) * cells * cells - 2.0;
  return left > 0 ? 0.19 / left : std::numeric_limits<double>::quiet_NaN();
}

bool auto_has_ten_nodes(const SceneObject& object) {
  constexpr double kLocks = 0.45;  // four-node cells above it (the map poisson of `kilotouch stability`)
  return object.body == "lattice" && object.model.type == "fem" && object.model.poisson > kLocks;
}

std::string lattice_element(const Mesh& lattice, double poisson) {
  if (lattice.embedded->is_quadratic()) return "tet10";
  return tet4_stiffening(cells_across(lattice), 0.5 - poisson) < kMostStiffening ? "tet4" : "hex8";
}

}  // namespace kt
