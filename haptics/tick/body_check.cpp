#include "haptics/tick/body_check.hpp"

#include <algorithm>
#include <cmath>

#include "collision/held/first_contact.hpp"
#include "collision/held/vertex_contacts.hpp"
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
  const ContactSurface& s = model.surface;
  const int vertices = s.apron_vertices < 0 ? s.facets.num_vertices() : s.apron_vertices;
  const auto facets = s.apron_facets < 0 ? s.facets.triangles.size() : static_cast<std::size_t>(s.apron_facets);
  local_.assign(s.facets.triangles.begin(), s.facets.triangles.begin() + static_cast<std::ptrdiff_t>(facets));
  const bool has_nodes = s.levels == 0 && !s.is_embedded;
  if (has_nodes)  // where the rim's corners are the apron's, with the patch's own
    for (std::size_t t = 0; t < model.model.patch.triangles.size(); ++t)
      if (!s.fine || s.fine_facet[t] < 0) local_[t] = model.model.patch.triangles[t];
  std::vector<int> vertex_of_node(static_cast<std::size_t>(model.body_x.size() / 3), -1);
  if (s.is_embedded)
    for (int v = 0; v < vertices; ++v)
      if (const int global = s.facets.global_node[v]; global >= 0) vertex_of_node[global] = v;
  if (has_nodes)
    for (int v = 0; v < s.num_nodes; ++v) vertex_of_node[model.model.patch.global_node[v]] = v;
  rest_.clear();
  rest_node_.clear();
  for (std::size_t t = 0; t < surface_.triangles.size(); ++t) {
    if (model.local_triangle[t] >= 0) continue;
    Triangle& local = rest_.emplace_back();
    for (int c = 0; c < 3; ++c) {
      int& vertex = vertex_of_node[surface_.triangles[t][c]];
      if (vertex < 0) {
        vertex = vertices + static_cast<int>(rest_node_.size());
        rest_node_.push_back(surface_.triangles[t][c]);
      }
      local[c] = vertex;
    }
  }
  patch_x_.resize(3 * static_cast<Eigen::Index>(s.num_moving()));
  local_x_.resize(3 * vertices);
  x_.resize(local_x_.size() + 3 * static_cast<Eigen::Index>(rest_node_.size()));
  for (int i = 0; !model.apron && i < static_cast<int>(rest_node_.size()); ++i)  // these stay where they are
    node(x_, vertices + i) = node(model.body_x, rest_node_[static_cast<std::size_t>(i)]);
  for (Near& n : near_) n.slack = -1;
  refined_.clear();
  for (std::size_t t = 0; t < local_.size(); ++t)
    if (s.is_refined(static_cast<int>(t))) refined_.push_back(static_cast<int>(t));
}

void BodyCheck::place(const VectorX& q) {
  const Eigen::Index dof = model_->model.dof(), rows = model_->patch_basis.rows();
  model_->recover_patch(q.head(dof), patch_x_);
  patch_x_.head(rows) += model_->model.x0.head(rows);
  patch_x_.tail(patch_x_.size() - rows) = q.tail(q.size() - dof);
  model_->surface.place(patch_x_, local_x_);
  x_.head(local_x_.size()) = local_x_;
  const auto vertices = static_cast<int>(local_x_.size() / 3);
  std::array<Vec3, kMostApronSites> means;
  if (model_->apron) model_->apron->motion().means(patch_x_, means);
  if (model_->apron && model_->surface.levels == 0)
    for (int v = 0; v < model_->surface.num_nodes; ++v)
      if (const int global = model_->model.patch.global_node[v]; model_->apron->motion().patch_vertex[global] < 0)
        node(x_, v) = model_->apron->motion().place(global, means);
  for (int i = 0; model_->apron && i < static_cast<int>(rest_node_.size()); ++i) {
    const int global = rest_node_[static_cast<std::size_t>(i)];
    const int patch = model_->apron->motion().patch_vertex[static_cast<std::size_t>(global)];
    node(x_, vertices + i) = patch >= 0 ? Vec3(node(patch_x_, patch)) : model_->apron->motion().place(global, means);
  }
}

