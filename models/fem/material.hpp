#pragma once
// Hyperelastic materials: energy density, stress and tangent as functions of the deformation gradient F.
// Backends: materials.def; a new material is one file in materials/ and one line.
#include <memory>
#include <span>
#include <string>

#include "core/base/backend.hpp"
#include "models/fem/deformation.hpp"

namespace kt {

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

}  // namespace kt
