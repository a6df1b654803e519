#include "haptics/refresh/refresher.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <iterator>
#include <optional>

#include "collision/shape/tool_shape.hpp"
#include "core/base/cpu_time.hpp"
#include "core/base/stages.hpp"
#include "core/linear/sparse_solver.hpp"
#include "core/local/damping.hpp"
#include "haptics/cost/refined_share.hpp"
#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/look_ahead.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "haptics/refresh/refresh_cost.hpp"
#include "self_contact/crossings.hpp"

namespace kt {
namespace {

constexpr double kUncoupled = 0.02;  // of the damping power: far below what a hand can tell

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// None: it was lost.
const LocalReport* last_before(std::span<const LocalReport> reports, int tick) {
  const auto next = std::ranges::lower_bound(reports, tick, {}, &LocalReport::tick);
  return next == reports.begin() ? nullptr : &*std::prev(next);
}

/// Diagonal ones are so by construction. To within rounding: a piece that nothing holds moves without resistance.
bool is_positive_semidefinite(const SparseMatrix& matrix) {
  constexpr double kRoundoff = 1e-10;  // of the stiffest entry
  if (matrix.nonZeros() <= matrix.rows() || make_sparse_solver()->factor(matrix)) return true;
  SparseMatrix one(matrix.rows(), matrix.cols());
  one.setIdentity();
  return make_sparse_solver()->factor(SparseMatrix(matrix + kRoundoff * matrix.diagonal().maxCoeff() * one));
}

std::unique_ptr<Integrator> global_integrator(const GlobalSettings& global, SelfContact* self_contact) {
  const IntegratorOptions options{.solver = global.solver, .tolerance = global.tolerance, .definite = global.definite};
  if (self_contact) return std::make_unique<TouchingEuler>(*self_contact, options);
  return make_integrator(global.integrator, options);
}

}  // namespace

Refresher::Refresher(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                     const State& start, SelfContact* self_contact, KeptSetUp* kept)
    : surface_(surface),
      options_(options),
      tools_(options.tools),
      smoothing_(contact_smoothing(model, surface, options, self_contact != nullptr)),
      nodes_(surface),
      way_out_(surface, model.mesh().num_nodes(), still_nodes(model)),
      method_(make_method(options, {})),
      self_contact_(self_contact),
      global_(model, global_integrator(options.global, self_contact), 1 / options.global.rate_hz, start),
      choice_(options.local.reducer, options.local.rings,
              {.tolerance = model_tolerance(options.local.tolerance,
                                            refined_cells_error(model, surface, options, self_contact != nullptr)),
               .budget_us = tick_budget_us(options),
               .refresh_per_tick = options.global.rate_hz / options.local.rate_hz,
               .whole = self_contact != nullptr,
               .refresh_budget_ms = refresh_budget_ms(options),
               .rest_ms = predict_rest_ms(model.mesh().num_own_nodes(),
                                          static_cast<int>(model.mesh().tetrahedra.size()), model.info().type == "fem"),
               .beside_ms = choose_refine(model, surface, options, self_contact != nullptr).refines
                                ? predict_refine_ms(options.local.refine_nodes * static_cast<int>(options.tools.size()))
                                : 0,
               .motion = options.motion ? std::optional(*options.motion) : std::nullopt,
               .cells_error = refined_cells_error(model, surface, options, self_contact != nullptr)}),
      scheme_(local_scheme(options.local.integrator)),
      metric_(contact_metric(options.contact.metric)),
      refreshes_early_(options.global.early_refresh && options.local.method == "multirate"),
      has_apron_(options.local.method == "multirate" && !is_geometric(options.contact.law) && !surface.embedded),
      known_{.before = start, .start = start.x, .most_deformed = start, .past = {}, .pace = {}, .forces = {}} {
  choice_.keep_set_ups(kept);
  if (choose_refine(model, surface, options, self_contact != nullptr).refines)
    fine_.emplace(model, surface, options.local, options.contact.surface);
}

/// From one refresh to the next [s], as far as can be told at time t: in two threads a slow body makes it longer. No
/// longer than half as much again: a larger patch makes the next refresh slower still, and a tool that runs off is
/// found again.
double Refresher::interval(double t) const {
  const double usual = 1 / options_.global.rate_hz;
  return models_come_late(options_) ? std::clamp(t - known_.last, usual, 1.5 * usual) : usual;
}

/// Of a scene that is measured long enough, for the choice of the next model.
void Refresher::measure_forces(std::span<const LocalReport> reports) {
  constexpr double kMemory = 0.5, kEnough = 0.25;  // [s]
  if (known_.forces.empty()) {
    const double use = 1 / options_.global.rate_hz + known_.delay;
    known_.forces.assign(tools_.size(), SpectrumMeter(options_.local.rate_hz, use, kMemory));
  }
  for (const LocalReport& report : reports) {
    std::array<Vec3, kMaxTools> force{Vec3::Zero(), Vec3::Zero()};
    for (const TickContact& s : report.contacts())
      force[static_cast<std::size_t>(s.tool)] += options_.local.rate_hz * s.impulse;
    for (std::size_t k = 0; k < known_.forces.size(); ++k)
      if (known_.forces[k].seconds() > 0 || !force[k].isZero(0)) known_.forces[k].add(force[k]);
  }
  BandPowers all{};
  double longest = 0;
  for (const SpectrumMeter& meter : known_.forces) {
    const BandPowers its = meter.powers();
    all.total += its.total;
    for (std::size_t i = 0; i < kBands; ++i) all.changing[i] += its.changing[i];
    longest = std::max(longest, meter.seconds());
  }
  if (longest >= kEnough && all.total > 0) choice_.excite(excitation_of(all));
}

/// The clock's time is shared out by parts; of all of it the processor's is taken.
void Refresher::charge(double cpu_ms) {
  const double all = record_.global_ms.value_or(0) + record_.refresh_ms;
  const double own = record_.reduce_ms + record_.certify_ms + record_.prepare_ms;
  choice_.note_cost(cpu_ms, all > 0 ? cpu_ms * std::min(1.0, own / all) : cpu_ms, record_.refine_cpu_ms, tick());
}

/// Springs resist stretching only: a tetrahedron pushed through itself does not come back.
int Refresher::count_inverted() const {
  const State& s = global_.state();
  int count = 0;
  for (const Tetrahedron& t : global_.model().mesh().tetrahedra) count += tetrahedron_volume(s.x, t) < 0;
  return count;
}

void Refresher::note_deformation() {
  const State& now = global_.state();
  const double furthest_sq = (now.x - known_.start).reshaped(3, now.x.size() / 3).colwise().squaredNorm().maxCoeff();
  if (!(furthest_sq > known_.furthest_sq)) return;
  known_.furthest_sq = furthest_sq;
  known_.most_deformed = now;
}

void Refresher::report_self_contact() {
  const State& now = global_.state();
  const double dt = now.t - known_.before.t;
  record_.self_contact = TouchingModel(global_.model(), *self_contact_, now, dt).report(now.x);
  if (!look_for_crossings) return;
  const std::vector<Crossing> found = find_crossings(*self_contact_, surface_.triangles, now.x);
  record_.pressed = static_cast<int>(std::ranges::count_if(found, &Crossing::only_touches));
  record_.crossings = static_cast<int>(found.size()) - record_.pressed;
}

/// A body in contact with itself: with its contacts there, and the friction of the step that led there.
void Refresher::linearize_at(const State& state, TangentKind kind) {
  if (!self_contact_) {
    linearized_x_ = state.x;
    return linearize(global_.model().own(), own_part(global_.model(), state), kind, tangent_);
  }
  const State& from = state.t > global_.state().t ? global_.state() : known_.before;
  const double dt = state.t > from.t ? state.t - from.t : 1 / options_.global.rate_hz;
  const TouchingModel touching(global_.model(), *self_contact_, from, dt);
  touching.find_near(state.x);
  linearize(touching, state, kind, tangent_);
  linearized_x_ = state.x;
}

/// Throws IndefiniteTangent.
LocalModel Refresher::reduce_at(const State& state, TangentKind kind, const SurfacePatch& patch,
                                const ContactSite& site) {
  auto start = std::chrono::steady_clock::now();
  linearize_at(state, kind);
  record_.linearize_ms += milliseconds_since(start);
  std::future<Refined> refined;
  fine_due_ = FineRefresh::Due::now;
  if (fine_) {
    fine_patch_ = patch.global_triangle;
    if (models_come_late(options_))
      fine_due_ = fine_->due(tangent_, kind, linearized_x_, fine_patch_, tools_, seen_, seen_later_);
    if (fine_due_ == FineRefresh::Due::now) refined = start_refining(kind, seen_);
  }
  start = std::chrono::steady_clock::now();
  const double cpu_start = thread_time_ms();
  if (is_new_)
    choice_.set_up(tangent_, patch, site,
                   expect_touch(options_, global_.model().mesh(), surface_, patch, site,
                                {.is_refined = fine_.has_value(), .is_projected = is_geometric(options_.contact.law)}));
  LocalModel local = choice_.reduce(tangent_, patch, site);
  if (!is_positive_semidefinite(local.stiffness))
    throw IndefiniteTangent("the body's definite tangent is not positive definite");
  record_.reduce_ms += milliseconds_since(start);
  local.definite_tangent |= kind == TangentKind::definite;
  if (!fine_) return local;
  const double cpu_ms = thread_time_ms() - cpu_start;
  if (refined.valid()) {
    const Refined found = refined.get();
    if (StageTimes* times = StageTimes::asked()) times->take(found.stages);
    record_.refine_ms += found.ms;
    record_.refine_cpu_ms += found.cpu_ms;
    record_.beside_ms += std::min(cpu_ms, found.cpu_ms);
    local.fine = found.patch;
  } else {
    local.fine = fine_->found();
  }
  record_.fineness = local.fine ? std::optional(local.fine->fineness) : std::nullopt;
  return local;
}

/// On another core beside what goes on: both only read the tangent, which stays until the next refresh. Throws
/// IndefiniteTangent, but for the definite one: then the cells stay as they are.
std::future<Refresher::Refined> Refresher::start_refining(TangentKind kind, std::span<const SeenTool> tools) {
  return std::async(std::launch::async, [this, kind, tools, asked = StageTimes::asked()] {
    Refined out;
    if (asked) StageTimes::asked() = &out.stages;
    const auto start = std::chrono::steady_clock::now();
    const double cpu_start = thread_time_ms();
    try {
      out.patch = fine_->find(tangent_, kind, linearized_x_, fine_patch_, tools_, tools);
    } catch (const IndefiniteTangent&) {
      if (kind != TangentKind::definite) throw;
    }
    out.ms = milliseconds_since(start);
    out.cpu_ms = thread_time_ms() - cpu_start;
    return out;
  });
}

/// Cells of a body that gives way stay as they were: the next refresh looks again.
void Refresher::take_refined_before() {
  if (!refining_.valid()) return;
  try {
    const Refined found = refining_.get();
    if (StageTimes* times = StageTimes::asked()) times->take(found.stages);
    record_.before_ms = found.cpu_ms;
  } catch (const IndefiniteTangent&) {
  }
}

/// Local models that come late come later still where they wait for refined cells. What can wait is made while this
/// model is in use, and the next one has it: always the next one, so that a run can be repeated.
void Refresher::refine_for_next(TangentKind kind) {
  if (fine_ && fine_due_ == FineRefresh::Due::next) refining_ = start_refining(kind, seen_later_);
}

void Refresher::see_tools(double t, std::span<const Pose> at, std::span<const LocalReport> reports) {
  constexpr double kLatest = 3, kKeeps = 0.9;  // intervals; of a lateness, to the next refresh
  constexpr double kApproach = 0.5;            // [m/s^2] of a hand that comes near
  const double since = models_come_late(options_) ? t - known_.last : 0, usual = 1 / options_.global.rate_hz;
  // One that is in time after late ones may be so because its cells were few.
  known_.late = std::clamp(std::max(since / usual, 1 + kKeeps * (known_.late - 1)), 1.0, kLatest);
  seen_.clear();
  const TouchedBody body{surface_, nodes_, global_.model().mesh().x, global_.state().v};
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    SeenTool& tool = seen_.emplace_back(
        see_tool(body, tools_[k].shape, at[k], reports, static_cast<int>(k), options_.local.rate_hz));
    tool.time = std::clamp(since / interval(t), 1.0, kLatest) * (interval(t) + known_.delay);
    tool.late = known_.late;
    if (known_.delay > 0) tool.acceleration = kApproach;
  }
  seen_later_ = seen_;
  for (SeenTool& tool : seen_later_) tool.time += interval(t);
}

