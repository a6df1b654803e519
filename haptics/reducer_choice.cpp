#include "haptics/reducer_choice.hpp"

#include <algorithm>
#include <cmath>

#include "core/damping.hpp"

namespace kt {
namespace {

constexpr int kFewNodes = 300;        // up to here the whole body is a local model worth trying
constexpr double kCoarseRank = 0.03;  // motions that are others' to within this part of their length are dropped
constexpr int kSampleEvery = 4;       // refreshes: a sample costs up to a third of one
constexpr int kLongQuiet = 15;        // samples, two seconds at the usual rate
const std::vector<double> kManyShifts{0, 20, 40, 80, 160, 400};  // [Hz]

std::string krylov_name(const std::vector<double>& shifts_hz) {
  std::string out = "krylov {";
  for (std::size_t i = 0; i < shifts_hz.size(); ++i) out += text(i ? ", " : "", shifts_hz[i]);
  return out + "} Hz";
}

ReducerCandidate make_candidate(const std::string& reducer, int rings, const std::vector<double>& shifts_hz = {},
                                double rank_tolerance = ReduceOptions().rank_tolerance) {
  ReducerCandidate out;
  out.reducer = reducer;
  out.options.rings = rings;
  out.name = reducer;
  if (reducer == "wall") out.name += text(" of ", rings, rings == 1 ? " ring" : " rings");
  if (!shifts_hz.empty()) {
    out.options.shifts_hz = shifts_hz;
    out.options.rank_tolerance = rank_tolerance;
    out.name = krylov_name(shifts_hz);
    if (rank_tolerance == kCoarseRank) out.name += ", coarse";
  }
  return out;
}

std::vector<ReducerCandidate> auto_candidates(int num_nodes) {
  std::vector<ReducerCandidate> out{make_candidate("condensed", 1)};
  for (int rings : {1, 2, 3}) out.push_back(make_candidate("wall", rings));
  for (const auto& shifts : {ReduceOptions().shifts_hz, {0, 60, 250}, kManyShifts})
    out.push_back(make_candidate("krylov", 1, shifts));
  // Fine meshes: many vertices in reach move nearly alike.
  out.push_back(make_candidate("krylov", 1, ReduceOptions().shifts_hz, kCoarseRank));
  if (num_nodes <= kFewNodes) out.push_back(make_candidate("full", 1));
  return out;
}

/// Of the modal one's motions the certificate knows nothing; with all of them nothing can be wrong.
bool has_samples(const std::string& reducer) { return reducer != "modal" && reducer != "full"; }

std::string percent(double x) {
  char out[32];
  std::snprintf(out, sizeof out, "%.2g %%", 100 * x);
  return out;
}

}  // namespace

std::vector<BackendInfo> reducer_names() {
  std::vector<BackendInfo> out = reducer_backends();
  out.push_back({"auto", "the cheapest of these whose certified error stays under local.tolerance", true, ""});
  return out;
}

std::size_t choose_reducer(const std::vector<ReducerCandidate>& candidates, const ReducerNeeds& needs) {
  const auto better = [&](const ReducerCandidate& a, const ReducerCandidate& b) {
    const bool a_fits = a.tick_us <= needs.budget_us, b_fits = b.tick_us <= needs.budget_us;
    if (a_fits != b_fits) return a_fits;
    if (!a_fits) return a.tick_us < b.tick_us;
    const bool a_holds = a.error <= needs.tolerance, b_holds = b.error <= needs.tolerance;
    if (a_holds != b_holds) return a_holds;
    return a_holds ? a.cost_us < b.cost_us : a.error < b.error;
  };
  return static_cast<std::size_t>(std::min_element(candidates.begin(), candidates.end(), better) - candidates.begin());
}

double predict_tick_us(const LocalModel& model) {
  constexpr double kRest = 6, kPerNumber = 2e-4;  // collision and contact; us a number that the motion reads
  constexpr double kDenseLimit = 450;             // as in LocalDynamics
  const double r = model.dof(), rows = 3.0 * model.patch.num_vertices();
  const bool dense = 2.0 * static_cast<double>(model.basis.nonZeros()) > static_cast<double>(model.basis.size());
  double numbers = dense ? 2 * rows * r : 2 * rows;
  // Vibrations step each by itself, but the damping of a body that bends couples them: counted as if it did.
  const bool vibrations = model.stiffness.nonZeros() <= model.dof();
  if (r <= kDenseLimit)
    numbers += r * r;
  else  // two sparse triangular solves, of a full matrix where the damping of vibrations fills it
    numbers += vibrations ? 5 * r * r : 40 * static_cast<double>(model.stiffness.nonZeros());
  return kRest + kPerNumber * numbers;
}

double predict_refresh_us(const LocalModel& model, const ReduceOptions& options) {
  constexpr double kRest = 10000, kPerColumnSq = 1.5;    // solutions, orthonormalization
  constexpr double kCutOut = 1000, kPerDofCubed = 2e-4;  // of nodes that are there already; dense factors
  if (model.reducer != "krylov" && model.reducer != "condensed")
    return kCutOut + kPerDofCubed * std::pow(model.dof(), 3);
  const SurfacePatch& patch = model.patch;
  const bool at_rest = model.reducer == "condensed";
  const auto reach = static_cast<double>(std::ranges::count(patch.in_reach, 1));
  const auto shifts = static_cast<double>(options.shifts_hz.size());
  const double later = at_rest ? 0 : 3 * reach + 12 * (shifts - 2) + 12 * shifts + 3 * options.echoes;
  const double columns = 3 * patch.num_vertices() + later;
  return kRest + kPerColumnSq * columns * columns;
}

ReducerChoice::ReducerChoice(const std::string& reducer, int rings, const ReducerNeeds& needs)
    : is_auto_(reducer == "auto"),
      needs_(needs),
      graded_(needs.whole ? GradingOptions{.margin = std::numeric_limits<double>::infinity()} : GradingOptions{}) {
  if (!is_auto_) candidates_ = {make_candidate(reducer, rings)};
  if (!is_auto_ && reducer == "krylov") candidates_.front().name = krylov_name(candidates_.front().options.shifts_hz);
}

/// Nothing where the body cannot be reduced: it gives way even to fast motions.
std::optional<BodyCertificate> ReducerChoice::certify_body(const TangentModel& tangent, const SurfacePatch& patch,
                                                           const ContactSite& site) {
  try {
    const LocalModel best =
        find_reducer("krylov")(tangent, patch, site, {.shifts_hz = kManyShifts, .graded = &graded_});
    std::span<const double> hz = kCertifiedHz;
    // A body that is free to move gives way at rest: there is no impedance to be right about.
    if (tangent.fixed_nodes.size() < 3) hz = hz.subspan(1);
    return BodyCertificate(graded_, best, certified_vertices(best, site), hz);
  } catch (const IndefiniteTangent&) {
    return {};
  }
}

void ReducerChoice::set_up(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site) {
  if (is_set_up_) return;
  is_set_up_ = true;
  if (is_auto_) candidates_ = auto_candidates(static_cast<int>(tangent.f0.size()) / 3);
  const std::optional<BodyCertificate> body = certify_body(tangent, patch, site);
  for (ReducerCandidate& c : candidates_) {
    ReduceOptions options = c.options;
    options.graded = &graded_;
    c.error = std::numeric_limits<double>::infinity();
    try {
      const LocalModel model = find_reducer(c.reducer)(tangent, patch, site, options);
      c.dof = model.dof();
      c.tick_us = predict_tick_us(model);
      c.cost_us = c.tick_us + needs_.refresh_per_tick * predict_refresh_us(model, c.options);
      if (c.reducer == "full")
        c.error = 0;
      else if (body)
        c.error = body->certify(model).worst;  // 0 where all is clamped: nothing can be wrong
    } catch (const RunError&) {                // it cannot serve here; its error stays infinite
      if (c.dof == 0) c.tick_us = c.cost_us = std::numeric_limits<double>::infinity();
    }
  }
  std::stable_sort(candidates_.begin(), candidates_.end(),
                   [](const auto& a, const auto& b) { return a.cost_us < b.cost_us; });
  chosen_ = choose_reducer(candidates_, needs_);
  if (std::isfinite(chosen().error)) certified_ = chosen().error;
}

LocalModel ReducerChoice::reduce(const TangentModel& tangent, const SurfacePatch& patch, const ContactSite& site) {
  if (chosen().reducer == "wall" || chosen().reducer == "full") graded_.update(tangent, patch);
  ReduceOptions options = chosen().options;
  options.graded = &graded_;
  return find_reducer(chosen().reducer)(tangent, patch, site, options);
}

void ReducerChoice::go_to(std::size_t candidate) {
  chosen_ = candidate;
  if (chosen().reducer == "full") certified_ = 0;
  running_ = RunningCertificate();
  quiet_ = 0;
  ++revisions_;
}

/// The cheapest above the present one, within the budget, that was less wrong at set-up.
std::optional<std::size_t> ReducerChoice::better_than_present() const {
  for (std::size_t i = chosen_ + 1; i < candidates_.size(); ++i)
    if (candidates_[i].tick_us <= needs_.budget_us && candidates_[i].error < chosen().error) return i;
  return {};
}

std::optional<std::size_t> ReducerChoice::cheaper_than_present() const {
  for (std::size_t i = 0; i < chosen_; ++i)
    if (candidates_[i].error <= needs_.tolerance) return i;
  return {};
}

void ReducerChoice::revise(const LocalModel& model, const ContactSite& site) {
  if (!has_samples(chosen().reducer)) return;
  if (wait_-- > 0) return;
  // Not in a refresh that has chosen its nodes anew, which costs more already; but where each does, in one of these.
  if (graded_.is_graded_anew() && wait_ >= -kSampleEvery) return;
  wait_ = kSampleEvery - 1;
  const Certificate& now = running_.sample(graded_, model, site);
  if (std::isfinite(now.worst) && now.worst > 0) certified_ = now.worst;
  if (!is_auto_) return;
  quiet_ = now.worst < 0.5 * needs_.tolerance ? quiet_ + 1 : 0;
  if (now.worst > needs_.tolerance) {
    if (const auto next = better_than_present()) go_to(*next);
  } else if (quiet_ > kLongQuiet) {
    if (const auto next = cheaper_than_present()) go_to(*next);
  }
}

std::string ReducerChoice::reason() const {
  if (!is_auto_) return "chosen by the scene";
  const ReducerCandidate& c = chosen();
  std::string out = c.name;
  if (c.tick_us > needs_.budget_us)
    out += text(": no local model fits ", needs_.budget_us, " us a tick; this is the cheapest");
  else if (c.error > needs_.tolerance)
    out += text(": the most accurate within ", needs_.budget_us, " us a tick, but off by ", percent(c.error), " where ",
                percent(needs_.tolerance), " are tolerated: the budget wins");
  else if (revisions_ > 0)
    return out + text(": certified ", percent(c.error),
                      " at set-up; taken on the way, where samples of the one before left ", percent(needs_.tolerance),
                      " behind (", revisions_, revisions_ == 1 ? " revision)" : " revisions)");
  else
    out += text(": the cheapest within ", percent(needs_.tolerance), " (certified ", percent(c.error), " at set-up)");
  const ReducerCandidate* cheaper = nullptr;
  for (std::size_t i = 0; i < chosen_; ++i)
    if (!cheaper || candidates_[i].error < cheaper->error) cheaper = &candidates_[i];
  if (cheaper && std::isfinite(cheaper->error))
    out += text("; the best of the cheaper ones is off by ", percent(cheaper->error), " (", cheaper->name, ")");
  return out;
}

}  // namespace kt
