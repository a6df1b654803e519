#include "core/held_model.hpp"

namespace kt {
namespace {

Vec3 offset(const ContactHold& hold, const VectorX& x) {
  Vec3 d = hold.point;
  for (int c = 0; c < 3; ++c) d -= hold.bary[c] * node(x, hold.nodes[c]);
  return d;
}

}  // namespace

HeldModel::HeldModel(const DeformableModel& model, std::span<const ContactHold> holds, double stiffness)
    : model_(model), holds_(holds), stiffness_(stiffness) {}

Mat3 HeldModel::spring(const ContactHold& hold) const {
  return stiffness_ * (hold.sticks ? Mat3(Mat3::Identity()) : Mat3(hold.normal * hold.normal.transpose()));
}

void HeldModel::force(const State& state, VectorX& out) const {
  model_.force(state, out);
  for (const ContactHold& hold : holds_) {
    const Vec3 f = spring(hold) * offset(hold, state.x);
    for (int c = 0; c < 3; ++c) node(out, hold.nodes[c]) += hold.bary[c] * f;
  }
}

void HeldModel::update_tangent(const State& state, TangentKind kind, Tangent& out) const {
  model_.update_tangent(state, kind, out);
  for (const ContactHold& hold : holds_) {
    const Mat3 k = spring(hold);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            out.dfdx.coeffRef(3 * hold.nodes[a] + r, 3 * hold.nodes[b] + c) -= hold.bary[a] * hold.bary[b] * k(r, c);
  }
}

double HeldModel::push(const VectorX& x) const {
  double sum = 0;
  for (const ContactHold& hold : holds_) sum -= stiffness_ * hold.normal.dot(offset(hold, x));
  return sum;
}

}  // namespace kt
