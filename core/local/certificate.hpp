#pragma once
// How far off a local model is: relative error of the contact impedance, the 3 x 3 force per displacement that a tool
// feels at a patch vertex, against the whole linearized body, frequency by frequency. A person notices 7 to 10 % of
// force. docs/method.md#4-the-local-model-section-iii
#include <span>

#include "core/local/certified_rates.hpp"
#include "core/local/graded_body.hpp"
#include "core/local/impedance.hpp"

namespace kt {

struct Certificate {
  std::vector<double> hz;
  std::vector<double> error;  ///< relative, the worst of the vertices; NaN: not yet known
  double worst = 0;           ///< over all frequencies that are known
};

/// Patch vertices that can move and be touched (not on the rim, unless there are no others), spread over the patch, the
/// nearest to the site first, to those of further tools next: at most `count` local vertex numbers.
std::vector<int> certified_vertices(const LocalModel& model, const ContactSite& site, int count = 4);

/// Relative error of the model's impedance at a vertex. The model's own motion u of the whole body leaves a residual r
/// of the dynamic stiffness A, and C - C_model = r^T A^-1 r exactly (Galerkin, symmetric A), so that a rough solution
/// gives a good estimate of the error: A confined to the model's motions and a few more, to which the kept nodes, and
/// each other node on its own, answer the residual.
/// @param graded  just updated with the model's tangent and patch; for krylov, it made the model
/// @param model   its reducer must be krylov, condensed, wall or full
/// @param steps   where a model is off by 1 to 3 %, one leaves up to 1.5 % of the impedance, three 0.7 %, six 0.3 %;
/// two
///                are what a refresh can afford
double estimate_error(const GradedBody& graded, const LocalModel& model, int vertex, double hz, int steps = 2);

/// The body's side of a certificate, once for many local models of one patch.
class BodyCertificate {
 public:
  /// In full: one factorization of the whole body for each frequency.
  /// @param body      whole, of the tangent that the models are made from
  /// @param vertices  of the patch
  BodyCertificate(const FreeBody& body, const SurfacePatch& patch, std::vector<int> vertices,
                  std::span<const double> hz = kCertifiedHz);
  /// Estimated from the best local model at hand, for set-up. Frequencies at which the body has no finite answer (at
  /// rest, of one that is free to move) are not judged: their errors are NaN.
  BodyCertificate(const GradedBody& graded, const LocalModel& best, std::vector<int> vertices,
                  std::span<const double> hz = kCertifiedHz);
  Certificate certify(const LocalModel& model) const;

 private:
  std::vector<int> vertices_;
  std::vector<double> hz_;
  std::vector<std::vector<ComplexMat3>> compliance_;  ///< per frequency and vertex
};

/// Takes one sample a call, the next frequency each time and the next vertex each round, and keeps the latest of each.
class RunningCertificate {
 public:
  explicit RunningCertificate(std::vector<double> hz = {kCertifiedHz.begin(), kCertifiedHz.end()});
  const Certificate& sample(const GradedBody& graded, const LocalModel& model, const ContactSite& site);

 private:
  Certificate latest_;
  std::size_t calls_ = 0;
};

}  // namespace kt
