#pragma once
// What conjugate gradients do between two products with the matrix, in one sweep over the nodes each. Vectors in lanes
// (core/linear/dense/lane_matrix.hpp), nodes in the order of their groups (core/linear/coarse_space.hpp).
#include "core/linear/dense/lane_matrix.hpp"

namespace kt {

/// The vectors of the iteration, and what the preconditioner knows of the nodes.
struct PcgVectors {
  double *x, *r, *p, *q, *z;  ///< solution, residual, direction, A p, the nodes' own share of the preconditioned r
  const double* inverse;      ///< of each node's block: three columns of four
  const double* arms;         ///< from the centre of its group to each node, in units of the groups' size
  const int* group_begin;     ///< first node of each group
};

/// x += step p;  r -= step q;  z = inverse r;  loads: force and moment of r on each group, six numbers a group.
/// `sums`: r . r, lane by lane, then r . z; they are set.
void pcg_descend(const PcgVectors& v, double step, int first_group, int last_group, double* loads, double* sums);

/// p = z + (the groups' motions) + share p;  `motions`: translation and turn, six numbers a group and two more.
void pcg_turn(const PcgVectors& v, double share, int first_group, int last_group, const double* motions);

}  // namespace kt
