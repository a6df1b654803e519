#pragma once
// How much too stiff bodies of elements and of springs are in bending, by laws fitted to measurements.
#include <string>

#include "core/body/mesh.hpp"
#include "io/scene/scene.hpp"

namespace kt {

constexpr double kMostStiffening = 1.5;  ///< of a body that bends as its material says, about

/// The body's thinnest extent over its mean edge: how many elements lie across it. 0 without tetrahedra. Of a lattice
/// what is thin all over counts, too: a bowl, a tube.
double cells_across(const Mesh& mesh);

/// How much too stiff a cantilever is, with `cells` across it and Poisson's ratio `distance` below 1/2: laws fitted to
/// the map poisson, to a fifth where they pass 1.5 (docs/stability.md). 4-node tetrahedra bend too little on any coarse
/// mesh, and less the nearer to 1/2; the springs of a network follow the solid's bulk modulus, since nothing else in
/// them can, and then are too stiff in everything else.
double tet4_stiffening(double cells, double distance);
double spring_stiffening(double cells, double distance);

/// Of cubes of a lattice, whatever Poisson's ratio: plates of 0.2 to 1.6 cells (docs/lattice.md).
double hex8_stiffening(double cells);

/// The distance at which tet4_stiffening() reaches `factor`; NaN when it is above at any.
double tet4_distance(double cells, double factor);

/// object.model.element auto: ten nodes where four would lock and the engine makes the cells, as many nodes in larger
/// ones, in lattices above a Poisson's ratio of 0.45. Cubes do not lock there, but their tangents are indefinite under
/// a deep press.
bool auto_has_ten_nodes(const SceneObject& object);

/// And else: hex8 where tetrahedra of four nodes would bend too little, or tet4.
std::string lattice_element(const Mesh& lattice, double poisson);

}  // namespace kt
