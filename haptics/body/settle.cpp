#include "haptics/body/settle.hpp"

#include <algorithm>

#include "core/base/numbers.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/global/integrator.hpp"
#include "self_contact/touching_euler.hpp"

namespace kt {
namespace {

/// A body that lies on itself has no equilibrium to solve for until it does: it falls, in long steps, which are damped.
State settled_by_falling(const BodyOptions& options, const DeformableModel& model, SelfContact& contact,
                         std::vector<Finding>& findings) {
  constexpr int kMostSteps = 100;
  constexpr double kStep = 0.03;  // [s]
  TouchingEuler integrator(contact, {.solver = options.global.solver, .tolerance = options.global.tolerance});
  State state = rest_state(model);
  const VectorX none = VectorX::Zero(state.x.size());
  double speed = 0;
  for (int i = 0; i < kMostSteps; ++i) {
    state.v.setZero();  // what it has fallen it has lost: only where it lies counts
    integrator.step(model, none, kStep, state);
    speed = state.v.lpNorm<Eigen::Infinity>();
    if (speed <= 0.01 * contact.options.creep) break;
  }
  if (speed > contact.options.creep)
    findings.push_back(Finding{told("object.gravity: after ", kMostSteps * kStep, " s the body still moves, at up to ",
                                    speed, " m/s: it starts where it is then, at rest")}
                           .at("object.gravity", speed, contact.options.creep));
  return {0, state.x, none};
}

/// Why a state is none that a body can hang in; empty when it is one.
std::string collapse(const DeformableModel& model, const VectorX& x) {
  constexpr double kMost = 1;  // of the body's longest extent: a rod bends through a right angle with less
  const Mesh& mesh = model.mesh();
  const auto inside_out =
      std::ranges::count_if(mesh.tetrahedra, [&](const Tetrahedron& t) { return tetrahedron_volume(x, t) < 0; });
  const double sag = (x - mesh.x).reshaped(3, mesh.num_nodes()).colwise().norm().maxCoeff();
  const double size = bounds(mesh).size().maxCoeff();
  if (inside_out == 0 && sag < kMost * size) return {};
  return told("it would sag by ", 1e3 * sag, " mm, ", sag / size, " of its size, with ", inside_out, " of ",
              mesh.tetrahedra.size(), " tetrahedra inside out");
}

/// The setting that holds a body up, and about how far it has to be raised.
Cure stiffer(const SceneObject& object, const Mesh& mesh) {
  constexpr double kShortened = 0.1;  // a column of this stiffness, by its own weight: rho g H / (2 E)
  const SceneModel& m = object.model;
  if (m.type == "msd" && m.stiffness) return advise(told("raise object.model.stiffness (", *m.stiffness, " N/m)"));
  const double height = bounds(mesh).size().dot(object.gravity.cwiseAbs()) / object.gravity.norm();
  const double enough = m.density * object.gravity.norm() * height / (2 * kShortened);
  const std::string young = short_number(std::max(enough, 3 * m.young));
  return {"object.model.young", young, told("raise object.model.young (", m.young, " Pa) to about ", young, " Pa")};
}

}  // namespace

State settle(const BodyOptions& options, const DeformableModel& model, SelfContact* self_contact,
             std::vector<Finding>& findings) {
  State state = rest_state(model);
  const SceneObject& object = options.object;
  if (object.gravity.isZero(0) || still_nodes(model).empty()) return state;
  std::string why;
  if (self_contact) {
    state = settled_by_falling(options, model, *self_contact, findings);
    why = collapse(model, state.x);
  } else {
    const auto equilibrium = make_integrator("quasistatic", {.solver = options.global.solver});
    try {
      equilibrium->step(model, VectorX::Zero(state.x.size()), 0, state);
      if (const auto& embedded = model.mesh().embedded) embedded->follow(state.x);
      why = equilibrium->statistics().not_converged > 0 ? "no equilibrium was found" : collapse(model, state.x);
    } catch (const RunError&) {
      why = "no equilibrium was found";
    }
  }
  if (why.empty()) return state;
  findings.push_back(Finding{
      told("object.gravity: the body does not bear its own weight: ", why, ": it starts undeformed and falls"),
      {stiffer(object, model.mesh()), advise("lower object.gravity"), advise("clamp more of it (object.fixed)")}}
                         .at("object.gravity"));
  return rest_state(model);
}

}  // namespace kt
