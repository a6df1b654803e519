#include "lab/study/press.hpp"

#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "core/base/error.hpp"
#include "core/body/wrapping_model.hpp"
#include "core/global/integrator.hpp"

namespace kt {
namespace {

constexpr double kSpacing = 0.15;   // of the contact radius, between points
constexpr double kStiffness = 200;  // of the points' pressure, over young / contact radius: Hertz' largest pressure is
                                    // 2 young / (pi radius) times the latter, so the overlap is 1/300 of the depth
constexpr double kSteps[] = {0.5, 0.125};  // of the radius that the tool goes at once: what is first tried, and then.
                                           // With one or more, points before the tool would be behind its centre
constexpr double kMoved = 1e-3;            // of the depth: the last displacement of Newton's method
constexpr double kSettled = 0.005;         // imbalance of an equilibrium; Newton's method leaves a tenth of it or less
constexpr int kMostSubdivided = 32;        // parts of a triangle's edge

/// A point of the surface, and the part of the surface that it stands for.
struct SurfacePoint {
  Triangle nodes{};
  Vec3 bary = Vec3::Zero();
  double area = 0;  ///< [m^2]
  Vec3 at(const VectorX& x) const {
    return bary[0] * node(x, nodes[0]) + bary[1] * node(x, nodes[1]) + bary[2] * node(x, nodes[2]);
  }
};

/// The middles of the m^2 equal parts of a triangle.
void add_points(const VectorX& x, const Triangle& t, double spacing, std::vector<SurfacePoint>& out) {
  const Vec3 a = node(x, t[0]), b = node(x, t[1]), c = node(x, t[2]);
  const double longest = std::max({(a - b).norm(), (b - c).norm(), (c - a).norm()});
  const int m = std::clamp(static_cast<int>(std::ceil(longest / spacing)), 1, kMostSubdivided);
  const double area = 0.5 * (b - a).cross(c - a).norm() / (m * m);
  for (int i = 0; i < m; ++i)
    for (int j = 0; i + j < m; ++j)
      for (const double third : {1.0 / 3, 2.0 / 3}) {  // the part that points the same way, the one across its edge
        if (third > 0.5 && i + j + 1 == m) continue;
        const double u = (i + third) / m, v = (j + third) / m;
        out.push_back({t, {1 - u - v, u, v}, area});
      }
}

/// Of all triangles that the tool can get to.
std::vector<SurfacePoint> points_near(const Mesh& mesh, const VectorX& x, const PressSite& site) {
  const double reach = site.radius + 2 * site.depth();
  std::vector<SurfacePoint> out;
  for (const Triangle& t : mesh.triangles)
    if (closest_point_on_triangle(site.to, node(x, t[0]), node(x, t[1]), node(x, t[2])).distance_sq < reach * reach)
      add_points(x, t, kSpacing * site.contact_radius(), out);
  return out;
}

/// The model with the sphere in its way.
class PressedModel final : public WrappingModel {
 public:
  PressedModel(const DeformableModel& model, const State& start, const PressSite& site, const PressOptions& options)
      : WrappingModel(model),
        centre(site.from),
        points_(points_near(model.mesh(), start.x, site)),
        radius_(site.radius),
        stiffness_(kStiffness * options.young / site.contact_radius()),
        options_(options) {}
  void force(const State& state, VectorX& out) const override {
    model_.force(state, out);
    visit(state.x, [&](const SurfacePoint& p, const Vec3& normal, double overlap) {
      for (int c = 0; c < 3; ++c) node(out, p.nodes[c]) -= stiffness_ * p.area * overlap * p.bary[c] * normal;
    });
  }

  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    if (options_.stop && options_.stop()) throw RunError("the press was ended before it came to rest");
    model_.update_tangent(state, kind, out);
    // The turning of the normal is left out: it is small while the overlap is, and would make the matrix indefinite.
    visit(state.x, [&](const SurfacePoint& p, const Vec3& normal, double) {
      const Mat3 k = stiffness_ * p.area * normal * normal.transpose();
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
              out.dfdx.coeffRef(3 * p.nodes[a] + r, 3 * p.nodes[b] + c) -= p.bary[a] * p.bary[b] * k(r, c);
    });
  }

  PressResult result(const State& state, int iterations) const {
    PressResult out{.state = state, .iterations = iterations};
    visit(state.x, [&](const SurfacePoint& p, const Vec3& normal, double overlap) {
      out.force += stiffness_ * p.area * overlap * normal;
      out.overlap = std::max(out.overlap, overlap);
    });
    VectorX left;
    force(state, left);
    for (int i : fixed_nodes()) node(left, i).setZero();
    out.imbalance = left.norm() / out.force.norm();
    return out;
  }

  Vec3 centre;

 private:
  /// visit(point, unit normal towards the centre, overlap > 0)
  template <class Visit>
  void visit(const VectorX& x, const Visit& visit) const {
    for (const SurfacePoint& p : points_) {
      const Vec3 away = centre - p.at(x);
      const double distance = away.norm();
      if (distance < radius_ && distance > 0) visit(p, Vec3(away / distance), radius_ - distance);
    }
  }

  std::vector<SurfacePoint> points_;
  double radius_, stiffness_;
  const PressOptions& options_;
};

}  // namespace

PressResult press(const DeformableModel& model, const State& start, const PressSite& site,
                  const PressOptions& options) {
  PressedModel pressed(model, start, site, options);
  const double size = bounds(model.mesh()).size().norm();
  PressResult out;
  for (const double step : kSteps) {
    const auto rest =
        make_integrator("quasistatic", {.solver = options.solver, .convergence = kMoved * site.depth() / size});
    const int steps = std::max(1, static_cast<int>(std::ceil(site.depth() / (step * site.radius))));
    State state = start;
    for (int i = 1; i <= steps; ++i) {
      pressed.centre = site.from + i / static_cast<double>(steps) * (site.to - site.from);
      rest->step(pressed, VectorX::Zero(state.x.size()), 0, state);
    }
    out = pressed.result(state, rest->statistics().iterations);
    out.settled = out.imbalance <= kSettled && out.force.dot(site.from - site.to) > 0;
    if (out.settled) break;
  }
  return out;
}

}  // namespace kt
