// Momentum and energy: a body's own forces neither push nor turn it, are what their tangent says, and give back no more
// than was put in.
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "core/body/state.hpp"
#include "core/global/integrator.hpp"
#include "lab/check/mesh_work.hpp"

namespace kt {
namespace {

constexpr double kMomentum = 1e-8;  // of the sum of the forces' sizes; and of their moments'
constexpr double kTangent = 1e-4;   // of the difference quotient
constexpr double kEnergy = 1e-6;    // of the kinetic energy given

/// A smooth motion of the whole body, the same for every mesh of one size. Not a whole number of waves fits: a cube,
/// whose corners are its only nodes, would be moved as a rigid body.
VectorX wave(const VectorX& x, double amplitude, double phase) {
  VectorX out(x.size());
  const double k = 0.618 * 2 * 3.141592653589793 / kBodySize;
  for (int i = 0; i < static_cast<int>(x.size() / 3); ++i) {
    const Vec3 p = node(x, i);
    node(out, i) =
        amplitude * Vec3(std::sin(k * p.y() + phase), std::sin(k * p.z() + 2 * phase), std::sin(k * p.x() + 3 * phase));
  }
  return out;
}

struct Sums {
  double force = 0, moment = 0;  ///< of the sum / of the sizes
};

Sums sums_of(const VectorX& x, const VectorX& f) {
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  double forces = 0, moments = 0;
  for (int i = 0; i < static_cast<int>(x.size() / 3); ++i) {
    const Vec3 p = node(x, i), n = node(f, i), m = p.cross(n);
    force += n;
    moment += m;
    forces += n.norm();
    moments += m.norm();
  }
  return {forces > 0 ? force.norm() / forces : 0, moments > 0 ? moment.norm() / moments : 0};
}

/// Relative difference of the tangent and the forces' difference quotient along a motion.
double tangent_error(const DeformableModel& model, const State& state, const VectorX& motion) {
  const Tangent tangent = model.tangent(state, TangentKind::exact);
  constexpr double kStep = 1e-3;  // of the motion
  State there = state, back = state;
  there.x += kStep * motion;
  back.x -= kStep * motion;
  VectorX f_there, f_back;
  model.force(there, f_there);
  model.force(back, f_back);
  const VectorX quotient = (f_there - f_back) / (2 * kStep), product = tangent.dfdx * motion;
  return (quotient - product).norm() / std::max(quotient.norm(), 1e-300);
}

/// Of a body that is let go at rest with a velocity: the largest kinetic energy after, over the one given.
double kinetic_growth(const DeformableModel& model) {
  constexpr double kStep = 1e-3;
  constexpr int kSteps = 20;
  State state = rest_state(model);
  state.v = wave(state.x, 0.05, 0.3);
  for (const int i : model.fixed_nodes()) node(state.v, i).setZero();
  const auto kinetic = [&] { return 0.5 * state.v.dot(model.mass() * state.v); };
  const double given = kinetic();
  const auto integrator = make_integrator("implicit_euler");
  const VectorX none = VectorX::Zero(state.x.size());
  double largest = 0;
  for (int i = 0; i < kSteps; ++i) {
    integrator->step(model, none, kStep, state);
    largest = std::max(largest, kinetic());
  }
  return given > 0 ? largest / given : 0;
}

}  // namespace

void check_energy(MeshWork& work, StageResult& out) {
  for (const CheckBody& body : work.bodies) {
    const DeformableModel& model = body.session->model().own();
    State state = rest_state(model);
    // As large as leaves the smallest element its sense: a wave of 1 % strain.
    state.x += wave(state.x, 0.01 * kBodySize / 6.28, 0.7);
    VectorX f;
    model.force(state, f);
    const Sums sums = sums_of(state.x, f);
    const double tangent = tangent_error(model, state, wave(state.x, 1e-4 * kBodySize, 1.9)),
                 growth = kinetic_growth(model);
    out.figures[body.model] = {
        {"force_sum", sums.force}, {"moment_sum", sums.moment}, {"tangent_error", tangent}, {"kinetic_growth", growth}};
    if (!(sums.force < kMomentum) || !(sums.moment < kMomentum))
      out.lower(Verdict::fail, told(body.model, ": its own forces push or turn the body: sum ", sums.force, ", moment ",
                                    sums.moment, " of their sizes"));
    if (!(tangent < kTangent))
      out.lower(Verdict::fail, told(body.model, ": the tangent is off the forces' difference quotient by ", tangent));
    if (!(growth < 1 + kEnergy))
      out.lower(Verdict::fail, told(body.model, ": a body let go has ", growth, " of the kinetic energy given to it"));
  }
}

}  // namespace kt
