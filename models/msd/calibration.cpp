#include "models/msd/calibration.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "core/base/error.hpp"
#include "core/linear/free_dofs.hpp"
#include "core/linear/sparse_solver.hpp"

namespace kt {
namespace {

using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Gradients of the four linear shape functions [1/m] as columns.
Eigen::Matrix<double, 3, 4> shape_gradients(const VectorX& x, const Tetrahedron& t) {
  Mat3 edges;
  for (int c = 0; c < 3; ++c) edges.col(c) = node(x, t[c + 1]) - node(x, t[0]);
  const Mat3 inverse = edges.inverse();
  Eigen::Matrix<double, 3, 4> g;
  g.rightCols<3>() = inverse.transpose();
  g.col(0) = -g.rightCols<3>().rowwise().sum();
  return g;
}

/// -d^T K_ij d of each edge, K from linear tetrahedra; the block is lambda g_i g_j^T + mu (g_j g_i^T + (g_i.g_j) I).
std::vector<double> stiffness_along_edges(const Mesh& mesh, double young, double poisson,
                                          const std::vector<Spring>& springs) {
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), mu = young / (2 * (1 + poisson));
  std::map<std::pair<int, int>, std::size_t> spring_of;
  for (std::size_t s = 0; s < springs.size(); ++s) spring_of[{springs[s].a, springs[s].b}] = s;
  std::vector<double> k(springs.size(), 0);
  for (const Tetrahedron& t : mesh.tetrahedra) {
    const double volume = std::abs(tetrahedron_volume(mesh.x, t));
    const auto g = shape_gradients(mesh.x, t);
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) {
        const Vec3 d = (node(mesh.x, t[j]) - node(mesh.x, t[i])).normalized();
        const double gi = g.col(i).dot(d), gj = g.col(j).dot(d);
        k[spring_of.at(std::minmax(t[i], t[j]))] -= volume * ((lambda + mu) * gi * gj + mu * g.col(i).dot(g.col(j)));
      }
  }
  return k;
}

/// Surfaces without a volume: the membrane's stiffness cannot come from tetrahedra, so every edge is alike.
Calibration uniform_membrane(double young, std::vector<Spring>& springs) {
  for (Spring& s : springs) s.stiffness = young * s.rest_length;
  return {1, 1, 1};
}

SparseMatrix rest_stiffness(int n, const Mesh& mesh, const std::vector<Spring>& springs) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const Spring& s : springs) {
    const Vec3 d = (node(mesh.x, s.b) - node(mesh.x, s.a)) / s.rest_length;
    const Mat3 k = s.stiffness * d * d.transpose();
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        entries.emplace_back(3 * s.a + r, 3 * s.a + c, k(r, c));
        entries.emplace_back(3 * s.b + r, 3 * s.b + c, k(r, c));
        entries.emplace_back(3 * s.a + r, 3 * s.b + c, -k(r, c));
        entries.emplace_back(3 * s.b + r, 3 * s.a + c, -k(r, c));
      }
  }
  SparseMatrix out(3 * n, 3 * n);
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

Mat3 unit_strain(int i) {
  constexpr int kRow[6] = {0, 1, 2, 1, 0, 0}, kColumn[6] = {0, 1, 2, 2, 2, 1};
  Mat3 e = Mat3::Zero();
  e(kRow[i], kColumn[i]) += i < 3 ? 1.0 : 0.5;  // engineering shear: gamma = 1
  if (i >= 3) e(kColumn[i], kRow[i]) += 0.5;
  return e;
}

}  // namespace

Mat6 isotropic_elasticity(double young, double poisson) {
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), mu = young / (2 * (1 + poisson));
  Mat6 c = Mat6::Zero();
  c.topLeftCorner<3, 3>().setConstant(lambda);
  c.diagonal() += (Eigen::Matrix<double, 6, 1>() << 2 * mu, 2 * mu, 2 * mu, mu, mu, mu).finished();
  return c;
}

IsotropicSolid nearest_isotropic(const Mat6& c) {
  const double normal = c.topLeftCorner<3, 3>().sum();  // C_iijj, and C_ijij
  const double all = c.diagonal().head<3>().sum() + 2 * c.diagonal().tail<3>().sum();
  const double bulk = normal / 9, shear = (3 * all - normal) / 30;
  return {9 * bulk * shear / (3 * bulk + shear), (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear))};
}