/// A compressed body can have an indefinite tangent; a local model that gains energy would be worse than a stiffer one,
/// and a stiffer one is worse than one of where the body is now.
LocalModel Refresher::reduce(const SurfacePatch& patch, const ContactSite& site, const State* ahead) {
  std::optional<LocalModel> local;
  if (ahead) try {
      local = reduce_at(*ahead, TangentKind::symmetric, patch, site);
      if (local->definite_tangent) local.reset();
    } catch (const IndefiniteTangent&) {
    }
  record_.looked_ahead = local.has_value();
  TangentKind kind = TangentKind::symmetric;
  if (!local) try {
      local = reduce_at(global_.state(), kind, patch, site);
    } catch (const IndefiniteTangent&) {
      kind = TangentKind::definite;
      local = reduce_at(global_.state(), kind, patch, site);
    }
  refine_for_next(kind);
  const auto start = std::chrono::steady_clock::now();
  choice_.revise(*local, site, tick());
  record_.certify_ms = milliseconds_since(start);
  local->certified_error = choice_.certified_error();
  record_.definite_tangent = local->definite_tangent;
  return std::move(*local);
}

/// Vibrations that hardly know of one another are stepped exactly, each by itself; else all by one implicit step.
LocalScheme Refresher::choose_scheme(LocalModel& local) {
  const double coupling = record_.coupling = damping_coupling(local);
  const bool can_be_exact = coupling <= kUncoupled && !is_geometric(options_.contact.law);
  const LocalScheme scheme = scheme_.value_or(can_be_exact ? LocalScheme::exact : LocalScheme::implicit_euler);
  if (scheme == LocalScheme::exact && coupling > 0 && coupling <= kUncoupled) drop_coupling(local);
  record_.is_exact = scheme == LocalScheme::exact;
  return scheme;
}

