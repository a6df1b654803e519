#pragma once
// Which reducer serves a scene: the one it names, or for "auto" the cheapest whose expected force error stays under the
// tolerance, whose tick and whose refresh stay in their time budgets; docs/method.md#4-the-local-model-section-iii.
#include <optional>
#include <utility>

#include "core/base/finding.hpp"
#include "core/local/certificate.hpp"
#include "core/local/certified_rates.hpp"
#include "haptics/cost/expected_touch.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/refresh/kept_set_up.hpp"
#include "haptics/refresh/measured_refreshes.hpp"
#include "haptics/refresh/reducer_candidates.hpp"

namespace kt {

/// What a choice has come to, for one that goes on from there: nothing is set up anew.
struct ReducerState {
  std::string reducer;  ///< that was asked for
  ReducerNeeds needs;
  std::vector<ReducerCandidate> candidates;
  std::size_t chosen = 0;
  std::optional<Excitation> excitation;
  RunningCertificate running;
  std::vector<double> latest;  ///< errors of the chosen one at kCertifiedHz
  double certified = 0;
  int wait = 0;  ///< refreshes until the next sample
};

/// A doubt about forces whose expected error, of the local model alone, is above 15 %; none: it is not, or is NaN.
/// @param in_use  reducer     @param asked  local.reducer
std::optional<Finding> find_wrong_local_model(double error, const std::string& in_use, const std::string& asked);

class ReducerChoice {
 public:
  /// @param reducer  a name in core/local/reducers.def, or "auto"
  ReducerChoice(const std::string& reducer, int rings, const ReducerNeeds& needs);

  /// Takes one of the candidates of "auto", which it certifies, or the named reducer, which it certifies only where no
  /// samples will be taken of it. Once, at set-up; again where go_on_from() took over the certificate of a body that is
  /// far from this one.
  /// @param touch  what ticks will hold; none: they are predicted without contact
  void set_up(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site,
              const ExpectedTouch& touch = {});
  /// Set-ups of this body are kept there, and taken from there where nothing of them can differ. Null: nowhere.
  /// Borrowed.
  void keep_set_ups(KeptSetUp* kept) { kept_ = kept; }

  /// What set_up() takes in the place of finding it out, if it was for the same reducer and needs.
  void go_on_from(ReducerState before);
  ReducerState state() const;

  /// A local model by the present reducer.
  LocalModel reduce(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site);

  /// Of the forces until now, for what follows.
  void excite(const Excitation& measured);

  /// One more sample of the certificate for a model that reduce() made just now, in the refresh at this tick; "auto"
  /// goes over to a better reducer when the force error to expect is above the tolerance, and tries a cheaper one when
  /// it has been far below for long.
  void revise(const LocalModel& model, const ContactSite& site, int tick);

  /// What ticks hold now: their predictions follow, of all candidates alike.
  void expect(const ExpectedTouch& touch);
  const ExpectedTouch& expected_touch() const { return touch_; }

  /// What the refresh at this tick took: over the budget for some refreshes, "auto" steps down, and up again when there
  /// is room for long. Depends on the clock: a replay follows the changes that were recorded.
  /// @param own_ms  part of it that the local model took     @param beside_ms  what another core took meanwhile
  void note_cost(double all_ms, double own_ms, double beside_ms, int tick);

  /// A replay: these changes and no others.
  void follow(std::vector<ReducerChange> changes) { followed_ = std::move(changes); }

  /// Of the same body with other settings: takes over what is certified (seconds of CPU time), the reducer chosen and
  /// the changes until now. Samples correct the certificate from the next refresh on.
  void go_on_from(ReducerChoice& before);
  /// Changes since they were taken.
  std::vector<ReducerChange> take_changes() { return std::exchange(changes_, {}); }

  const ReducerCandidate& chosen() const { return candidates_[chosen_]; }
  const std::vector<ReducerCandidate>& candidates() const { return candidates_; }
  double certified_error() const { return certified_; }  ///< worst known now of 0-500 Hz; NaN: not certified
  double force_error() const;  ///< to expect now, without excitation the worst; NaN: not certified
  /// NaN without excitation, too, and where a tenth of it is at rates of which a named reducer has no sample yet.
  double expected_force_error() const;
  const std::optional<Excitation>& excitation() const { return excitation_; }
  std::string reason() const;
  const std::vector<ReducerChange>& changes() const { return changes_; }
  double predicted_refresh_ms() const { return chosen().refresh_ms; }

 private:
  struct Body;
  void make_set_up(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site);
  void note_chosen();
  std::optional<Body> certify_body(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site);
  bool is_sample_due() const { return wait_ <= 0; }
  bool sample(const LocalModel& model, const ContactSite& site);
  void excite_by_motion(const LocalModel& model, const ContactSite& site);
  void go_to(std::size_t candidate, int tick, const std::string& why);
  std::vector<ReducerCandidate> candidates_now() const;
  std::optional<std::size_t> better_than_present() const;
  std::optional<std::size_t> cheaper_than_present() const;
  std::optional<std::size_t> better_that_costs_no_more(const std::vector<ReducerCandidate>& now) const;
  void follow_changes(int tick);
  struct CertifiedAt {  ///< what the errors and costs of reducers depend on
    double stiffness = 0, damping = 0;
    int vertices = 0;
    bool is_near(const CertifiedAt& other) const;
  };
  static CertifiedAt where(const TangentModel& tangent, const SurfacePatch& patch);
  bool is_auto_, is_set_up_ = false;
  std::optional<ReducerState> before_;  ///< until it is set up
  int rings_;
  KeptSetUp* kept_ = nullptr;
  CertifiedAt at_;
  ReducerNeeds needs_;
  ExpectedTouch touch_;
  GradedBody graded_;
  RunningCertificate running_;
  std::vector<ReducerCandidate> candidates_;  ///< by predicted cost
  std::size_t chosen_ = 0;
  std::optional<Excitation> excitation_;
  std::vector<double>
      latest_;    // errors of the chosen one at kCertifiedHz: samples, where there are none those of set-up
  int wait_ = 0;  // refreshes until the next sample of the certificate; below 0: since it was due
  double certified_ = std::numeric_limits<double>::quiet_NaN();
  int quiet_ = 0;  // samples since the force error to expect was near the tolerance
  MeasuredRefreshes measured_;
  std::vector<ReducerChange> changes_;  // not taken yet
  std::optional<ReducerChange> last_change_;
  int num_changes_ = 0;
  std::optional<std::vector<ReducerChange>> followed_;
};

}  // namespace kt
