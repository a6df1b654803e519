#include "core/body/cut_tetrahedron.hpp"

#include <Eigen/LU>
#include <cmath>

namespace kt {
namespace {

using Eigen::Vector4d;

/// Where the function is zero between a corner that has it positive and one that has not.
Vector4d crossing(const Vector4d& depth, int in, int out) {
  const double t = depth[in] / (depth[in] - depth[out]);
  return (1 - t) * Vector4d::Unit(in) + t * Vector4d::Unit(out);
}

Vector4d piece(const Vector4d& a, const Vector4d& b, const Vector4d& c, const Vector4d& d) {
  Eigen::Matrix4d corners;
  corners << a, b, c, d;
  return 0.25 * std::abs(corners.determinant()) * (a + b + c + d);
}

/// Around the only corner where it is positive.
Vector4d corner_piece(const Vector4d& depth, int in) {
  double share = 1;
  Vector4d sum = Vector4d::Unit(in);
  for (int out = 0; out < 4; ++out) {
    if (out == in) continue;
    share *= depth[in] / (depth[in] - depth[out]);
    sum += crossing(depth, in, out);
  }
  return 0.25 * share * sum;
}

}  // namespace

Vector4d cut_tetrahedron(const Vector4d& depth) {
  std::array<int, 4> in{}, out{};
  int ins = 0, outs = 0;
  for (int i = 0; i < 4; ++i)
    (depth[i] > 0 ? in[static_cast<std::size_t>(ins++)] : out[static_cast<std::size_t>(outs++)]) = i;
  if (ins == 4) return Vector4d::Constant(0.25);
  if (ins == 0) return Vector4d::Zero();
  if (ins == 1) return corner_piece(depth, in[0]);
  if (ins == 3) return Vector4d::Constant(0.25) - corner_piece(-depth, out[0]);
  const Vector4d a = Vector4d::Unit(in[0]), b = Vector4d::Unit(in[1]);
  const Vector4d ac = crossing(depth, in[0], out[0]), ad = crossing(depth, in[0], out[1]),
                 bc = crossing(depth, in[1], out[0]), bd = crossing(depth, in[1], out[1]);
  return piece(a, ac, ad, bd) + piece(a, ac, bc, bd) + piece(a, b, bc, bd);
}

}  // namespace kt