void Refresher::judge_linearization(std::span<const ContactHold> holds) {
  const double error = std::abs(global_.contact_error());
  record_.linearization_error = error;
  double force = 0;
  for (const ContactHold& hold : holds) force += hold.force;
  if (refreshes_early_) known_.pace.judge(global_.state().t, error, force, options_.local.tolerance);
}

int Refresher::next_interval(int usual) const {
  return known_.pace.interval(usual, known_.delay, options_.local.rate_hz);
}

/// Of a tool while a local model is on its way [m].
Vec3 Refresher::way_until_used(const Vec3& velocity, int tool) const {
  const double speed = velocity.norm();
  const Vec3 followed = speed > kFollowedSpeed ? Vec3(kFollowedSpeed / speed * velocity) : velocity;
  return expected_way(followed, known_.past.came(tool, known_.delay), known_.delay);
}

/// The body in the middle of the time that the model made at time t is used. A tool that presses is not expected to go
/// deeper while the model is on its way: the body stops it, and a hand that swings against a body would be given one
/// that is pressed in further, and swing the more. A tool that is not expected to get anywhere meanwhile is best served
/// with the body as it is.
std::optional<State> Refresher::foresee(double t, std::span<const LocalReport> reports) {
  const double use = 0.5 * interval(t) / known_.pace.haste(), lead = known_.delay + use;
  constexpr double kSomewhere = 0.1;    // of a tool's reach
  constexpr double kLongestStep = 0.1;  // [s] on the way of a tool that drags, a body of springs bends otherwise
  bool goes_on = known_.delay <= 0;
  constexpr double kMostStops = 8;
  std::vector<std::vector<ContactHold>> stops(
      static_cast<std::size_t>(std::min(kMostStops, std::ceil(lead / kLongestStep))));
  for (int k = 0; k < static_cast<int>(tools_.size()); ++k) {
    const Vec3 velocity = tool_velocity(reports, options_.local.rate_hz, k);
    std::vector<ContactHold> holds = last_holds(reports, nodes_, options_.local.rate_hz, tools_[k].shape, k);
    Vec3 step = lead * velocity;
    if (known_.delay > 0) {
      const Vec3 way = along_surface(way_until_used(velocity, k), holds);
      goes_on |= way.norm() > kSomewhere * tool_reach(tools_[k].shape);
      step = way + use * velocity;
    }
    for (std::size_t i = 0; i < stops.size(); ++i) {
      const double share = static_cast<double>(i + 1) / static_cast<double>(stops.size());
      std::ranges::move(moved_holds(holds, surface_, smoothing_, global_.model().mesh().x, share * step),
                        std::back_inserter(stops[i]));
    }
  }
  if (!goes_on) return {};
  return global_.foresee(lead, stops);
}

