#include "collision/held/moving_tool.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace kt {
namespace {

std::vector<std::array<int, 2>> edges_of(const ToolShape& shape) {
  if (shape.triangles.empty())
    return shape.corners.size() == 2 ? std::vector<std::array<int, 2>>{{0, 1}} : std::vector<std::array<int, 2>>{};
  std::vector<std::array<int, 2>> out;
  for (const Triangle& t : shape.triangles)
    for (int c = 0; c < 3; ++c) out.push_back({std::min(t[c], t[(c + 1) % 3]), std::max(t[c], t[(c + 1) % 3])});
  std::ranges::sort(out);
  const auto rest = std::ranges::unique(out);
  out.erase(rest.begin(), rest.end());
  return out;
}

void enclose(Box& box, const Vec3& x) noexcept {
  box.low = box.low.cwiseMin(x);
  box.high = box.high.cwiseMax(x);
}

void grow(Box& box, double margin) noexcept {
  box.low.array() -= margin;
  box.high.array() += margin;
}

}  // namespace

MovingTool::MovingTool(ToolShape shape)
    : shape_(std::move(shape)), edges_(edges_of(shape_)), features_(find_tool_features(shape_)) {
  if (shape_.triangles.empty() && shape_.corners.size() == 2) hulls_.push_back({{0, 1, 1}, 2, 0});
  for (const Triangle& t : shape_.triangles) hulls_.push_back({t, 3, 0});
  for (Piece& piece : hulls_)
    for (const int c : piece.corner) piece.arm = std::max(piece.arm, shape_.corners[c].norm());
  x_t0_.resize(std::max<std::size_t>(1, shape_.corners.size()));
  x_t1_ = x_t0_;
  hull_box_.resize(hulls_.size());
}

void MovingTool::move(const ToolSweep& sweep) noexcept {
  sweep_ = sweep;
  const Mat3 r_t0 = sweep.r_t0.toRotationMatrix(), r_t1 = sweep.r_t1.toRotationMatrix();
  back_ = r_t0 * r_t1.transpose();
  angle_ = sweep.r_t0.coeffs() == sweep.r_t1.coeffs() ? 0 : sweep.r_t0.angularDistance(sweep.r_t1);
  if (is_round()) {
    x_t0_[0] = sweep.x_t0;
    x_t1_[0] = sweep.x_t1;
    box_ = path_box(sweep, 0);
    return;
  }
  for (std::size_t i = 0; i < shape_.corners.size(); ++i) {
    x_t0_[i] = sweep.x_t0 + r_t0 * shape_.corners[i];
    x_t1_[i] = sweep.x_t1 + r_t1 * shape_.corners[i];
  }
  box_ = {x_t0_[0], x_t0_[0]};
  for (std::size_t i = 0; i < hulls_.size(); ++i) {
    const Piece& piece = hulls_[i];
    Box& box = hull_box_[i];
    box = {x_t0_[piece.corner[0]], x_t0_[piece.corner[0]]};
    bool finite = true;
    for (const int c : piece.corner) {
      enclose(box, x_t0_[c]);
      enclose(box, x_t1_[c]);
      finite = finite && x_t0_[c].allFinite() && x_t1_[c].allFinite();
    }
    grow(box, sagitta(piece.arm, angle_));
    if (!finite) box = everywhere();
    enclose(box_, box.low);
    enclose(box_, box.high);
  }
}

MovingHull MovingTool::hull(int i) const noexcept {
  const Piece& piece = hulls_[i];
  MovingHull out;
  out.corners = piece.corners;
  out.radius = shape_.radius;
  out.swell = sagitta(piece.arm, angle_);
  for (int c = 0; c < 3; ++c) {
    out.x_t0[c] = x_t0_[piece.corner[c]];
    out.x_t1[c] = x_t1_[piece.corner[c]];
  }
  return out;
}

ToolSweep rest_of(const ToolSweep& sweep, double toi) noexcept {
  ToolSweep out = sweep;
  out.x_t0 += toi * (sweep.x_t1 - sweep.x_t0);
  if (sweep.r_t0.coeffs() != sweep.r_t1.coeffs()) out.r_t0 = sweep.r_t0.slerp(toi, sweep.r_t1);
  return out;
}

double tool_reach(const ToolShape& tool) noexcept {
  double farthest = 0;
  for (const Vec3& x : tool.corners) farthest = std::max(farthest, x.norm());
  return farthest + tool.radius;
}

ToolShape make_capsule(double radius, double length) {
  if (!(radius > 0 && length > 0 && std::isfinite(radius) && std::isfinite(length)))
    throw InputError(text("capsule: radius = ", radius, " m and length = ", length, " m must be above 0"));
  const Vec3 end(0, 0, 0.5 * length);
  return {ToolShape::Kind::capsule, radius, {-end, end}, {}};
}

ToolShape make_mesh_tool(const Mesh& mesh, double radius) {
  if (!(radius > 0 && std::isfinite(radius)))
    throw InputError(text("mesh tool: radius = ", radius, " m, must be above 0: its triangles are rounded by it"));
  if (mesh.triangles.empty()) throw InputError("mesh tool: the mesh has no triangles");
  if (!mesh.x.allFinite()) throw InputError("mesh tool: a coordinate is not a finite number");
  ToolShape out{ToolShape::Kind::mesh, radius, {}, mesh.triangles};
  for (int i = 0; i < mesh.num_nodes(); ++i) out.corners.push_back(node(mesh.x, i));
  return out;
}

}  // namespace kt
