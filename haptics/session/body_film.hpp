#pragma once
// The body's surface over a run, for pictures that move: some thirty frames a second, fewer where they would not fit.
#include <cstddef>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Where the rest of a body is while its part around the contact runs ahead of it, for pictures: between two refreshes
/// that part moves with the ticks, and the rest stands where the last refresh had it. Its lead fades over the next rows
/// of nodes; without that, neighbours at the rim are drawn millimetres apart when the body swings.
class PatchLead {
 public:
  static constexpr int kRows = 8;  ///< of nodes around the patch over which its lead fades to nothing

  /// @param mesh  of the whole body; nodes of an edge, of tetrahedra or else triangles, are neighbours
  /// @param held  nodes that never move
  PatchLead(const Mesh& mesh, const std::vector<int>& held);
  /// @param before  where the body was without the patch laid over (3n) [m]      @param x  with it; becomes the picture
  void fade(const VectorX& before, VectorX& x) const;

 private:
  std::vector<int> first_, neighbour_;  // of node i: neighbour_[first_[i] .. first_[i + 1])
  std::vector<char> is_held_;
};

/// What a run leaves for its player. Memory is bounded: when it is full, every second frame goes, and frames come half
/// as often from then on.
class BodyFilm {
 public:
  static constexpr std::size_t kMostBytes = 3u << 19;  ///< 1.5 MB, as int16: what a page can carry
  static constexpr double kInterval =
      1.0 / 30;  ///< [s] between frames, at first; a new local model may bring one sooner

  explicit BodyFilm(const Mesh& mesh, std::size_t most_bytes = kMostBytes);
  /// @param is_refreshed  the body has just followed: it is nearest to the truth then
  bool is_due(double t, bool is_refreshed) const;
  /// @param x  of all nodes (3n) [m]
  void add(double t, const VectorX& x);

  const std::vector<int>& nodes() const { return nodes_; }              ///< of the surface, ascending
  const std::vector<double>& times() const { return t_; }               ///< [s]
  const std::vector<std::vector<float>>& frames() const { return x_; }  ///< of those nodes (3 per node) [m]
  double interval() const { return interval_; }                         ///< [s] now

 private:
  std::vector<int> nodes_;
  std::vector<double> t_;
  std::vector<std::vector<float>> x_;
  std::size_t most_frames_;
  double interval_ = kInterval;
};

}  // namespace kt