RefreshMemory Refresher::memory() const {
  return {choice_.state(), known_.pace.from(global_.state().t), known_.forces};
}

void Refresher::go_on_from(const RefreshMemory& memory, int frame, std::shared_ptr<const FinePatch> fine,
                           std::vector<Vec3> offset) {
  choice_.go_on_from(memory.choice);
  known_.pace = memory.pace;
  known_.forces = memory.forces;
  if (fine) nodes_.keep_fine(frame, std::move(fine), std::move(offset));
}

void Refresher::go_on_from(Refresher& before) {
  look_for_crossings = before.look_for_crossings;
  known_ = std::move(before.known_);
  choice_.go_on_from(before.choice_);
  nodes_.go_on_from(before.nodes_);
}

/// At the start everything counts. Later, the tool has no contact because it is outside, as a rule: less than what is
/// noticed is the difference of the two sides.
std::optional<WayOut> Refresher::find_way_out(int tool, const Pose& pose) const {
  constexpr double kRounding = 1e-7, kNoticeable = 1e-4;  // [m]
  constexpr int kFew = 16;
  const bool is_first = known_.frame == 0;
  const ToolShape& shape = tools_[tool].shape;
  return way_out_.find(global_.state().x, shape, pose.x, pose.r, is_first ? kRounding : kNoticeable,
                       is_first ? static_cast<int>(shape.corners.size()) : kFew);
}

