#pragma once
// Which reducer serves a scene: the one it names, or for "auto" the cheapest whose certified error stays under the
// tolerance and whose tick stays in the time budget; docs/method.md#4-the-local-model-section-iii.
#include <optional>

#include "core/certificate.hpp"
#include "core/reducer.hpp"

namespace kt {

/// A way to make local models, and what was found out about it at set-up.
struct ReducerCandidate {
  std::string reducer;
  ReduceOptions options;
  std::string name;  ///< "krylov {0, 200} Hz"
  int dof = 0;
  double error = 0;    ///< certified, 0-500 Hz, relative; infinity: it could not be made
  double tick_us = 0;  ///< predicted
  double cost_us = 0;  ///< predicted CPU time of both sides a haptic tick: the refreshes are most of it
};

struct ReducerNeeds {
  double tolerance = 0.05;         ///< largest certified error
  double budget_us = 200;          ///< of a haptic tick
  double refresh_per_tick = 0.03;  ///< global rate over haptic rate
  bool whole = false;              ///< no node follows others: they may be those of a piece that only touches its own
};

/// What local.reducer takes: core/reducers.def, and "auto".
std::vector<BackendInfo> reducer_names();

/// Index of the cheapest that needs no more than both; else, of those within the budget, the one with the least error
/// (the budget wins); else the cheapest of all. Candidates are not empty.
std::size_t choose_reducer(const std::vector<ReducerCandidate>& candidates, const ReducerNeeds& needs);

/// CPU time of a haptic tick in contact [us], from the sizes alone, so that the same scene chooses the same everywhere:
/// fitted to measured ticks (docs/accuracy_and_speed.md), right to within a factor of two.
double predict_tick_us(const LocalModel& model);
/// The same of a refresh [us].
double predict_refresh_us(const LocalModel& model, const ReduceOptions& options);

class ReducerChoice {
 public:
  /// @param reducer  a name in core/reducers.def, or "auto"
  ReducerChoice(const std::string& reducer, int rings, const ReducerNeeds& needs);

  /// Certifies the named reducer, or all candidates of "auto", and takes one. Once, at set-up.
  void set_up(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site);

  /// A local model by the present reducer.
  LocalModel reduce(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site);

  /// One more sample of the certificate for a model that reduce() made just now; "auto" goes over to a better reducer
  /// when it shows an error above the tolerance, and tries a cheaper one when it has been far below for long.
  void revise(const LocalModel& model, const ContactSite& site);

  const ReducerCandidate& chosen() const { return candidates_[chosen_]; }
  const std::vector<ReducerCandidate>& candidates() const { return candidates_; }
  double certified_error() const { return certified_; }  ///< worst known now; NaN: not certified
  std::string reason() const;
  int revisions() const { return revisions_; }

 private:
  std::optional<BodyCertificate> certify_body(const TangentModel& tangent, const SurfacePatch& patch,
                                              const ContactSite& site);
  void go_to(std::size_t candidate);
  std::optional<std::size_t> better_than_present() const;
  std::optional<std::size_t> cheaper_than_present() const;
  bool is_auto_, is_set_up_ = false;
  ReducerNeeds needs_;
  GradedBody graded_;
  RunningCertificate running_;
  std::vector<ReducerCandidate> candidates_;  ///< by predicted cost
  std::size_t chosen_ = 0;
  int wait_ = 0;  // refreshes until the next sample of the certificate; below 0: since it was due
  double certified_ = std::numeric_limits<double>::quiet_NaN();
  int quiet_ = 0, revisions_ = 0;  // samples since the certificate was near the tolerance
};

}  // namespace kt
