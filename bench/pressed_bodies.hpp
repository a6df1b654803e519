#pragma once
// Soft bodies that touch one another or themselves: the scenes that self-contact is measured and tested on.
#include <functional>
#include <numbers>

#include "core/global/held_model.hpp"
#include "models/model.hpp"
#include "self_contact/touching_euler.hpp"

namespace kt {

/// A body of one or several pieces, some of whose surface triangles are led along a path by stiff springs.
struct PressedBodies {
  std::string name;
  std::unique_ptr<DeformableModel> model;
  std::vector<ContactHold> holds;                        ///< at t = 0
  std::function<Vec3(double t, const Vec3& from)> lead;  ///< where a held point is at time t [m]
  double dt = 0.01;
  State state;

  std::vector<ContactHold> holds_at(double t) const {
    std::vector<ContactHold> out = holds;
    for (ContactHold& hold : out) hold.point = lead(t, hold.point);
    return out;
  }
  /// One global step; the holds lead the body along. They are the only forces from outside besides the fixed nodes'.
  void step(TouchingEuler& integrator) {
    const std::vector<ContactHold> now = holds_at(state.t + dt);
    const HeldModel held(*model, now, 200);
    integrator.step(held, VectorX::Zero(state.x.size()), dt, state);
  }
};

inline Mesh placed(Mesh mesh, const Vec3& by) {
  for (int i = 0; i < mesh.num_nodes(); ++i) node(mesh.x, i) += by;
  return mesh;
}

inline Mesh joined(const std::vector<Mesh>& parts) {
  Mesh out;
  for (const Mesh& part : parts) {
    const int first = out.num_nodes();
    VectorX x(out.x.size() + part.x.size());
    x << out.x, part.x;
    out.x = x;
    for (Triangle t : part.triangles) {
      for (int& i : t) i += first;
      out.triangles.push_back(t);
    }
    for (Tetrahedron t : part.tetrahedra) {
      for (int& i : t) i += first;
      out.tetrahedra.push_back(t);
    }
  }
  return out;
}

/// Holds at the middle of the surface triangles that `chosen` takes, at their rest positions.
inline std::vector<ContactHold> hold_triangles(const Mesh& mesh, const std::function<bool(const Vec3&)>& chosen) {
  std::vector<ContactHold> out;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = node(mesh.x, t[0]), b = node(mesh.x, t[1]), c = node(mesh.x, t[2]), middle = (a + b + c) / 3;
    if (!chosen(middle)) continue;
    out.push_back({.moves = {t, Vec3::Constant(1. / 3)},
                   .normal = (b - a).cross(c - a).normalized(),
                   .point = middle,
                   .sticks = true});
  }
  return out;
}

inline PressedBodies make_pressed(std::string name, Mesh mesh, const std::function<bool(const Vec3&)>& fixed,
                                  const std::function<bool(const Vec3&)>& held, Vec3 gravity = Vec3::Zero()) {
  ModelOptions options{.young = 2e4, .poisson = 0.4, .density = 1000, .damping_stiffness = 2e-3};
  options.material = "neo_hookean";
  options.gravity = gravity;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (fixed(node(mesh.x, i))) options.fixed_nodes.push_back(i);
  PressedBodies out;
  out.name = std::move(name);
  out.holds = hold_triangles(mesh, held);
  out.model = make_model("fem", std::move(mesh), options);
  out.state = rest_state(*out.model);
  out.lead = [](double, const Vec3& from) { return from; };
  return out;
}

/// Two blocks, 40 x 40 x 20 mm: the upper one is pressed 3 mm into the lower one, then sheared to and fro by 10 mm.
inline PressedBodies sheared_blocks(int cells = 8) {
  const double h = 0.04 / cells, top = cells / 2 * h;
  const Mesh block = kuhn_block(cells, cells, cells / 2, h);
  PressedBodies out = make_pressed(
      "two blocks, pressed and sheared", joined({block, placed(block, {0.1 * h, 0.2 * h, top + 2e-4})}),
      [=](const Vec3& x) { return x.z() < 1e-9; }, [=](const Vec3& x) { return x.z() > 2 * top + 1e-4; });
  out.lead = [](double t, const Vec3& from) {
    const double down = std::min(1.0, t / 0.5), across = std::max(0.0, t - 0.5);
    return Vec3(from + Vec3(0.01 * std::sin(2 * std::numbers::pi * 0.5 * across), 0, -0.0032 * down));
  };
  return out;
}

/// A sheet, 60 x 20 x 2.5 mm, clamped at one end: the other end is led round onto it, pressed and rubbed along.
inline PressedBodies folded_sheet(int cells = 24) {
  const double h = 0.06 / cells, length = cells * h;
  PressedBodies out = make_pressed(
      "a sheet folded onto itself", kuhn_block(cells, cells / 3, 1, h), [=](const Vec3& x) { return x.x() < 2.1 * h; },
      [=](const Vec3& x) { return x.x() > length - 2.1 * h && x.z() > h - 1e-9; });
  out.lead = [=](double t, const Vec3& from) {
    // The end turns by half a circle until its upper side lies on the sheet, is pressed, and goes to and fro.
    const double turn = std::numbers::pi * std::min(1.0, t / 3), r = 0.5 * length, press = std::clamp(t - 3, 0.0, 0.5);
    Vec3 to(r + (from.x() - r) * std::cos(turn), from.y(),
            h * (1 + 0.2 * std::sin(0.5 * turn) - press) + 0.5 * (from.x() - r) * std::sin(turn));
    if (t > 3.5) to += Vec3(0.004 * (1 - std::cos(2 * (t - 3.5))), 0.002 * std::sin(3 * (t - 3.5)), 0);
    return to;
  };
  return out;
}

/// Three blocks, one on the other, the lowest clamped: the others fall 1 mm and are pushed to and fro by tilting
/// gravity.
inline PressedBodies stacked_blocks(int cells = 6) {
  const double h = 0.03 / cells, step = cells / 2 * h + 1e-3;
  const Mesh block = kuhn_block(cells, cells, cells / 2, h);
  return make_pressed(
      "a stack of three",
      joined({block, placed(block, {0.001, 0.0007, step}), placed(block, {-0.001, 0.0012, 2 * step})}),
      [](const Vec3& x) { return x.z() < 1e-9; }, [](const Vec3&) { return false; }, {1.0, 0.3, -9.81});
}

/// Two blocks in free flight that hit one another off centre: nothing acts from outside.
inline PressedBodies flying_blocks(int cells = 6) {
  const double h = 0.03 / cells;
  const Mesh block = kuhn_block(cells, cells, cells / 2, h);
  PressedBodies out = make_pressed(
      "two blocks in flight", joined({block, placed(block, {0.4 * 0.03, 0.003, 0.02})}),
      [](const Vec3&) { return false; }, [](const Vec3&) { return false; });
  const int half = out.model->mesh().num_nodes() / 2;
  for (int i = 0; i < 2 * half; ++i) node(out.state.v, i).z() = i < half ? 0.15 : -0.15;
  return out;
}

}  // namespace kt
