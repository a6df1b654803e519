#pragma once
// How a body answers a force that swings at one patch vertex: u = C(w) f, (3 x 3 complex) [m/N]. Its inverse, the
// contact impedance, is what a tool feels; how far a local model's is off certifies the model.
// docs/method.md#4-the-local-model-section-iii
#include <complex>
#include <span>

#include "core/local/subspace.hpp"

namespace kt {

using ComplexMat3 = Eigen::Matrix<std::complex<double>, 3, 3>;

/// Of the local model, at patch vertices that can move. @param hz  >= 0
std::vector<ComplexMat3> compliances(const LocalModel& model, std::span<const int> vertices, double hz);
inline ComplexMat3 compliance(const LocalModel& model, int vertex, double hz) {
  return compliances(model, std::span(&vertex, 1), hz).front();
}

/// Of the whole linearized body at a free node: one real factorization for each frequency, for all nodes that are then
/// asked for. It preconditions the complex system, which no real solver takes.
class BodyCompliance {
 public:
  /// Throws RunError when M (2 pi hz)^2 + D 2 pi hz + K is not positive definite.
  BodyCompliance(const FreeBody& body, double hz);
  ~BodyCompliance();
  /// @param rest  of the load [-] that may be left unbalanced; its square is the error's order
  /// Throws RunError when that is not reached.
  std::vector<ComplexMat3> at(std::span<const int> nodes, double rest = 1e-9) const;
  ComplexMat3 at(int node) const { return at(std::span(&node, 1)).front(); }

 private:
  struct System;
  const FreeBody& body_;
  std::unique_ptr<System> system_;
};

/// |Z - Z_body| / |Z_body| of the impedances Z = C^-1 (Frobenius).
double impedance_error(const ComplexMat3& compliance, const ComplexMat3& body_compliance);

}  // namespace kt
