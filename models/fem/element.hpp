#pragma once
// Elements as tables: nodes, and at each quadrature point the rest gradients of the shape functions.
#include <vector>

#include "core/body/embedded_surface.hpp"
#include "core/body/mesh.hpp"

namespace kt {

/// N nodes an element: 4 (linear), 10 (quadratic, edges in the order 01 12 20 03 13 23) or 8 (a cube).
template <int N>
struct ElementTable {
  struct Point {
    Eigen::Matrix<double, 3, N> gradient;  ///< of the shape functions in the rest shape [1/m]
    double volume = 0;                     ///< weight of the point [m^3]
  };
  int points_per_element = 0;
  std::vector<std::array<int, N>> nodes;
  std::vector<Point> points;  ///< element after element
  Mesh mesh;                  ///< with the edge nodes of quadratic elements, their faces split in four
  std::vector<Eigen::Matrix<double, N, 1>> lumped;  ///< of each element: its nodes' shares of mass; empty: as all
};

/// Throws InputError for an element without volume.
ElementTable<4> make_linear_elements(Mesh mesh);
ElementTable<10> make_quadratic_elements(const Mesh& mesh);
/// Of the cells of an embedded surface, each with its share of material. `cells`: without_embedded().
ElementTable<4> make_embedded_linear_elements(Mesh cells, const EmbeddedSurface& surface);
ElementTable<10> make_embedded_quadratic_elements(Mesh cells, const EmbeddedSurface& surface);

/// One gradient for all tetrahedra of a cube, their mean by volume of material: uniform strain (Flanagan and Belytschko
/// 1981). A piece of a cube that has fewer than eight corners names its first one again, with a gradient of zero.
/// @param cube  that each tetrahedron is in, ascending from 0
ElementTable<8> make_cubes(const ElementTable<4>& tetrahedra, const std::vector<int>& cube);
/// Mean over each cube's tetrahedra by volume of material, of one number for each; empty of none.
std::vector<double> mean_of_cubes(const std::vector<double>& of_tetrahedra, const ElementTable<4>& tetrahedra,
                                  const std::vector<int>& cube);

/// Nodes that stay fixed when `fixed` of the linear mesh do: an edge's node with both of its ends. Ascending.
std::vector<int> fixed_with_edges(const ElementTable<10>& elements, const std::vector<int>& fixed);

/// Share of an element's mass between its nodes, (N x N), sum 1: consistent, or lumped to the diagonal (quadratic
/// elements in proportion to the consistent diagonal: Hinton, Rock and Zienkiewicz 1976, all positive).
template <int N>
Eigen::Matrix<double, N, N> mass_shares(bool lumped);

}  // namespace kt
