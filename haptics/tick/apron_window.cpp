#include "haptics/tick/apron_window.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/shape/closest_point.hpp"

namespace kt {

ApronWindow::ApronWindow(const Surface& surface, const VectorX& x, std::span<const int> local_triangle,
                         ApronMotion motion, const std::string& collision_backend)
    : surface_(surface), x_(x), local_triangle_(local_triangle), motion_(std::move(motion)) {
  const std::size_t count = surface.triangles.size();
  chosen_.reserve(count);
  std::vector<char> is_seen(static_cast<std::size_t>(x.size() / 3), 0);
  for (std::size_t t = 0; t < count; ++t) {
    if (local_triangle_[t] >= 0) continue;
    chosen_.push_back(static_cast<int>(t));
    for (const int i : surface.triangles[t]) most_vertices_ += !std::exchange(is_seen[static_cast<std::size_t>(i)], 1);
  }
  most_triangles_ = static_cast<int>(chosen_.size());
  if (most_triangles_ <= kTriangles) return;
  most_triangles_ = kTriangles;
  most_vertices_ = std::min(most_vertices_, kVertices);
  tree_ = make_triangle_index(collision_backend);
  tree_->build(surface.triangles, x);
  const auto nodes = x.reshaped(3, x.size() / 3);
  size_ = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  candidates_.resize(count);
  by_distance_.reserve(count);
  is_chosen_.assign(count, 0);
  seen_node_.assign(is_seen.size(), 0);
}

bool ApronWindow::covers(int tool, const Vec3& place, double need) const noexcept {
  constexpr double kAsGood = 0.1;  // of its reach: another one would be hardly better
  if (!tree_) return true;
  if (static_cast<std::size_t>(tool) >= laid_.size()) return false;
  const Laid& laid = laid_[static_cast<std::size_t>(tool)];
  const double moved = (place - laid.place).norm();
  return moved + need <= laid.reach || moved <= kAsGood * laid.reach;
}

std::span<const int> ApronWindow::choose(std::span<const Vec3> places) noexcept {
  if (!tree_) return chosen_;
  for (const int t : chosen_) is_chosen_[static_cast<std::size_t>(t)] = 0;
  chosen_.clear();
  ++call_;
  int vertices = 0;
  const std::size_t share = kTriangles / places.size();
  laid_.resize(places.size());  // once: no allocation later
  for (std::size_t k = 0; k < places.size(); ++k) {
    laid_[k].place = places[k];
    const int end = most_vertices_ * static_cast<int>(k + 1) / static_cast<int>(places.size());
    vertices = choose_near(places[k], share, end - vertices, laid_[k].reach) + vertices;
  }
  std::sort(chosen_.begin(), chosen_.end());
  return chosen_;
}

/// @param most      triangles      @param vertices  room for so many
/// @param reach     [m] all that is nearer is in the window
/// @return vertices that were added
int ApronWindow::choose_near(const Vec3& place, std::size_t most, int vertices, double& reach) noexcept {
  constexpr double kWider = 1.5, kFirst = 1e-3;  // of the body's size
  double r = std::max(kFirst * size_, std::isfinite(reach) ? 0.5 * reach : 0.0);
  int count = 0;
  for (const double far = 2 * (size_ + (place - Vec3(node(x_, 0))).norm());; r *= kWider) {
    count = tree_->candidates({place, place}, r, candidates_);
    if (static_cast<std::size_t>(count) >= most || r > far) break;
  }
  by_distance_.clear();
  for (int i = 0; i < count; ++i) {
    const int t = candidates_[static_cast<std::size_t>(i)];
    if (local_triangle_[static_cast<std::size_t>(t)] >= 0) continue;
    const Triangle& v = surface_.triangles[static_cast<std::size_t>(t)];
    by_distance_.emplace_back(
        closest_point_on_triangle(place, node(x_, v[0]), node(x_, v[1]), node(x_, v[2])).distance_sq, t);
  }
  std::sort(by_distance_.begin(), by_distance_.end());
  reach = r;
  int added = 0;
  for (std::size_t i = 0; i < by_distance_.size(); ++i) {
    const auto [distance_sq, t] = by_distance_[i];
    int more = 0;
    for (const int v : surface_.triangles[static_cast<std::size_t>(t)])
      more += seen_node_[static_cast<std::size_t>(v)] != call_;
    if (i == most || added + more > vertices) {
      reach = std::min(reach, std::sqrt(distance_sq));
      break;
    }
    for (const int v : surface_.triangles[static_cast<std::size_t>(t)]) seen_node_[static_cast<std::size_t>(v)] = call_;
    added += more;
    if (!std::exchange(is_chosen_[static_cast<std::size_t>(t)], 1)) chosen_.push_back(t);
  }
  return added;
}

}  // namespace kt