Mat6 network_elasticity(const Mesh& mesh, const std::vector<Spring>& springs, const std::vector<double>& share) {
  const int n = mesh.num_nodes();
  const SparseMatrix stiffness = rest_stiffness(n, mesh, springs);
  MatrixX u(3 * n, 6);
  for (int strain = 0; strain < 6; ++strain)
    for (int i = 0; i < n; ++i) u.col(strain).segment<3>(3 * i) = unit_strain(strain) * node(mesh.x, i);

  std::vector<int> boundary;
  for (const Triangle& t : mesh.triangles) boundary.insert(boundary.end(), t.begin(), t.end());
  const FreeDofs inner = make_free_dofs(n, boundary);
  if (inner.size() > 0) {
    SparseMatrix system = gather(inner, stiffness);
    const double shift =
        1e-9 * VectorX(system.diagonal()).maxCoeff();  // an inner node may hang on one plane of springs
    for (int i = 0; i < inner.size(); ++i) system.coeffRef(i, i) += shift;
    const auto solver = make_sparse_solver();
    if (!solver->factor(system)) throw RunError("msd calibration: the inner network is not rigid");
    const MatrixX force = stiffness * u;
    MatrixX rhs(inner.size(), 6);
    for (int i = 0; i < inner.size(); ++i) rhs.row(i) = force.row(inner.to_all[i]);
    const MatrixX relax = solver->solve(rhs);
    for (int i = 0; i < inner.size(); ++i) u.row(inner.to_all[i]) -= relax.row(i);
  }
  double volume = 0;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    volume += (share.empty() ? 1 : share[t]) * std::abs(tetrahedron_volume(mesh.x, mesh.tetrahedra[t]));
  return u.transpose() * (stiffness * u) / volume;
}

namespace {

/// Scales all springs to the target, least squares, and says how well they then match.
Calibration scale_to_target(const Mesh& mesh, double young, double poisson, const std::vector<double>& share,
                            std::vector<Spring>& springs) {
  const Mat6 target = isotropic_elasticity(young, poisson);
  Mat6 network = network_elasticity(mesh, springs, share);
  const double scale = network.cwiseProduct(target).sum() / network.squaredNorm();
  for (Spring& s : springs) s.stiffness *= scale;
  network *= scale;
  Calibration out;
  out.residual = (network - target).norm() / target.norm();
  const Mat6 compliance = network.inverse();
  out.young_error = (1 / compliance(0, 0) + 1 / compliance(1, 1) + 1 / compliance(2, 2)) / (3 * young) - 1;
  out.shear_error = (network(3, 3) + network(4, 4) + network(5, 5)) / (3 * target(3, 3)) - 1;
  return out;
}

/// Shape 1: the part of the FEM stiffness that acts along each edge. Obtuse and right-angled tetrahedra give edges that
/// push or do nothing; a spring keeps a tenth of the mean.
void shape_from_stiffness(const Mesh& mesh, double young, double poisson, std::vector<Spring>& springs) {
  const std::vector<double> k = stiffness_along_edges(mesh, young, poisson, springs);
  double mean = 0;
  for (double value : k) mean += std::max(0.0, value);
  mean /= static_cast<double>(k.size());
  for (std::size_t s = 0; s < springs.size(); ++s) springs[s].stiffness = std::max(k[s], 0.1 * mean);
}

/// Shape 2: the volume around each edge by its length squared (Van Gelder 1998).
void shape_from_volume(const Mesh& mesh, double young, std::vector<Spring>& springs) {
  std::map<std::pair<int, int>, double> volume;
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) volume[std::minmax(t[i], t[j])] += std::abs(tetrahedron_volume(mesh.x, t));
  double mean = 0;
  for (Spring& s : springs) {
    s.stiffness = young * volume[{s.a, s.b}] / (s.rest_length * s.rest_length);
    mean += s.stiffness / static_cast<double>(springs.size());
  }
  // An edge of the surface that no tetrahedron has, as of a triangle without area, holds what it connects all the same.
  for (Spring& s : springs)
    if (s.stiffness == 0) s.stiffness = 0.1 * mean;
}

}  // namespace

Calibration calibrate_springs(const Mesh& mesh, double young, double poisson, std::vector<Spring>& springs,
                              const std::vector<double>& share) {
  if (mesh.tetrahedra.empty()) return uniform_membrane(young, springs);
  // Neither shape wins on every mesh: free meshes favour the first, regular blocks the second.
  std::vector<Spring> other = springs;
  shape_from_stiffness(mesh, young, poisson, springs);
  shape_from_volume(mesh, young, other);
  stiffen(mesh, share, springs);
  stiffen(mesh, share, other);
  const Calibration first = scale_to_target(mesh, young, poisson, share, springs);
  const Calibration second = scale_to_target(mesh, young, poisson, share, other);
  if (first.residual <= second.residual) return first;
  springs = std::move(other);
  return second;
}

}  // namespace kt
