#include "lab/stability/runs/sliver.hpp"

#include "io/solid/tetrahedra_quality.hpp"
#include "lab/stability/bisect.hpp"

namespace kt {

Mesh block_with_sliver(int n, double h, double dihedral_deg) {
  const Mesh block = kuhn_block(n, n, n, h);
  // In the second cube from the corner, the tetrahedron (0,0,0) (1,0,0) (1,1,0) (1,1,1): its second node is the nearer
  // to the plane of the others the flatter it is, and falls onto the middle of (0,0,0) (1,1,0).
  const auto number = [&](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  const int moved = number(2, 1, 1);
  const Vec3 foot = 0.5 * (node(block.x, number(1, 1, 1)) + node(block.x, number(2, 2, 1)));
  const auto with_distance = [&](double share) {
    Mesh out = block;
    node(out.x, moved) = foot + share * (node(block.x, moved) - foot);
    return out;
  };
  const RayCrossing c = bisect(1, 1e-8, {.tolerance = 1e-9}, [&](double share) {
    return tetrahedra_quality(with_distance(share)).dihedral_min < dihedral_deg;
  });
  return with_distance(c.inside);
}

}  // namespace kt
