#pragma once
// The body's surface over a run, for pictures that move: some thirty frames a second, fewer where they would not fit.
#include <cstddef>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

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