/// The body at time t, and where it will be in the middle of the next model's use, if that can be told.
std::optional<State> Refresher::catch_up(double t, std::span<const LocalReport> reports, bool looks_ahead) {
  const auto start = std::chrono::steady_clock::now();
  const LastContacts last = last_contacts(reports, nodes_, options_.local.rate_hz, tools_, fine_.has_value());
  known_.before = global_.state();
  {
    const Stage stage("step");
    global_.advance(t, last.history, last.holds);
  }
  record_.inverted = count_inverted();
  note_deformation();
  if (self_contact_) report_self_contact();
  judge_linearization(last.holds);
  std::optional<State> ahead;
  if (looks_ahead) {
    const Stage stage("look-ahead");
    ahead = foresee(t, reports);
  }
  record_.global_ms = milliseconds_since(start);
  return ahead;
}

/// Where each tool is, how far it can get, and on which triangle: of the last report, else of its way out of the body.
std::vector<ToolPlace> Refresher::place_tools(double t, std::span<const Pose> at, std::span<const LocalReport> reports,
                                              std::array<int, kMaxTools>& way_out) const {
  std::vector<ToolPlace> out;
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    const Vec3 velocity = tool_velocity(reports, options_.local.rate_hz, static_cast<int>(k));
    ToolPlace& tool =
        out.emplace_back(at[k].x, seen_[k].triangle,
                         patch_reach(surface_, global_.state().x, tools_[k], at[k].x, velocity, interval(t),
                                     contact_extent(tools_[k].shape, seen_[k], models_come_late(options_))));
    expect_late(tools_[k], velocity, way_until_used(velocity, static_cast<int>(k)), known_.delay, tool);
    if (tool.triangle >= 0) continue;
    const std::optional<WayOut> way = find_way_out(static_cast<int>(k), at[k]);
    way_out[k] = way ? way->triangle : kOutside;
    if (!way) continue;
    tool.triangle = way->triangle;
    tool.reach += way->depth;
  }
  return out;
}

