#include "tests/support/axisymmetric_press.hpp"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace kt {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using Shape = Eigen::Matrix<double, 8, 1>;

constexpr double kGrowth = 1.15;                               // of one cell to the next, outside
constexpr double kFine = 1.5;                                  // contact radii of equal cells
const double kGauss[] = {-std::sqrt(0.6), 0, std::sqrt(0.6)};  // three points
constexpr double kWeight[] = {5.0 / 9, 8.0 / 9, 5.0 / 9};      // and their weights
constexpr int kCorner[8][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {0, -1}, {1, 0}, {0, 1}, {-1, 0}};

/// Equal cells, and then growing ones up to `length`.
std::vector<double> graded(double cell, double fine, double length) {
  std::vector<double> out{0};
  for (double h = cell; out.back() < length; h *= out.back() > fine ? kGrowth : 1) out.push_back(out.back() + h);
  const double last = out.back();
  for (double& x : out) x *= length / last;
  return out;
}

Shape shape(double s, double t) {
  Shape n;
  for (int i = 0; i < 8; ++i) {
    const double a = kCorner[i][0], b = kCorner[i][1];
    if (a != 0 && b != 0)
      n[i] = 0.25 * (1 + a * s) * (1 + b * t) * (a * s + b * t - 1);
    else if (a == 0)
      n[i] = 0.5 * (1 - s * s) * (1 + b * t);
    else
      n[i] = 0.5 * (1 - t * t) * (1 + a * s);
  }
  return n;
}

/// By s and by t.
std::array<Shape, 2> slopes(double s, double t) {
  std::array<Shape, 2> d;
  for (int i = 0; i < 8; ++i) {
    const double a = kCorner[i][0], b = kCorner[i][1];
    if (a != 0 && b != 0) {
      d[0][i] = 0.25 * a * (1 + b * t) * (2 * a * s + b * t);
      d[1][i] = 0.25 * b * (1 + a * s) * (2 * b * t + a * s);
    } else if (a == 0) {
      d[0][i] = -s * (1 + b * t);
      d[1][i] = 0.5 * b * (1 - s * s);
    } else {
      d[0][i] = 0.5 * a * (1 - t * t);
      d[1][i] = -t * (1 + a * s);
    }
  }
  return d;
}

Eigen::Matrix4d stiffness_of(double young, double nu) {  // strains rr, zz, round, shear rz
  Eigen::Matrix4d d = Eigen::Matrix4d::Zero();
  d.topLeftCorner<3, 3>().setConstant(nu);
  d.diagonal() << 1 - nu, 1 - nu, 1 - nu, 0.5 - nu;
  return d * young / ((1 + nu) * (1 - 2 * nu));
}

/// Nodes of a grid of such cells: corners and the middles of edges. z goes down from the surface.
class Grid {
 public:
  Grid(const AxisymmetricPress& p) {
    const double contact = std::sqrt(p.radius * p.depth), cell = contact / p.cells;
    r_ = graded(cell, kFine * contact, p.width);
    z_ = graded(cell, 0.5 * contact, p.thickness);
    id_.assign((2 * r_.size() - 1) * (2 * z_.size() - 1), -1);
    for (int i = 0; i < num_r() * 2 + 1; ++i)
      for (int j = 0; j < num_z() * 2 + 1; ++j)
        if (i % 2 == 0 || j % 2 == 0) id_[place(i, j)] = count_++;
  }
  int num_r() const { return static_cast<int>(r_.size()) - 1; }
  int num_z() const { return static_cast<int>(z_.size()) - 1; }
  int num_nodes() const { return count_; }
  double r(int i) const { return r_[i]; }
  double z(int j) const { return z_[j]; }
  /// Of the cell (i, j), the one with a = b = 0 being its middle.
  int node(int i, int j, int a, int b) const { return id_[place(2 * i + 1 + a, 2 * j + 1 + b)]; }

