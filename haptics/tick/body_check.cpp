#include "haptics/tick/body_check.hpp"

#include <algorithm>
#include <cmath>

#include "collision/held/first_contact.hpp"
#include "collision/shape/closest_point.hpp"
#include "haptics/tick/contact_check.hpp"

namespace kt {

constexpr double kFar = 1e-3;  // [m] more than the tool's radius: a leap, for one tick

BodyCheck::BodyCheck(const Surface& surface, std::span<const ToolShape> tools) : surface_(surface) {
  for (const ToolShape& tool : tools) {
    tools_.emplace_back(tool);
    reach_.push_back(tool_reach(tool));
  }
}

void BodyCheck::take(const PreparedLocalModel& model) {
  model_ = &model;
  const SurfacePatch& facets = model.surface.facets;
  vertex_of_node_.assign(static_cast<std::size_t>(model.body_x.size() / 3), -1);
  if (model.surface.levels == 0)
    for (int v = 0; v < facets.num_vertices(); ++v) vertex_of_node_[facets.global_node[v]] = v;
  std::vector<char> is_local(surface_.triangles.size(), 0);
  for (const int t : facets.global_triangle) is_local[t] = 1;
  rest_.clear();
  std::vector<int> nodes;
  for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
    if (is_local[t]) continue;
    Triangle& local = rest_.emplace_back();
    for (int c = 0; c < 3; ++c) {
      int& vertex = vertex_of_node_[surface_.triangles[t][c]];
      if (vertex < 0) {
        vertex = facets.num_vertices() + static_cast<int>(nodes.size());
        nodes.push_back(surface_.triangles[t][c]);
      }
      local[c] = vertex;
    }
  }
  patch_x_.resize(model.patch_basis.rows());
  local_x_.resize(3 * facets.num_vertices());
  x_.resize(local_x_.size() + 3 * static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i)
    node(x_, facets.num_vertices() + static_cast<int>(i)) = node(model.body_x, nodes[i]);
  for (Near& n : near_) n.slack = -1;
}

void BodyCheck::place(const VectorX& q) {
  model_->recover_patch(q, patch_x_);
  patch_x_ += model_->model.x0.head(patch_x_.size());
  model_->surface.follow(patch_x_, local_x_);
  model_->surface.place_apron(patch_x_, local_x_);
  x_.head(local_x_.size()) = local_x_;
}

/// All of the local model's surface, and of the rest, which stands still, what is no further away than the nearest
/// triangle can be.
SurfacePatch& BodyCheck::near(int tool, const Vec3& place) {
  Near& n = near_[static_cast<std::size_t>(tool)];
  if (n.slack >= 0 && (place - n.from).norm() <= n.slack) return n.patch;
  const auto distance = [&](const Triangle& t) {
    return std::sqrt(closest_point_on_triangle(place, node(x_, t[0]), node(x_, t[1]), node(x_, t[2])).distance_sq);
  };
  std::vector<double> distances;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Triangle& t : rest_) {
    distances.push_back(distance(t));
    nearest = std::min(nearest, distances.back());
  }
  n.from = place;
  n.slack = rest_.empty() ? std::numeric_limits<double>::infinity() : 0.25 * nearest + 0.5 * reach_[tool] + 1e-3;
  n.patch.triangles = model_->surface.facets.triangles;
  n.patch.is_curved = model_->surface.facets.is_curved;
  n.patch.global_node.resize(static_cast<std::size_t>(x_.size() / 3), -1);  // it counts the vertices
  for (std::size_t t = 0; t < rest_.size(); ++t)
    if (distances[t] <= nearest + 2 * (reach_[tool] + n.slack)) n.patch.triangles.push_back(rest_[t]);
  return n.patch;
}

double BodyCheck::depth(int tool, const ToolSweep& sweep) {
  return penetration_depth(near(tool, sweep.x_t1), x_, tools_[tool].shape(), sweep.x_t1, sweep.r_t1);
}

bool BodyCheck::leapt_into(int tool, const ToolSweep& sweep, double depth) const {
  const double far = tools_[tool].shape().radius + kFar;
  return depth > far && (sweep.x_t1 - sweep.x_t0).norm() > far;
}

bool BodyCheck::went_through(int tool, const ToolSweep& sweep) {
  MovingTool& moving = tools_[tool];
  const double way = (sweep.x_t1 - sweep.x_t0).norm();
  const bool is_leap = way > moving.shape().radius + kFar;
  const std::size_t local = model_->surface.facets.triangles.size();
  const SurfacePatch& close = near(tool, sweep.x_t1);
  const bool sees_way = way <= near_[static_cast<std::size_t>(tool)].slack;
  moving.move(sweep);
  Box box = moving.box();
  box.low.array() -= moving.shape().radius;
  box.high.array() += moving.shape().radius;
  const auto touches = [&](const Triangle& t) {
    const Vec3 place[3] = {node(x_, t[0]), node(x_, t[1]), node(x_, t[2])};
    const Vec3 low = place[0].cwiseMin(place[1]).cwiseMin(place[2]),
               high = place[0].cwiseMax(place[1]).cwiseMax(place[2]);
    return !is_apart(box, {low, high}) && find_tool_impact(moving, place, place).has_value();
  };
  const auto& triangles = close.triangles;
  if (is_leap && std::any_of(triangles.begin(), triangles.begin() + static_cast<std::ptrdiff_t>(local), touches))
    return true;
  if (!sees_way) return std::ranges::any_of(rest_, touches);
  return std::any_of(triangles.begin() + static_cast<std::ptrdiff_t>(local), triangles.end(), touches);
}

}  // namespace kt
