#pragma once
// Stiffer or softer balls inside a body: a nodule under the skin, a cyst.
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

struct Inclusion {
  Vec3 center = Vec3::Zero();  ///< [m], in the rest shape
  double radius = 0;           ///< [m], > 0
  double stiffer = 1;          ///< > 0: factor of Young's modulus, and of springs' stiffness
  bool operator==(const Inclusion&) const = default;
};

/// Factor of the stiffness of every element: each tetrahedron, or each triangle of a body without. An element has the
/// factor of the last inclusion that holds its centroid, 1 outside of all. Empty without inclusions.
/// Throws InputError for a value outside its range, and for an inclusion that holds no element.
std::vector<double> stiffness_factors(const Mesh& mesh, const std::vector<Inclusion>& inclusions);

/// How many are not 1.
int num_stiffened(const std::vector<double>& factors);

}  // namespace kt
