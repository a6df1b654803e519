#include "models/msd/volume_guard.hpp"

#include <map>

namespace kt {
namespace {

constexpr double kStiffer = 4;  // than the mean of its edges, along its height

struct Volume {
  double value = 0;                      // [m^3]
  Eigen::Matrix<double, 3, 4> gradient;  // by its nodes [m^2]
  std::array<Vec3, 3> edge;              // from the first node
};

Volume volume_of(const Tetrahedron& t, const VectorX& x) {
  Volume out;
  for (int k = 0; k < 3; ++k) out.edge[k] = node(x, t[k + 1]) - node(x, t[0]);
  const auto& e = out.edge;
  for (int k = 0; k < 3; ++k) out.gradient.col(k + 1) = e[(k + 1) % 3].cross(e[(k + 2) % 3]) / 6;
  out.gradient.col(0) = -out.gradient.rightCols<3>().rowwise().sum();
  out.value = e[0].dot(out.gradient.col(1));
  return out;
}

Mat3 cross_matrix(const Vec3& v) {
  Mat3 out;
  out << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return out;
}

/// Second derivative of the volume, 12 x 12.
Eigen::Matrix<double, 12, 12> volume_hessian(const Volume& v) {
  Eigen::Matrix<double, 12, 12> h = Eigen::Matrix<double, 12, 12>::Zero();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3, after = (k + 2) % 3;  // gradient of k: edge next x edge after
    h.block<3, 3>(3 * (k + 1), 3 * (next + 1)) = -cross_matrix(v.edge[after]) / 6;
    h.block<3, 3>(3 * (k + 1), 3 * (after + 1)) = cross_matrix(v.edge[next]) / 6;
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
    const Volume rest = volume_of(t, mesh.x);
    if (!(rest.value > 0)) continue;
    double mean = 0;
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) mean += stiffness.at(std::minmax(t[i], t[j])) / 6;
    out.push_back({t, share * rest.value, kStiffer * mean / rest.gradient.squaredNorm()});
  }
  return out;
}

bool guard_force(const VolumeGuard& guard, const VectorX& x, Eigen::Matrix<double, 3, 4>& force) {
  const Volume now = volume_of(guard.nodes, x);
  if (now.value >= guard.least) return false;
  force = guard.stiffness * (guard.least - now.value) * now.gradient;
  return true;
}

bool guard_force(const VolumeGuard& guard, const VectorX& x, bool definite, GuardForce& out) {
  const Volume now = volume_of(guard.nodes, x);
  if (now.value >= guard.least) return false;
  const double push = guard.stiffness * (guard.least - now.value);
  out.force = push * now.gradient;
  const Eigen::Map<const Eigen::Matrix<double, 12, 1>> gradient(now.gradient.data());
  out.dfdx = -guard.stiffness * gradient * gradient.transpose();
  if (!definite) out.dfdx += push * volume_hessian(now);
  out.dfdx = out.dfdx.selfadjointView<Eigen::Lower>().toDenseMatrix();  // to the last bit, as the springs'
  return true;
}

}  // namespace kt
