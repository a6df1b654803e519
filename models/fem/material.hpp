#pragma once
// Hyperelastic materials: energy density, stress and tangent as functions of the deformation gradient F.
// Backends: materials.def; a new material is one file in materials/ and one line.
#include <memory>
#include <string>

#include "core/backend.hpp"
#include "core/types.hpp"

namespace kt {

using Mat9 = Eigen::Matrix<double, 9, 9>;

/// F and everything derived from it as vectors: column-major, (F00 F10 F20 F01 ...).
inline auto flat(const Mat3& m) { return m.reshaped(); }

/// Rest gradients of an element's shape functions at a point, one column each, (3 x N) [1/m].
using Gradients = Eigen::Ref<const Eigen::Matrix3Xd>;

/// Lame constants of an isotropic solid [Pa].
struct Lame {
  double lambda = 0, mu = 0;
};
Lame lame(double young, double poisson);

/// Const and without state: one object serves all elements and threads.
class Material {
 public:
  virtual ~Material() = default;
  /// Energy per rest volume [J/m^3]. F = I has zero stress in every material.
  virtual double energy(const Mat3& F) const = 0;
  /// First Piola-Kirchhoff stress P = d energy / dF [Pa].
  virtual Mat3 stress(const Mat3& F) const = 0;
  /// dP/dF [Pa], (9 x 9), symmetric: flat(dP) = tangent flat(dF).
  virtual Mat9 tangent(const Mat3& F) const = 0;
  /// Positive semidefinite and equal to the exact one at rest. Here the nearest such matrix: negative eigenvalues are
  /// set to zero.
  virtual Mat9 definite_tangent(const Mat3& F) const;
  /// stiffness(3a + i, 3b + k) += volume sum_jl dP(ij, kl) g_a[j] g_b[l] for all nodes a, b, (3N x 3N) [N/m], with dP
  /// the exact or the definite tangent. Here the plain contraction; overridden where the tangent's form makes it short.
  virtual void add_stiffness(const Mat3& F, bool definite, const Gradients& g, double volume,
                             Eigen::Ref<MatrixX> stiffness) const;
  /// Rotating the whole body gives no force; false for the linear material only.
  virtual bool is_frame_indifferent() const { return true; }
};

std::vector<BackendInfo> material_backends();

/// Throws InputError for an unknown name.
std::unique_ptr<Material> make_material(const std::string& name, const Lame& lame);

void add_contracted(const Mat9& dP, const Gradients& g, double volume, Eigen::Ref<MatrixX> stiffness);

/// a x b = cross_matrix(a) b.
inline Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

/// The rotation of F = R S with det R = +1 and S symmetric, also for an inverted F (then its smallest eigenvalue is
/// negative).
Mat3 rotation_of(const Mat3& F);

/// Matrix of cofactors, det(F) F^-T, defined for singular F too: dJ/dF.
Mat3 cofactor(const Mat3& F);

/// d cofactor / dF, (9 x 9): the second derivative of the determinant.
Mat9 cofactor_tangent(const Mat3& F);

}  // namespace kt