 private:
  std::size_t place(int i, int j) const { return i * (2 * z_.size() - 1) + j; }
  std::vector<double> r_, z_;
  std::vector<int> id_;
  int count_ = 0;
};

Eigen::Matrix<double, 16, 16> cell_stiffness(const Grid& g, int i, int j, const Eigen::Matrix4d& d) {
  const double hr = 0.5 * (g.r(i + 1) - g.r(i)), hz = 0.5 * (g.z(j + 1) - g.z(j));
  Eigen::Matrix<double, 16, 16> k = Eigen::Matrix<double, 16, 16>::Zero();
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const double r = g.r(i) + hr * (1 + kGauss[a]);
      const Shape n = shape(kGauss[a], kGauss[b]);
      const auto dn = slopes(kGauss[a], kGauss[b]);
      Eigen::Matrix<double, 4, 16> strain = Eigen::Matrix<double, 4, 16>::Zero();
      for (int m = 0; m < 8; ++m) {
        strain(0, 2 * m) = strain(3, 2 * m + 1) = dn[0][m] / hr;
        strain(1, 2 * m + 1) = strain(3, 2 * m) = dn[1][m] / hz;
        strain(2, 2 * m) = n[m] / r;
      }
      k += 2 * std::numbers::pi * r * hr * hz * kWeight[a] * kWeight[b] * strain.transpose() * d * strain;
    }
  return k;
}

/// A place of the surface, and what moves it.
struct Place {
  double r = 0, area = 0;                        ///< [m], [m^2]
  std::array<std::pair<int, double>, 3> node{};  ///< of the top edge: node, weight
};

/// The ring of the surface between r_i and r_i+1, by its Gauss points.
std::array<Place, 3> ring(const Grid& g, int i) {
  std::array<Place, 3> out;
  const double h = 0.5 * (g.r(i + 1) - g.r(i));
  for (int a = 0; a < 3; ++a) {
    const double r = g.r(i) + h * (1 + kGauss[a]);
    const Shape n = shape(kGauss[a], -1);
    out[a] = {r, 2 * std::numbers::pi * r * h * kWeight[a], {}};
    int count = 0;
    for (int m = 0; m < 8; ++m)
      if (kCorner[m][1] == -1) out[a].node[count++] = {g.node(i, 0, kCorner[m][0], -1), n[m]};
  }
  return out;
}

/// Numbers of the free displacements (r, z of each node), -1 on the axis (r) and where the layer is bonded.
std::vector<int> number_free(const Grid& g) {
  std::vector<int> out(2 * g.num_nodes(), 0);
  for (int j = 0; j < g.num_z(); ++j)
    for (const int b : {-1, 0, 1}) out[2 * g.node(0, j, -1, b)] = -1;
  for (int i = 0; i < g.num_r(); ++i)
    for (const int a : {-1, 0, 1})
      for (const int axis : {0, 1}) out[2 * g.node(i, g.num_z() - 1, a, 1) + axis] = -1;
  int count = 0;
  for (int& n : out)
    if (n == 0) n = count++;
  return out;
}

/// Pressures p >= 0 with C p >= b, and C p = b where p > 0.
VectorXd complementary(const MatrixXd& c, const VectorXd& b, double& violation) {
  const Eigen::Index n = b.size();
  std::vector<bool> is_in(n);
  for (Eigen::Index i = 0; i < n; ++i) is_in[i] = b[i] > 0;
  VectorXd p;
  for (int sweep = 0; sweep < 200; ++sweep) {
    std::vector<Eigen::Index> in;
    for (Eigen::Index i = 0; i < n; ++i)
      if (is_in[i]) in.push_back(i);
    const MatrixXd active = c(in, in);
    const VectorXd rest = b(in), solved = active.llt().solve(rest);
    p = VectorXd::Zero(n);
    p(in) = solved;
    const VectorXd gap = c * p - b;
    violation = std::max(-p.minCoeff() / p.maxCoeff(), -gap.minCoeff() / b.maxCoeff());
    bool changed = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      const bool in_now = is_in[i] ? p[i] > 0 : gap[i] < -1e-12 * b.maxCoeff();
      changed |= in_now != is_in[i];
      is_in[i] = in_now;
    }
    if (!changed) break;
  }
  return p;
}

}  // namespace

