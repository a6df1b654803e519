#include "models/msd/volume_guard.hpp"

#include <array>
#include <map>

namespace kt {
namespace {

constexpr double kStiffer = 4;  // than the mean of its edges, along its height

using Edges = std::array<Vec3, 3>;  // from the first node
using Gradient = Eigen::Matrix<double, 3, 4>;

Edges edges_of(const Tetrahedron& t, const VectorX& x) {
  const Vec3 first = node(x, t[0]);
  return {node(x, t[1]) - first, node(x, t[2]) - first, node(x, t[3]) - first};
}

double volume_of(const Edges& e) { return e[0].dot(e[1].cross(e[2]) / 6); }

/// By the nodes [m^2].
Gradient volume_gradient(const Edges& e) {
  Gradient out;
  for (int k = 0; k < 3; ++k) out.col(k + 1) = e[(k + 1) % 3].cross(e[(k + 2) % 3]) / 6;
  out.col(0) = -out.rightCols<3>().rowwise().sum();
  return out;
}

Mat3 cross_matrix(const Vec3& v) {
  Mat3 out;
  out << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return out;
}

/// Second derivative of the volume, 12 x 12.
Eigen::Matrix<double, 12, 12> volume_hessian(const Edges& e) {
  Eigen::Matrix<double, 12, 12> h = Eigen::Matrix<double, 12, 12>::Zero();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3, after = (k + 2) % 3;  // gradient of k: edge next x edge after
    h.block<3, 3>(3 * (k + 1), 3 * (next + 1)) = -cross_matrix(e[after]) / 6;
    h.block<3, 3>(3 * (k + 1), 3 * (after + 1)) = cross_matrix(e[next]) / 6;
  }
  for (int k = 1; k < 4; ++k)
    for (int l = 1; l < 4; ++l) h.block<3, 3>(3 * k, 0) -= h.block<3, 3>(3 * k, 3 * l);
  for (int l = 0; l < 4; ++l)
    for (int k = 1; k < 4; ++k) h.block<3, 3>(0, 3 * l) -= h.block<3, 3>(3 * k, 3 * l);
  return h;
}

}  // namespace

std::vector<VolumeGuard> make_volume_guards(const Mesh& mesh, const std::vector<Spring>& springs, double share) {
  std::vector<VolumeGuard> out;
  if (share <= 0) return out;
  std::map<std::pair<int, int>, double> stiffness;
  for (const Spring& s : springs) stiffness[{s.a, s.b}] = s.stiffness;
  for (Tetrahedron t : mesh.tetrahedra) {
    if (tetrahedron_volume(mesh.x, t) < 0) std::swap(t[2], t[3]);
    const Edges edges = edges_of(t, mesh.x);
    const double rest = volume_of(edges);
    if (!(rest > 0)) continue;
    double mean = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) mean += stiffness.at(std::minmax(t[i], t[j])) / 6;
    out.push_back({t, share * rest, kStiffer * mean / volume_gradient(edges).squaredNorm()});
  }
  return out;
}

bool guard_force(const VolumeGuard& guard, const VectorX& x, Eigen::Matrix<double, 3, 4>& force) {
  const Edges edges = edges_of(guard.nodes, x);
  const double lacking = guard.least - volume_of(edges);
  if (lacking <= 0) return false;
  force = guard.stiffness * lacking * volume_gradient(edges);
  return true;
}

bool guard_force(const VolumeGuard& guard, const VectorX& x, bool definite, GuardForce& out) {
  const Edges edges = edges_of(guard.nodes, x);
  const double lacking = guard.least - volume_of(edges);
  if (lacking <= 0) return false;
  const double push = guard.stiffness * lacking;
  const Gradient gradient = volume_gradient(edges);
  out.force = push * gradient;
  const Eigen::Map<const Eigen::Matrix<double, 12, 1>> along(gradient.data());
  out.dfdx = -guard.stiffness * along * along.transpose();
  if (!definite) out.dfdx += push * volume_hessian(edges);
  out.dfdx = out.dfdx.selfadjointView<Eigen::Lower>().toDenseMatrix();  // to the last bit, as the springs'
  return true;
}

}  // namespace kt
