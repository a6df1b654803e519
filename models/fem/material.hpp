#pragma once
// Hyperelastic materials: energy density, stress and tangent as functions of the deformation gradient F.
// Backends: materials.def; a new material is one file in materials/ and one line.
#include <memory>
#include <span>
#include <string>

#include "core/backend.hpp"
#include "core/error.hpp"
#include "models/fem/lanes.hpp"

namespace kt {

using Mat9 = Eigen::Matrix<double, 9, 9>;

/// F and everything derived from it as vectors: column-major, (F00 F10 F20 F01 ...).
inline auto flat(const Mat3& m) { return m.reshaped(); }

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
  /// Four at once, as the model asks: what is above serves as default and to test against. Here lane by lane;
  /// overridden for speed.
  virtual LaneMat3 lane_stress(const LaneMat3& F) const;
  /// blocks(a, b)(i, k) += volume sum_jl dP(ij, kl) g_a[j] g_b[l] for all pairs a < b of `g` in the order (0,1) (0,2)
  /// (1,2) (0,3) ..., with dP the exact or the definite tangent. Here the plain contraction, lane by lane; overridden
  /// where the tangent's form makes it short.
  /// @param g  rest gradients of shape functions [1/m]
  virtual void add_lane_stiffness(const LaneMat3& F, bool definite, std::span<const LaneVec3> g, const Lanes& volume,
                                  std::span<LaneMat3> blocks) const;
  /// Rotating the whole body gives no force; false for the linear material only.
  virtual bool is_frame_indifferent() const { return true; }
};

std::vector<BackendInfo> material_backends();

/// Throws InputError for an unknown name.
std::unique_ptr<Material> make_material(const std::string& name, const Lame& lame);

/// m g_a for every node a of an element with at most 10.
using PerNode = std::array<LaneVec3, 10>;
inline PerNode per_node(const LaneMat3& m, std::span<const LaneVec3> g) {
  KT_ASSERT(g.size() <= std::tuple_size_v<PerNode>);
  PerNode out;
  for (std::size_t a = 0; a < g.size(); ++a) out[a] = m * g[a];
  return out;
}

/// out += diagonal I + [axis]x.
inline void add_identity_and_cross(const Lanes& diagonal, const LaneVec3& axis, LaneMat3& out) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out(i, i) += diagonal;
    out(k, j) += axis[i];
    out(j, k) -= axis[i];
  }
}

/// Matrix of cofactors, det(F) F^-T, defined for singular F too: dJ/dF.
template <class T>
Mat3Of<T> cofactor(const Mat3Of<T>& F) {
  Mat3Of<T> out;
  for (int i = 0; i < 3; ++i) out.col(i) = Vec3Of<T>(F.col((i + 1) % 3)).cross(Vec3Of<T>(F.col((i + 2) % 3)));
  return out;
}

/// Symmetric matrices without a negative eigenvalue, in every lane, by the leading minors: a positive shift of the
/// diagonal by the caller keeps minors of zero from hiding one.
inline bool is_definite(const LaneMat3& m) {
  const LaneMat3 minors = cofactor(m);
  return none_negative(m(0, 0)) && none_negative(minors(2, 2)) && none_negative(m.col(0).dot(minors.col(0)));
}

/// d cofactor / dF, (9 x 9): the second derivative of the determinant.
Mat9 cofactor_tangent(const Mat3& F);

/// The rotation of F = R S with det R = +1 and S symmetric, also for an inverted F (then its smallest eigenvalue is
/// negative).
Mat3 rotation_of(const Mat3& F);
LaneMat3 rotation_of(const LaneMat3& F);

}  // namespace kt