/// Everything that the tick needs of a local model.
std::unique_ptr<PreparedLocalModel> Refresher::prepare_for_ticks(LocalModel local, std::span<const Pose> at,
                                                                 const ContactSite& site,
                                                                 const std::array<int, kMaxTools>& way_out,
                                                                 const LocalReport* last) {
  const LocalScheme scheme = choose_scheme(local);
  auto out = prepare(std::move(local), scheme, metric_, 1 / options_.local.rate_hz, options_.collision.backend,
                     global_.model().mesh().num_own_nodes(), static_cast<int>(surface_.triangles.size()), smoothing_);
  out->tool = at[0].x;
  out->way_out = way_out;
  out->scheme = scheme;
  out->site = site;
  for (std::size_t k = 0; k < tools_.size(); ++k) out->places[k] = at[k].x;
  out->body_x = linearized_x_;
  if (has_apron_) {
    const Stage stage("apron");
    out->unloaded = unloaded(*out, last);
    std::vector<double> radii;
    for (const TouchTool& tool : tools_) radii.push_back(tool.shape.radius);
    lay_apron(*out, surface_, tangent_.fixed_nodes, radii, options_.collision.backend);
  }
  method_->prepare_method_data(*out, 1 / options_.global.rate_hz);
  return out;
}

/// PreparedLocalModel::unloaded for the contacts of the last tick, as they are sent: in single precision.
VectorX Refresher::unloaded(const PreparedLocalModel& model, const LocalReport* last) const {
  if (!last || last->contacts().empty()) return {};
  const SurfacePatch& patch = model.model.patch;
  VectorX force = VectorX::Zero(3 * patch.num_vertices());
  for (const TickContact& contact : nodes_.on_triangles(*last)) {
    const int t = model.local_triangle[contact.triangle];
    if (t < 0) continue;
    for (int c = 0; c < 3; ++c)
      node(force, patch.triangles[t][c]) += options_.local.rate_hz * contact.bary[c] * contact.impulse;
  }
  return find_unloaded(model, force).cast<float>().cast<double>();
}

void Refresher::carry_over(const LocalMotion& motion, std::span<const LocalReport> reports,
                           PreparedLocalModel& out) const {
  carry_motion(motion, out, nodes_.fine_of(motion.frame));
  const LocalReport* last = last_before(reports, motion.tick);
  if (!last) return;
  std::array<bool, kMaxTools> sliding{};
  for (std::size_t k = 0; k < sliding.size(); ++k) sliding[k] = last->tools[k].sliding;
  place_contacts(out, nodes_.on_triangles(*last), sliding);
}

std::unique_ptr<PreparedLocalModel> Refresher::refresh(double t, std::span<const Pose> at,
                                                       std::span<const LocalReport> reports, const LocalMotion* motion,
                                                       const std::function<void()>& when_reduced) {
  record_ = {.t = t};
  known_.past.add(t, at);
  const bool goes_on = known_.frame == 0 && motion;  // from another run, which has measured these reports
  if (!goes_on) measure_forces(reports);
  std::optional<State> ahead;
  if (t > global_.state().t) ahead = catch_up(t, reports, motion && options_.global.look_ahead);

  const auto start = std::chrono::steady_clock::now();
  std::array<int, kMaxTools> way_out{kNotLooked, kNotLooked};
  take_refined_before();
  see_tools(t, at, reports);
  const ContactSite site = find_contact_sites(surface_, global_.state().x, place_tools(t, at, reports, way_out));
  known_.last = t;
  const SurfacePatch patch = make_patch(surface_, global_.state().x, site, smoothing_.levels > 0);
  LocalModel local = reduce(patch, site, ahead ? &*ahead : nullptr);
  choice_.expect(seen_touch(choice_.expected_touch(), reports, local.fine != nullptr));
  local.frame = known_.frame++;
  is_new_ = false;
  if (when_reduced) when_reduced();

  const auto prepare_start = std::chrono::steady_clock::now();
  auto out = prepare_for_ticks(std::move(local), at, site, way_out, reports.empty() ? nullptr : &reports.back());
  if (!reports.empty()) record_.refined_share = refined_share(out->model, nodes_.on_triangles(reports.back()));
  if (motion && !when_reduced) carry_over(*motion, reports, *out);
  nodes_.keep(*out);
  if (!reports.empty()) nodes_.forget_before(reports.front().model_frame);
  // Ticks do not wait for the next refresh: what its step does once is done now.
  if (known_.frame == 1 && models_come_late(options_) && !self_contact_ &&
      options_.global.integrator == "implicit_euler")
    global_.warm_up(1 / options_.global.rate_hz);
  record_.prepare_ms = milliseconds_since(prepare_start);
  record_.refresh_ms = milliseconds_since(start);
  if (StageTimes* times = StageTimes::asked()) times->close();
  return out;
}

}  // namespace kt