/// Most that a vertex may have moved since [m]: as far as one of the patch's, of which it is a mean.
double BodyCheck::moved_since(const Near& near) const {
  const double diagonal = model_->surface.fine ? 3.6 : 1.8;  // of a coordinate; it may yield by as much beside
  return model_->apron ? diagonal * (patch_x_ - near.patch_x).lpNorm<Eigen::Infinity>() : 0;
}

/// All of the patch's contact surface, and of the rest what is no further away than the nearest triangle can be.
SurfacePatch& BodyCheck::near(int tool, const Vec3& place) {
  Near& n = near_[static_cast<std::size_t>(tool)];
  if (n.slack >= 0 && (place - n.from).norm() + moved_since(n) <= n.slack) return n.patch;
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
  n.patch_x = patch_x_;
  n.slack = rest_.empty() ? std::numeric_limits<double>::infinity() : 0.25 * nearest + 0.5 * reach_[tool] + 1e-3;
  n.patch.triangles = local_;
  n.patch.is_curved = model_->surface.facets.is_curved;
  n.patch.global_node.resize(static_cast<std::size_t>(x_.size() / 3), -1);  // it counts the vertices
  for (std::size_t t = 0; t < rest_.size(); ++t)
    if (distances[t] <= nearest + 2 * (reach_[tool] + n.slack)) n.patch.triangles.push_back(rest_[t]);
  return n.patch;
}

/// How far a ball that lies on the nodes of refined facets may reach below these [m]: over a triangle of equal edges L
/// L^2 / 6 R, the most for a longest edge. Of the facets that it covers. Where tools are not held at all vertices, each
/// point is within L / sqrt(3) of a vertex, and that within `apart` of a place at rest, and half as far again under a
/// ball that is pressed in deeply: r^2 / 2 R for both, and no more than half its radius.
double BodyCheck::between_nodes(const MovingTool& tool, const Vec3& place) const {
  constexpr double kStretched = 1.5;
  const ToolShape& shape = tool.shape();
  if (!has_vertex_contacts(tool.core()) || !(shape.radius > 0)) return 0;
  const double covers = 1.1 * tool_reach(shape);  // where it only just touches, the nodes are further than its surface
  double longest_sq = 0;
  for (const int t : refined_) {
    const Vec3 a = node(x_, local_[t][0]), b = node(x_, local_[t][1]), c = node(x_, local_[t][2]);
    if (std::min({(a - place).norm(), (b - place).norm(), (c - place).norm()}) > covers) continue;
    longest_sq = std::max({longest_sq, (a - b).squaredNorm(), (b - c).squaredNorm(), (c - a).squaredNorm()});
  }
  const double apart = longest_sq > 0 ? kStretched * model_->surface.fine->apart : 0;
  const double far = std::min(std::sqrt(longest_sq / 3) + apart, shape.radius);
  return far * far / (2 * shape.radius);
}

double BodyCheck::depth(int tool, const ToolSweep& sweep) {
  const MovingTool& own = tools_[tool];
  const double depth = penetration_depth(near(tool, sweep.x_t1), x_, own.shape(), sweep.x_t1, sweep.r_t1);
  return depth > 0 && !refined_.empty() ? std::max(0.0, depth - between_nodes(own, sweep.x_t1)) : depth;
}

bool BodyCheck::leapt_into(int tool, const ToolSweep& sweep, double depth) const {
  const double far = tools_[tool].shape().radius + kFar;
  return depth > far && (sweep.x_t1 - sweep.x_t0).norm() > far;
}

bool BodyCheck::went_through(int tool, const ToolSweep& sweep) {
  MovingTool& moving = tools_[tool];
  const double way = (sweep.x_t1 - sweep.x_t0).norm();
  const bool is_leap = way > moving.shape().radius + kFar;
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
  // What the local model has it has looked at, all along the way: only a leap says that it did not hold.
  const std::size_t seen = is_leap ? 0 : model_->apron ? triangles.size() : local_.size();
  if (std::any_of(triangles.begin() + static_cast<std::ptrdiff_t>(seen), triangles.end(), touches)) return true;
  return !sees_way && (is_leap || !model_->apron) && std::ranges::any_of(rest_, touches);
}

}  // namespace kt
