#pragma once
// Which nodes of a body matter to a contact: near it all of them, far from it fewer and fewer, the others follow these.
// Far away only smooth motion arrives, so that it costs little to leave out what is between (Saint-Venant).
#include <vector>

#include "core/base/types.hpp"

namespace kt {

struct GradingOptions {
  double slope = 0.6;   ///< growth of the spacing of the kept nodes with the distance from the patch [-]
  double margin = 2;    ///< so far around the patch the spacing does not grow, in edges of the patch
  double finest = 0.6;  ///< spacing to which a finer body is thinned out further than margin - 1, in edges of the patch
  double coarsest = 7;  ///< largest spacing, in edges of the patch
  int neighbours = 8;   ///< how many kept nodes each of the others follows
};

/// How well a node serves to represent its surroundings: the distance [m] that separates it from all nodes of higher
/// rank, up to a factor of 1.2. The nodes ranked at least h lie h apart or more, and every node has one within 1.2 h.
std::vector<double> node_ranks(const VectorX& x);

/// Motion of every free node as a weighted sum of the motions of the kept ones: u_i = sum weight u_(kept[column]).
struct Interpolation {
  std::vector<int> kept;  ///< nodes, ascending, none of them fixed
  std::vector<int> begin, column;
  std::vector<double> weight;  ///< of row i: begin[i] .. begin[i + 1]; rows: free nodes in order
};

/// Nodes kept by distance from `patch`, the others interpolated by moving least squares: affine motions (about the
/// fixed nodes, which count as nodes that do not move) are kept as they are.
/// @param x  node positions (3n)      @param ranks  by node_ranks      @param fixed  per node
Interpolation interpolate_far_nodes(const VectorX& x, const std::vector<double>& ranks, const std::vector<char>& fixed,
                                    const std::vector<int>& patch, const GradingOptions& options);

/// `patch`, and the nodes that are nearest to where its nodes would be `ahead` [m] of there.
std::vector<int> with_nodes_ahead(const VectorX& x, const std::vector<int>& patch, const Vec3& ahead);

/// Mean distance of a node of `patch` to its nearest other one [m].
double patch_spacing(const VectorX& x, const std::vector<int>& patch);

/// Smallest distance of node i to a node of `patch` [m].
double distance_to(const VectorX& x, const std::vector<int>& patch, int i);

}  // namespace kt
