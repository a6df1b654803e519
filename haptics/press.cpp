#include "haptics/press.hpp"

#include "collision/closest_point.hpp"
#include "core/error.hpp"
#include "core/integrator.hpp"

namespace kt {
namespace {

/// The model with a sphere in its way.
class PressedModel final : public DeformableModel {
 public:
  PressedModel(const DeformableModel& model, double radius, const PressOptions& options)
      : model_(model), radius_(radius), stiffness_(options.stiffness), options_(options) {}
  const Mesh& mesh() const override { return model_.mesh(); }
  const SparseMatrix& mass() const override { return model_.mass(); }
  const std::vector<int>& fixed_nodes() const override { return model_.fixed_nodes(); }
  ModelInfo info() const override { return model_.info(); }

  void force(const State& state, VectorX& out) const override {
    model_.force(state, out);
    visit(state.x, [&](const Triangle& t, const ClosestPoint& at, const Vec3& normal, double overlap) {
      for (int c = 0; c < 3; ++c) node(out, t[c]) -= stiffness_ * overlap * at.bary[c] * normal;
    });
  }

  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    if (options_.stop && options_.stop()) throw RunError("the press was ended before it found its equilibrium");
    model_.update_tangent(state, kind, out);
    // The normal's turning is left out: it is small while the overlap is, and would make the matrix indefinite.
    visit(state.x, [&](const Triangle& t, const ClosestPoint& at, const Vec3& normal, double) {
      const Mat3 k = stiffness_ * normal * normal.transpose();
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
              out.dfdx.coeffRef(3 * t[a] + r, 3 * t[b] + c) -= at.bary[a] * at.bary[b] * k(r, c);
    });
  }

  /// Force on the tool [N] and the largest overlap [m].
  std::pair<Vec3, double> push(const VectorX& x) const {
    Vec3 sum = Vec3::Zero();
    double deepest = 0;
    visit(x, [&](const Triangle&, const ClosestPoint&, const Vec3& normal, double overlap) {
      sum += stiffness_ * overlap * normal;
      deepest = std::max(deepest, overlap);
    });
    return {sum, deepest};
  }

  /// Norm of the forces left on the free nodes, over that on the tool; 0 where nothing touches.
  double imbalance(const State& state) const {
    VectorX left;
    force(state, left);
    for (int i : fixed_nodes()) node(left, i).setZero();
    const double on_tool = push(state.x).first.norm();
    return on_tool > 0 ? left.norm() / on_tool : 0;
  }

  Vec3 centre = Vec3::Zero();

 private:
  /// visit(triangle, closest point, unit normal towards the tool, overlap > 0)
  template <class Visit>
  void visit(const VectorX& x, const Visit& visit) const {
    for (const Triangle& t : model_.mesh().triangles) {
      const Vec3 a = node(x, t[0]), b = node(x, t[1]), c = node(x, t[2]);
      if (((a.cwiseMin(b).cwiseMin(c) - centre).array() > radius_).any() ||
          ((centre - a.cwiseMax(b).cwiseMax(c)).array() > radius_).any())
        continue;
      const ClosestPoint at = closest_point_on_triangle(centre, a, b, c);
      const double distance = std::sqrt(at.distance_sq);
      if (distance < radius_ && distance > 0) visit(t, at, Vec3((centre - at.point) / distance), radius_ - distance);
    }
  }

  const DeformableModel& model_;
  double radius_, stiffness_;
  const PressOptions& options_;
};

}  // namespace

PressResult press(const DeformableModel& model, const State& start, double radius, const Vec3& from, const Vec3& to,
                  const PressOptions& options) {
  constexpr double kConvergence = 1e-5;  // of the body's size: a thousandth of a depth worth pressing, by a method that
                                         // gains two digits a step
  constexpr double kImbalance = 0.01;    // of the force on the tool
  PressedModel pressed(model, radius, options);
  const auto equilibrium = make_integrator("quasistatic", {.solver = options.solver, .convergence = kConvergence});
  PressResult out{.state = start};
  const VectorX none = VectorX::Zero(start.x.size());
  for (int i = 1; i <= options.steps; ++i) {
    pressed.centre = from + i / static_cast<double>(options.steps) * (to - from);
    // A line search along a contact that comes and goes can stop short of the equilibrium: what is left decides.
    for (int again = 0; again < 6; ++again) {
      equilibrium->step(pressed, none, 0, out.state);
      if (pressed.imbalance(out.state) < kImbalance) break;
    }
  }
  std::tie(out.force, out.overlap) = pressed.push(out.state.x);
  out.iterations = equilibrium->statistics().iterations;
  out.converged = pressed.imbalance(out.state) < kImbalance;
  return out;
}

}  // namespace kt
