#include "haptics/refresh/reducer_choice.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "core/local/certified_rates.hpp"
#include "haptics/cost/tick_cost.hpp"
#include "haptics/options/band_powers.hpp"

namespace kt {
namespace {

constexpr int kSampleEvery = 4;    // refreshes: a sample costs up to a third of one
constexpr int kLongQuiet = 15;     // samples, two seconds at the usual rate; refreshes where the forces are measured
constexpr double kWell = 0.8;      // of the tolerance, of a cost: what a cheaper one has to keep to
constexpr double kMuchLater = 3;   // times the budget of a refresh: 12 Hz where four fifths of 30 Hz are there
constexpr double kNoDearer = 1.1;  // of a cost

/// Of the modal one's motions the certificate knows nothing; with all of them nothing can be wrong.
bool has_samples(const std::string& reducer) { return reducer != "modal" && reducer != "full"; }

/// CPU time of what a body's size adds to a local model [us]: the body in its kept nodes (core/local/graded_body.hpp),
/// of the wall for samples only. Fitted to springs and elements of 919 to 10,575 nodes (bench/refresh_table), as the
/// other costs are.
double predict_grading_us(const ReducerCandidate& candidate, int num_nodes) {
  constexpr double kAllKept = 250, kPerNode = 8;  // all are kept; the others
  constexpr double kPerShift = 0.75;              // a factor, solutions
  double share = 1;
  if (candidate.reducer == "full" || candidate.reducer == "modal") share = 0;
  if (candidate.reducer == "wall") share = 1.0 / kSampleEvery;
  if (candidate.reducer == "krylov") share = kPerShift * static_cast<double>(candidate.options.shifts_hz.size());
  return share * kPerNode * std::max(0.0, num_nodes - kAllKept);
}

/// They ask for the same, whatever they predict.
bool are_alike(const ReducerNeeds& a, const ReducerNeeds& b) {
  return a.tolerance == b.tolerance && a.budget_us == b.budget_us && a.refresh_per_tick == b.refresh_per_tick &&
         a.whole == b.whole && a.refresh_budget_ms == b.refresh_budget_ms;
}

std::string short_ms(double ms) { return with_digits(ms, 3) + " ms"; }

/// |Z| at a vertex, at kCertifiedHz [N/m]; NaN where the body has no finite answer.
std::array<double, kBands> impedances(const LocalModel& model, int vertex) {
  std::array<double, kBands> out;
  for (std::size_t i = 0; i < kBands; ++i) {
    const double z = compliance(model, vertex, kCertifiedHz[i]).inverse().norm();
    out[i] = std::isfinite(z) ? z : std::numeric_limits<double>::quiet_NaN();
  }
  return out;
}

}  // namespace

/// The whole body at the patch.
struct ReducerChoice::Body {
  BodyCertificate certificate;
  bool answers_at_rest = true;  ///< it is not free to move: it has an impedance at 0 Hz
  std::optional<std::array<double, kBands>> impedance;
};

ReducerChoice::ReducerChoice(const std::string& reducer, int rings, const ReducerNeeds& needs)
    : is_auto_(reducer == "auto"),
      rings_(rings),
      needs_(needs),
      graded_(needs.whole ? GradingOptions{.margin = std::numeric_limits<double>::infinity()} : GradingOptions{}) {
  if (!is_auto_) candidates_ = {make_reducer_candidate(reducer, rings)};
}

/// Nothing where the body cannot be reduced: it gives way even to fast motions.
std::optional<ReducerChoice::Body> ReducerChoice::certify_body(const TangentModel& tangent, const SurfacePatch& patch,
                                                               const ContactSite& site) {
  try {
    const LocalModel best =
        find_reducer("krylov")(tangent, patch, site, {.shifts_hz = most_shifts_hz(), .graded = &graded_});
    std::span<const double> hz = kCertifiedHz;
    // A body that is free to move gives way at rest: there is no impedance to be right about.
    const bool answers_at_rest = tangent.fixed_nodes.size() >= 3;
    if (!answers_at_rest) hz = hz.subspan(1);
    const std::vector<int> vertices = certified_vertices(best, site);
    Body out{BodyCertificate(graded_, best, vertices, hz), answers_at_rest, {}};
    if (needs_.motion && !vertices.empty()) out.impedance = impedances(best, vertices.front());
    return out;
  } catch (const IndefiniteTangent&) {
    return {};
  }
}

void ReducerChoice::set_up(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site,
                           const ExpectedTouch& touch) {
  const CertifiedAt now = where(tangent, patch);
  if (is_set_up_ && at_.is_near(now)) return;
  const bool is_first = !std::exchange(is_set_up_, true);  // graded_ is as it was made
  at_ = now;
  touch_ = touch;
  if (std::optional<ReducerState> before = std::exchange(before_, std::nullopt)) {
    candidates_ = std::move(before->candidates);
    chosen_ = before->chosen;
    excitation_ = before->excitation;
    running_ = std::move(before->running);
    latest_ = std::move(before->latest);
    certified_ = before->certified;
    wait_ = before->wait;
    return;
  }
  if (!kept_ || !is_first) return make_set_up(tangent, patch, site);
  SetUpKey key = set_up_key(is_auto_ ? "auto" : candidates_.front().name, rings_, needs_, touch_, excitation_, tangent,
                            patch, site);
  if (const std::shared_ptr<const ReducerSetUp> found = kept_->find(key)) {
    candidates_ = found->candidates;
    chosen_ = found->chosen;
    excitation_ = found->excitation;
    graded_ = found->graded;
    note_chosen();
  } else {
    make_set_up(tangent, patch, site);
    kept_->keep(std::move(key),
                std::make_shared<const ReducerSetUp>(ReducerSetUp{candidates_, chosen_, excitation_, graded_}));
  }
}

void ReducerChoice::note_chosen() {
  latest_ = chosen().errors;
  if (std::isfinite(chosen().error)) certified_ = chosen().error;
}

void ReducerChoice::go_on_from(ReducerState before) {
  const std::string asked = is_auto_ ? "auto" : candidates_.front().name;
  if (!before.candidates.empty() && before.reducer == asked && are_alike(before.needs, needs_))
    before_ = std::move(before);
}

ReducerState ReducerChoice::state() const {
  return {is_auto_ ? "auto" : candidates_.front().name,
          needs_,
          candidates_,
          chosen_,
          excitation_,
          running_,
          latest_,
          certified_,
          wait_};
}

void ReducerChoice::make_set_up(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site) {
  const int num_nodes = static_cast<int>(tangent.f0.size()) / 3;
  if (is_auto_) candidates_ = auto_candidates(num_nodes);
  // What is chosen by name is certified by the samples of its refreshes, if there are such: a quarter of the set-up
  // less.
  const bool is_certified_now = is_auto_ || !has_samples(candidates_.front().reducer);
  const std::optional<Body> body = is_certified_now ? certify_body(tangent, patch, site) : std::nullopt;
  if (body && body->impedance && needs_.motion->total > 0)
    excitation_ = excitation_of(*needs_.motion, *body->impedance);
  for (ReducerCandidate& c : candidates_) {
    ReduceOptions options = c.options;
    options.graded = &graded_;
    c.error = c.force_error = std::numeric_limits<double>::infinity();
    try {
      const LocalModel model = find_reducer(c.reducer)(tangent, patch, site, options);
      c.dof = model.dof();
      c.tick_us = predict_tick_us(model, touch_);
      const double own_us = predict_refresh_us(model, c.options) + predict_grading_us(c, num_nodes);
      c.own_ms = 1e-3 * own_us;
      c.refresh_ms = needs_.rest_ms + std::max(c.own_ms, needs_.beside_ms);
      const double refreshes_us = needs_.refresh_per_tick * 1e3 * c.refresh_ms;
      const double free_us = predict_tick_us(model);
      c.cost_us = free_us + refreshes_us;
      if (c.reducer == "full") {
        c.error = c.force_error = 0;
      } else if (body) {
        const Certificate found = body->certificate.certify(model);
        c.error = found.worst;  // 0 where all is clamped: nothing can be wrong
        c.errors = found.error;
        if (!body->answers_at_rest) c.errors.insert(c.errors.begin(), std::numeric_limits<double>::quiet_NaN());
        c.force_error = excitation_ ? kt::expected_force_error(*excitation_, c.errors) : c.error;
      }
      c.cost_us = free_us + refreshes_per_interval(c) * refreshes_us;
    } catch (const RunError&) {  // it cannot serve here; its error stays infinite
      if (c.dof == 0) c.tick_us = c.own_ms = c.refresh_ms = c.cost_us = std::numeric_limits<double>::infinity();
    }
  }
  std::stable_sort(candidates_.begin(), candidates_.end(),
                   [](const auto& a, const auto& b) { return a.cost_us < b.cost_us; });
  chosen_ = choose_reducer(candidates_, needs_);
  note_chosen();
}

ReducerChoice::CertifiedAt ReducerChoice::where(const TangentModel& tangent, const SurfacePatch& patch) {
  return {-tangent.dfdx.diagonal().sum(), -tangent.dfdv.diagonal().sum(), patch.num_vertices()};
}

/// Four times as stiff a body answers as the other does at half the frequency: the next samples are enough to tell.
bool ReducerChoice::CertifiedAt::is_near(const CertifiedAt& other) const {
  constexpr double kFactor = 4, kVertices = 1.5;
  const auto within = [](double a, double b, double factor) { return a <= factor * b && b <= factor * a; };
  return within(stiffness, other.stiffness, kFactor) && within(damping, other.damping, kFactor) &&
         within(vertices, other.vertices, kVertices);
}

void ReducerChoice::go_on_from(ReducerChoice& before) {
  changes_ = std::move(before.changes_);
  last_change_ = std::move(before.last_change_);
  num_changes_ = before.num_changes_;
  const bool same_candidates = is_auto_ ? before.is_auto_ : candidates_.front().name == before.chosen().name;
  const bool same_needs = are_alike(needs_, before.needs_);
  if (before.before_) go_on_from(std::move(*before.before_));
  if (!before.is_set_up_ || is_auto_ != before.is_auto_ || !same_candidates || !same_needs) return;
  is_set_up_ = true;
  at_ = before.at_;
  touch_ = before.touch_;
  graded_ = std::move(before.graded_);
  candidates_ = std::move(before.candidates_);
  chosen_ = before.chosen_;
  excitation_ = before.excitation_;
  latest_ = std::move(before.latest_);
  certified_ = before.certified_;
  measured_ = std::move(before.measured_);
}

LocalModel ReducerChoice::reduce(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site) {
  // The wall is made without: only a sample needs it.
  if (chosen().reducer == "wall" && is_sample_due()) graded_.update(tangent, patch);
  ReduceOptions options = chosen().options;
  options.graded = &graded_;
  return find_reducer(chosen().reducer)(tangent, patch, site, options);
}

double ReducerChoice::force_error() const {
  if (!excitation_ || std::isnan(certified_)) return certified_;
  return kt::expected_force_error(*excitation_, latest_);
}

double ReducerChoice::expected_force_error() const {
  constexpr double kUnknown = 0.1, kNan = std::numeric_limits<double>::quiet_NaN();
  if (!excitation_) return kNan;
  double unknown = 0;
  for (std::size_t i = 0; i < kBands && !is_auto_ && chosen().reducer != "full"; ++i)
    if (i >= latest_.size() || std::isnan(latest_[i])) unknown += (*excitation_)[i];
  return unknown > kUnknown ? kNan : force_error();
}

void ReducerChoice::excite(const Excitation& measured) {
  excitation_ = measured;
  for (ReducerCandidate& c : candidates_)
    if (!c.errors.empty()) c.force_error = kt::expected_force_error(measured, c.errors);
}

void ReducerChoice::go_to(std::size_t candidate, int tick, const std::string& why) {
  const std::string from = chosen().name;
  if (excitation_ && !latest_.empty()) {  // what samples found out about it stays known
    candidates_[chosen_].errors = latest_;
    candidates_[chosen_].force_error = kt::expected_force_error(*excitation_, latest_);
  }
  chosen_ = candidate;
  last_change_ = {tick, from, chosen().name, why, chosen().error, chosen().force_error};
  ++num_changes_;
  changes_.push_back(*last_change_);
  if (chosen().reducer == "full") certified_ = 0;
  latest_ = chosen().errors;
  running_ = RunningCertificate();
  quiet_ = 0;
}

void ReducerChoice::expect(const ExpectedTouch& touch) {
  const double more = predict_contact_us(touch) - predict_contact_us(touch_);
  for (ReducerCandidate& c : candidates_) c.tick_us += more;
  touch_ = touch;
}

std::vector<ReducerCandidate> ReducerChoice::candidates_now() const { return measured_.expected(candidates_); }

/// The cheapest above the present one, within the budgets, that was less wrong at set-up.
std::optional<std::size_t> ReducerChoice::better_than_present() const {
  const std::vector<ReducerCandidate> now = candidates_now();
  for (std::size_t i = chosen_ + 1; i < now.size(); ++i)
    if (now[i].tick_us <= needs_.budget_us && now[i].refresh_ms <= needs_.refresh_budget_ms &&
        now[i].force_error < chosen().force_error)
      return i;
  return {};
}

std::optional<std::size_t> ReducerChoice::cheaper_than_present() const {
  const std::vector<ReducerCandidate> now = candidates_now();
  const double most = (excitation_ ? kWell : 1) * needs_.tolerance;
  for (std::size_t i = 0; i < chosen_; ++i)
    if (now[i].force_error <= most && now[i].tick_us <= needs_.budget_us &&
        now[i].refresh_ms <= needs_.refresh_budget_ms)
      return i;
  return {};
}

/// True: a sample was taken.
bool ReducerChoice::sample(const LocalModel& model, const ContactSite& site) {
  if (!has_samples(chosen().reducer)) return false;
  const bool is_due = is_sample_due();
  --wait_;
  if (!is_due) return false;
  // Not in a refresh that has chosen its nodes anew, which costs more already; but where each does, in one of these.
  const bool costs_more = chosen().reducer != "wall" && graded_.is_graded_anew();
  if (costs_more && wait_ >= -kSampleEvery) return false;
  wait_ = kSampleEvery - 1;
  const Certificate& now = running_.sample(graded_, model, site);
  if (std::isfinite(now.worst) && now.worst > 0) certified_ = now.worst;
  latest_.resize(kBands, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < kBands; ++i)
    if (!std::isnan(now.error[i])) latest_[i] = now.error[i];
  return true;
}

/// Of a reducer that is named, by its own impedance: what is certified is its worst error of 0-500 Hz, of which a slow
/// tool excites little.
void ReducerChoice::excite_by_motion(const LocalModel& model, const ContactSite& site) {
  if (excitation_ || !needs_.motion || !(needs_.motion->total > 0)) return;
  const std::vector<int> vertices = certified_vertices(model, site);
  if (!vertices.empty()) excitation_ = excitation_of(*needs_.motion, impedances(model, vertices.front()));
}

void ReducerChoice::revise(const LocalModel& model, const ContactSite& site, int tick) {
  const bool is_sampled = sample(model, site);
  if (!is_auto_ && is_sampled) excite_by_motion(model, site);
  if (followed_) return follow_changes(tick);
  if (!is_auto_ || !has_samples(chosen().reducer)) return;
  if (!is_sampled && !excitation_) return;
  const double error = force_error();
  const auto cheaper = cheaper_than_present();
  if (excitation_)
    quiet_ = cheaper ? quiet_ + 1 : 0;
  else if (is_sampled)
    quiet_ = error < 0.5 * needs_.tolerance ? quiet_ + 1 : 0;
  if (error > needs_.tolerance) {
    if (const auto next = better_than_present())
      go_to(*next, tick, text("a force error of ", in_percent(error, 2), " was to be expected"));
  } else if (quiet_ > kLongQuiet) {
    if (cheaper)
      go_to(*cheaper, tick,
            text("for long, a force error of only ", in_percent(candidates_[*cheaper].force_error, 2),
                 " was to be expected of it"));
  }
}

/// Where what was stepped down to turns out to be no cheaper. A dearer one costs more, too, where refined cells that
/// another core makes take longer still: the ticks run on that core. Of a wall that is too stiff at rest the
/// certificate expects less than it is off by (note_cost).
std::optional<std::size_t> ReducerChoice::better_that_costs_no_more(const std::vector<ReducerCandidate>& now) const {
  std::optional<std::size_t> out;
  for (std::size_t i = 0; i < now.size(); ++i)
    if (now[i].own_ms <= kNoDearer * now[chosen_].own_ms &&
        refreshes_per_interval(now[i]) <= refreshes_per_interval(now[chosen_]) && now[i].tick_us <= needs_.budget_us &&
        now[i].force_error < now[out.value_or(chosen_)].force_error)
      out = i;
  return out;
}

void ReducerChoice::note_cost(double all_ms, double own_ms, double beside_ms, int tick) {
  if (!is_auto_ || followed_ || !std::isfinite(needs_.refresh_budget_ms)) return;
  measured_.note(all_ms, own_ms, beside_ms, candidates_, chosen_, needs_);
  const std::vector<ReducerCandidate> now = candidates_now();
  const std::size_t best = choose_reducer(now, needs_);
  const double budget_ms = needs_.refresh_budget_ms, present_ms = now[chosen_].refresh_ms;
  // A less accurate one that is late as well is no relief. And models that are right and come somewhat late are better
  // than wrong ones in time: over the organ, in lockstep that charges refreshes, condensed was 2 to 3 % off at 32 to
  // 46 ms, the wall 4 to 7 at 12 to 15; at 80 ms they are alike.
  const bool is_right = now[best].force_error <= kWell * needs_.tolerance && refreshes_per_interval(now[best]) == 1;
  const bool fits = now[best].refresh_ms <= budget_ms, is_much_cheaper = now[best].refresh_ms < kWell * present_ms;
  const bool is_worth_it = is_right ? fits || is_much_cheaper : fits && present_ms > kMuchLater * budget_ms;
  if (measured_.is_overloaded() && now[best].refresh_ms < present_ms && is_worth_it) {
    go_to(best, tick, text("refreshes took ", short_ms(all_ms), ", ", short_ms(budget_ms), " are there"));
    measured_.stepped_down();
  } else if (const auto other = better_that_costs_no_more(now); measured_.is_overloaded() && other) {
    go_to(*other, tick, text("refreshes took ", short_ms(all_ms), ", and this is no dearer"));
    measured_.stepped_down();
  } else if (measured_.has_room() && now[best].refresh_ms > present_ms) {
    go_to(best, tick, text("refreshes took ", short_ms(all_ms), " of ", short_ms(budget_ms)));
    measured_.stepped_up();
  }
}

std::optional<Finding> find_wrong_local_model(double error, const std::string& in_use, const std::string& asked) {
  constexpr double kWrong = 0.15;  // less is smaller than what the other doubts are about
  if (!(error > kWrong)) return {};
  std::vector<Cure> cures;
  if (asked != "auto") cures.push_back(set_to("local.reducer", "auto"));
  if (!in_use.starts_with("krylov")) cures.push_back(set_to("local.reducer", "krylov", "refreshes take longer"));
  return Finding{told("expected force error of the local model ", in_percent(error), ", at the rates of this motion"),
                 std::move(cures)}
      .at("local.reducer", error, kWrong);
}

/// Names that are not known here are left out: the hash will tell.
void ReducerChoice::follow_changes(int tick) {
  for (const ReducerChange& change : *followed_) {
    if (change.tick != tick) continue;
    const auto to = std::ranges::find(candidates_, change.to, &ReducerCandidate::name);
    if (to != candidates_.end()) go_to(static_cast<std::size_t>(to - candidates_.begin()), tick, change.why);
  }
}

std::string ReducerChoice::reason() const {
  const ReducerCandidate& c = chosen();
  if (!is_auto_)
    return c.tick_us > needs_.budget_us ? text("chosen by the scene; its ticks are to take ", std::round(c.tick_us),
                                               " us, ", needs_.budget_us, " are there")
                                        : "chosen by the scene";
  std::string out = c.name;
  if (last_change_)
    return out + text(": in use since tick ", last_change_->tick, ": ", last_change_->why, " with ", last_change_->from,
                      " (", num_changes_, num_changes_ == 1 ? " change)" : " changes)");
  if (c.tick_us > needs_.budget_us || c.refresh_ms > needs_.refresh_budget_ms)
    out +=
        text(": no local model fits ", needs_.budget_us, " us a tick",
             std::isfinite(needs_.refresh_budget_ms) ? text(" and ", short_ms(needs_.refresh_budget_ms), " a refresh")
                                                     : std::string(),
             "; this is the nearest");
  else if (c.force_error > needs_.tolerance)
    out +=
        text(": the most accurate within the budgets of ", needs_.budget_us, " us a tick",
             std::isfinite(needs_.refresh_budget_ms) ? text(" and ", short_ms(needs_.refresh_budget_ms), " a refresh")
                                                     : std::string(),
             ", but off by ", in_percent(c.force_error, 2), " where ", in_percent(needs_.tolerance, 2),
             " are tolerated of a local model: the budget wins");
  else
    out += text(": the cheapest within ", in_percent(needs_.tolerance, 2), " of its own (a force error of ",
                in_percent(c.force_error, 2), " is to be expected, certified ", in_percent(c.error, 2), " at set-up)");
  if (needs_.cells_error > 0 && std::isfinite(c.force_error))
    out += text("; with refined cells, which are off by ", in_percent(needs_.cells_error, 2), ", ",
                in_percent(std::hypot(needs_.cells_error, c.force_error), 2), " in all");
  const ReducerCandidate* cheaper = nullptr;
  for (std::size_t i = 0; i < chosen_; ++i)
    if (!cheaper || candidates_[i].force_error < cheaper->force_error) cheaper = &candidates_[i];
  if (cheaper && std::isfinite(cheaper->force_error))
    out += text("; the best of the cheaper ones is off by ", in_percent(cheaper->force_error, 2), " (", cheaper->name,
                ")");
  return out;
}

}  // namespace kt
