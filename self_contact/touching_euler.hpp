#pragma once
// Backward Euler for bodies that do not pass through themselves or one another.
#include <memory>

#include "core/global/integrator.hpp"
#include "self_contact/touching_model.hpp"

namespace kt {

/// Free of intersections after every step when it was before, converged or not. Friction is that of the contacts at the
/// start of each step. Whether the body intersects itself before the first step is not checked here: find_crossings()
/// does.
class TouchingEuler final : public Integrator {
 public:
  /// Borrows the contact, which one thread at a time may use.
  explicit TouchingEuler(SelfContact& contact, const IntegratorOptions& options = {});
  ~TouchingEuler() override;
  void step(const DeformableModel& model, const VectorX& external, double dt, State& state) override;
  double stable_step(const FastestMode& mode) const override;
  StepStatistics statistics() const override;
  const SelfContactReport& report() const { return report_; }  ///< of the last step

 private:
  SelfContact& contact_;
  std::unique_ptr<Integrator> newton_;
  SelfContactReport report_;
};

}  // namespace kt
