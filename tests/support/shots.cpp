#include "tests/support/shots.hpp"

namespace kt {
namespace {

constexpr double kTick = 1e-3;  // [s]

double power(Sample& s, double low, double high) { return std::pow(10, s.uniform(low, high)); }

/// Weights of a place on a face, or exactly on an edge or a vertex.
Vec3 weights_on(Sample& s, ShotTarget target) {
  Vec3 bary = Vec3::Zero();
  const int corners = target == ShotTarget::face ? 3 : target == ShotTarget::edge ? 2 : 1;
  for (int i = 0; i < corners; ++i) bary[i] = corners == 1 ? 1 : s.uniform(1e-3, 1);
  bary /= bary.sum();
  std::rotate(bary.data(), bary.data() + s.random() % 3, bary.data() + 3);
  return bary;
}

/// Where the shot comes from, on the side of n: head-on, from anywhere, or close to the face.
Vec3 side_of(Sample& s, const Vec3& n) {
  const Vec3 any = s.cube().normalized();
  const auto kind = s.random() % 3;
  if (kind == 0) return (n + 0.1 * any).normalized();
  if (kind == 1) return any.dot(n) < 0 ? Vec3(-any) : any;
  return (any - any.dot(n) * n + power(s, -4, 0) * n).normalized();
}

}  // namespace

SurfaceTicks random_ticks(Sample& s, const std::vector<Triangle>& triangles, const VectorX& x, SurfaceMotion motion) {
  SurfaceTicks out{triangles, std::vector<VectorX>(SurfaceTicks::kTicks + 1, x), motion};
  const auto count = static_cast<int>(x.size() / 3);
  if (motion == SurfaceMotion::rigid) {
    const Mat3 turn = Eigen::AngleAxisd(power(s, -5, -1), s.cube().normalized()).toRotationMatrix();
    const Vec3 shift = power(s, -5, -2.3) * s.cube().normalized();
    for (int k = 1; k <= SurfaceTicks::kTicks; ++k)
      for (int i = 0; i < count; ++i) node(out.x[k], i) = turn * Vec3(node(out.x[k - 1], i)) + shift;
  }
  if (motion == SurfaceMotion::deforming) {
    const double amplitude = power(s, -7, -3);
    for (VectorX& now : out.x)
      for (int i = 0; i < count; ++i) node(now, i) += amplitude * s.cube();
  }
  return out;
}

Shot random_shot(Sample& s, const SurfaceTicks& surface) {
  Shot out;
  out.target = static_cast<ShotTarget>(s.random() % 3);
  out.from_behind = s.uniform(0, 1) < 0.1;
  out.at_boundary = s.uniform(0, 1) < 0.3;
  out.speed = power(s, -1, std::log10(50.0));
  const double travel = out.speed * kTick;
  const bool is_sphere = s.uniform(0, 1) < 0.5;
  // A sphere no larger than its way in two ticks: then its centre goes through the surface, too.
  if (is_sphere) out.tool = {ToolShape::Kind::sphere, std::clamp(travel * power(s, -2, 0.3), 1e-5, 1e-2)};
  out.when = s.uniform(is_sphere ? 2 : 0.01, 6.5);
  if (out.at_boundary) out.when = std::round(out.when + 0.5);

  const int tick = std::min(static_cast<int>(out.when), SurfaceTicks::kTicks - 1);
  const double share = out.when - tick;
  const Triangle& triangle = surface.triangles[s.random() % surface.triangles.size()];
  const Vec3 bary = weights_on(s, out.target);
  Vec3 now[3], moved = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vec3 start = node(surface.x[tick], triangle[i]), end = node(surface.x[tick + 1], triangle[i]);
    now[i] = share == 0 ? start : Vec3((1 - share) * start + share * end);
    if (bary[i] > 0) out.place += bary[i] * now[i];
    moved += bary[i] * (end - start);
  }
  Vec3 normal = (now[1] - now[0]).cross(now[2] - now[0]).normalized();
  if (!(normal.norm() > 0.5)) normal = s.cube().normalized();  // no area
  if (out.from_behind) normal = -normal;
  const Vec3 from = side_of(s, normal);
  out.way = -travel * from;
  if (surface.motion == SurfaceMotion::rigid) out.way += moved;
  if (is_sphere && s.uniform(0, 1) < 0.5) out.place += out.tool.radius * from;  // its front is there, not its centre
  return out;
}

}  // namespace kt