AxisymmetricPressed press_axisymmetric(const AxisymmetricPress& press) {
  const Grid g(press);
  const std::vector<int> free = number_free(g);
  const Eigen::Index size = *std::ranges::max_element(free) + 1;
  std::vector<Eigen::Triplet<double>> entries;
  const Eigen::Matrix4d d = stiffness_of(press.young, press.poisson);
  for (int i = 0; i < g.num_r(); ++i)
    for (int j = 0; j < g.num_z(); ++j) {
      const auto k = cell_stiffness(g, i, j, d);
      std::array<int, 16> at{};
      for (int m = 0; m < 8; ++m)
        for (const int axis : {0, 1}) at[2 * m + axis] = free[2 * g.node(i, j, kCorner[m][0], kCorner[m][1]) + axis];
      for (int a = 0; a < 16; ++a)
        for (int b = 0; b < 16; ++b)
          if (at[a] >= 0 && at[b] >= 0) entries.emplace_back(at[a], at[b], k(a, b));
    }
  Eigen::SparseMatrix<double> k(size, size);
  k.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(k);

  std::vector<std::array<Place, 3>> rings;
  const double most = std::min(press.radius, kFine * std::sqrt(press.radius * press.depth));
  for (int i = 0; i < g.num_r() && g.r(i + 1) < most; ++i) rings.push_back(ring(g, i));
  const auto n = static_cast<Eigen::Index>(rings.size());
  const auto moved = [&](const Place& at, const VectorXd& u, int axis) {
    double sum = 0;
    for (const auto& [node, weight] : at.node)
      if (const int row = free[2 * node + axis]; row >= 0) sum += weight * u[row];
    return sum;
  };
  AxisymmetricPressed out{.unknowns = static_cast<int>(size)};
  VectorXd u = VectorXd::Zero(size);
  // r outwards, z down from the surface; the sphere's centre is above it. Each pass pushes along the sphere's normals
  // at the places of the last one.
  const double centre = press.depth - press.radius;
  for (int pass = 0; pass < (press.follows ? 12 : 1); ++pass) {
    MatrixXd loads = MatrixXd::Zero(size, n);
    VectorXd inside = VectorXd::Zero(n), lift = VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (const Place& at : rings[i]) {
        double nr = 0, nz = 1,
               overlap = press.depth - (press.radius - std::sqrt(press.radius * press.radius - at.r * at.r));
        if (press.follows) {
          const double r = at.r + moved(at, u, 0), z = moved(at, u, 1) - centre, away = std::hypot(r, z);
          nr = r / away;
          nz = z / away;
          overlap = press.radius - (nr * at.r - nz * centre);
        }
        inside[i] += at.area * overlap;
        lift[i] += at.area * nz;
        for (const auto& [node, weight] : at.node) {
          if (free[2 * node] >= 0) loads(free[2 * node], i) += at.area * weight * nr;
          if (free[2 * node + 1] >= 0) loads(free[2 * node + 1], i) += at.area * weight * nz;
        }
      }
    const MatrixXd answers = solver.solve(loads);
    const VectorXd pressure = complementary(loads.transpose() * answers, inside, out.violation);
    u = answers * pressure;
    out.change = std::abs(lift.dot(pressure) - out.force) / lift.dot(pressure);
    out.force = lift.dot(pressure);
    for (Eigen::Index i = 0; i < n; ++i)
      if (pressure[i] > 0) out.contact_radius = g.r(static_cast<int>(i) + 1);
    if (out.change < 1e-6) break;
  }
  return out;
}

}  // namespace kt
