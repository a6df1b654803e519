#include "haptics/halves/body_side.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/base/cpu_time.hpp"
#include "core/body/embedded_surface.hpp"
#include "haptics/contact/scene_friction.hpp"
#include "haptics/cost/expected_touch.hpp"
#include "haptics/cost/force_factor.hpp"
#include "haptics/halves/live_settings.hpp"
#include "haptics/refresh/refresh_cost.hpp"

namespace kt {

std::string why_no_lattice(const TouchOptions& o) {
  if (o.local.method != "multirate" || is_geometric(o.contact.law))
    return text("object.body lattice: local.method \"", o.local.method, "\" with contact.law \"", o.contact.law,
                "\" touches nodes; take multirate with coulomb");
  if (o.contact.surface != "flat")
    return text("contact.surface \"", o.contact.surface,
                "\": object.body lattice is touched at the triangles of its file; set it to flat");
  return "";
}

namespace {

void check_embedded(const Body& body, const TouchOptions& options) {
  const std::string why = body.surface().embedded ? why_no_lattice(options) : "";
  if (!why.empty()) throw InputError(why);
}

/// Of a moment, for tools that are there now: what has been placed elsewhere has no contact any more, and did not come
/// from there.
std::vector<LocalReport> reports_at(const TouchMoment& moment, std::span<const Pose> tools) {
  std::vector<LocalReport> out = moment.reports;
  LocalReport& last = out.back();
  for (std::size_t k = 0; k < tools.size(); ++k) {
    if (moment.is_at(k, tools[k])) continue;
    for (LocalReport& report : out) report.tools[k] = {tools[k], -1, false};
    const auto all = std::span(last.samples).first(static_cast<std::size_t>(last.count));
    const auto gone = std::ranges::remove_if(all, [&](const TickContact& c) { return c.tool == static_cast<int>(k); });
    last.count -= static_cast<int>(gone.size());
  }
  return out;
}

void show_refined(const FinePatch& fine, RefreshPicture& out) {
  out.refined.resize(static_cast<std::size_t>(fine.num_vertices()));
  for (std::size_t f = 0; f < fine.facets.size(); ++f)
    for (int c = 0; c < 3; ++c) {
      const int a = fine.facets[f][static_cast<std::size_t>(c)],
                b = fine.facets[f][static_cast<std::size_t>(c + 1) % 3];
      out.refined[static_cast<std::size_t>(a)] = {fine.triangle[f], fine.corners[f].col(c)};
      out.refined_edges.push_back({std::min(a, b), std::max(a, b)});
    }
  std::ranges::sort(out.refined_edges);
  const auto [end, last] = std::ranges::unique(out.refined_edges);
  out.refined_edges.erase(end, last);
}

}  // namespace

TouchState check_state(const Body& body, TouchState state) {
  const State& start = body.start();
  if (state.x.size() != start.x.size() || state.v.size() != start.x.size())
    throw InputError(text("reset: a state of ", state.x.size() / 3, " positions and ", state.v.size() / 3,
                          " velocities; this body has ", start.x.size() / 3, " nodes"));
  if (state.moment && state.moment->body != body.identity())
    throw InputError(
        "reset: the state is of another body; take one of this touch, or of a touch that shares its body, or the "
        "positions and velocities alone");
  if (!state.x.allFinite() || !state.v.allFinite()) throw InputError("reset: the state must be finite");
  for (const int i : body.model().fixed_nodes()) {
    node(state.x, i) = node(start.x, i);
    node(state.v, i).setZero();
  }
  if (const auto& embedded = body.model().mesh().embedded)
    for (VectorX* all : {&state.x, &state.v}) embedded->follow(*all);
  return state;
}

BodySide::BodySide(const Body& body, const TouchOptions& options, const TouchState* from)
    : body_(body),
      options_(options),
      material_(body.options().object.model),
      wanted_rate_hz_(options.global.rate_hz),
      wanted_(options),
      wanted_material_(material_) {
  check_embedded(body, options);
  radius_.fill(-1);
  shown_ = from ? State{body.start().t, from->x, from->v} : body.start();
  if (from && from->moment) shown_.t -= from->moment->age / options.local.rate_hz;
  refresher_ = std::make_unique<Refresher>(body.model(), body.surface(), options_, shown_, body.self_contact(),
                                           body.kept_set_up());
  if (options.replay.reducer_changes) refresher_->follow(*options.replay.reducer_changes);
  if (from && from->moment) {
    moment_ = from->moment;
    refresher_->go_on_from(moment_->memory, TouchMoment::kBefore, moment_->fine, moment_->offset);
  }
  status_.reducer = options.local.reducer;
}

void BodySide::set(const std::string& key, double value) {
  const std::scoped_lock lock(guard_);
  const SettingChange change{0, key, value, ""};
  const Renews renews = live_setting(key).renews;
  const std::string& method = options_.local.method;
  if ((renews == Renews::friction || renews == Renews::radius) && method != "multirate" && method != "hold")
    throw InputError(text(key, ": local.method \"", method, "\" keeps it as it was at the start"));
  if (renews == Renews::model) {
    if (body_.self_contact()) throw InputError(text(key, ": not while global.self_contact is on"));
    if (body_.is_own())
      throw InputError(text(key, ": the body's model is the caller's own; its material is not a setting"));
  }
  change_setting(change, {wanted_, wanted_material_});
  wanted_rate_hz_ = wanted_.global.rate_hz;
  keep_last(change);
}

void BodySide::set(const std::string& key, const std::string& word) {
  const std::scoped_lock lock(guard_);
  if (!live_setting(key).word) throw InputError(text(key, " is \"", word, "\", must be a number"));
  const SettingChange change{0, key, 0, word};
  TouchOptions wanted = wanted_;
  change_setting(change, {wanted, wanted_material_});
  check_contact_surface(wanted.contact, wanted.local);
  check_embedded(body_, wanted);
  wanted_ = std::move(wanted);
  keep_last(change);
}

/// No more changes wait than there are settings. The friction coefficients, which move one another, wait as the two
/// values that they have come to.
void BodySide::keep_last(const SettingChange& change) {
  const auto is_friction = [](const SettingChange& c) {
    return c.key == "contact.mu" || c.key == "contact.mu_static" || c.key == "contact.mu_kinetic";
  };
  const bool is_again = std::ranges::any_of(waiting_, [&](const SettingChange& c) { return c.key == change.key; });
  const bool moves_others = is_friction(change);
  if (is_again)
    std::erase_if(waiting_,
                  [&](const SettingChange& c) { return moves_others ? is_friction(c) : c.key == change.key; });
  if (!is_again || !moves_others || change.key == "contact.mu") {
    waiting_.push_back(change);
    return;
  }
  waiting_.push_back({0, "contact.mu_static", wanted_.contact.mu_static, ""});
  waiting_.push_back({0, "contact.mu_kinetic", wanted_.contact.mu_kinetic, ""});
}

int BodySide::interval(int planned) const {
  const double rate = wanted_rate_hz_.load(std::memory_order_relaxed);
  if (!(rate > options_.global.rate_hz)) return planned;
  return std::min(planned, std::max(1, static_cast<int>(std::llround(options_.local.rate_hz / rate))));
}

std::vector<SettingChange> BodySide::waiting() const {
  const std::scoped_lock lock(guard_);
  return waiting_;
}

double BodySide::number(const std::string& key) const {
  const std::scoped_lock lock(guard_);
  const LiveSetting& s = live_setting(key);
  if (!s.number) throw InputError(text(key, ": is a name"));
  LiveCopy wanted{wanted_, wanted_material_};
  return *s.number(wanted);
}

std::string BodySide::word(const std::string& key) const {
  const std::scoped_lock lock(guard_);
  const LiveSetting& s = live_setting(key);
  if (!s.word) throw InputError(text(key, ": is a number"));
  LiveCopy wanted{wanted_, wanted_material_};
  return *s.word(wanted);
}

/// With the body as it is: where it moves to and how fast goes on.
void BodySide::renew_refresher() {
  const DeformableModel& model = model_ ? *model_ : body_.model();
  auto next = std::make_unique<Refresher>(model, body_.surface(), options_, refresher_->state(), body_.self_contact(),
                                          body_.kept_set_up());
  if (options_.replay.reducer_changes) next->follow(*options_.replay.reducer_changes);
  next->go_on_from(*refresher_);
  refresher_ = std::move(next);
}

/// In their order; what they ask for is made anew once, however many ask for it.
void BodySide::apply(const std::vector<SettingChange>& changes) {
  std::array<bool, 4> asked{};
  for (const SettingChange& change : changes) {
    change_setting(change, {options_, material_});
    asked[static_cast<std::size_t>(live_setting(change.key).renews)] = true;
    applied_.push_back(change);
  }
  const auto is_asked = [&](Renews what) { return asked[static_cast<std::size_t>(what)]; };
  if (is_asked(Renews::friction)) {
    std::vector<std::string> none;
    friction_ = std::make_shared<const SurfaceFriction>(
        scene_friction(options_.contact, body_.surface(), body_.model().mesh().x, none));
  }
  if (is_asked(Renews::radius)) radius_[0] = options_.tools[0].shape.radius;
  std::unique_ptr<DeformableModel> before;
  if (is_asked(Renews::model)) before = std::exchange(model_, body_.model_like(material_));
  if (is_asked(Renews::model) || is_asked(Renews::radius) || is_asked(Renews::refresher))
    renew_refresher();  // the old one still reads the model before
}

/// Those that a user has made, or those of the run that is repeated.
void BodySide::apply_changes(int tick) {
  const std::vector<SettingChange>& replayed = options_.replay.changes;
  std::vector<SettingChange> now;
  for (; next_replayed_ < replayed.size() && replayed[next_replayed_].tick <= tick; ++next_replayed_)
    now.push_back(replayed[next_replayed_]);
  const std::size_t old = now.size();
  {
    const std::scoped_lock lock(guard_);
    now.insert(now.end(), waiting_.begin(), waiting_.end());
    waiting_.clear();
  }
  for (std::size_t i = old; i < now.size(); ++i) now[i].tick = tick;
  if (!now.empty()) apply(now);
}

/// Until a local model that is begun at this tick is in use [s]: where ticks do not wait for it, about as long as from
/// the refresh before to this one. More than half as much again as the usual interval is not followed: a larger patch
/// would make the next refresh slower still. From the schedule alone, so that a replay has the same.
double BodySide::delay(int tick) const {
  if (told_delay_) return *told_delay_;
  const double simulated = 1e-3 * options_.link.latency_ms;
  if (!models_come_late(options_)) return simulated;
  const double usual = 1 / options_.global.rate_hz, since = (tick - last_tick_) / options_.local.rate_hz;
  return simulated + std::clamp(since, usual, 1.5 * usual);
}

std::unique_ptr<PreparedLocalModel> BodySide::refresh(RefreshEvent event, std::span<const Pose> at,
                                                      std::span<const LocalReport> reports, const LocalMotion* motion,
                                                      const std::function<double()>& other_ms,
                                                      const std::function<void()>& when_reduced) {
  const double start = process_time_ms() - other_ms();
  apply_changes(event.linearized_tick);
  const double expected = delay(event.linearized_tick);
  refresher_->expect_delay(expected);
  const std::shared_ptr<const TouchMoment> before = std::exchange(moment_, nullptr);
  std::vector<LocalReport> last;
  if (before) {
    last = reports_at(*before, at);
    reports = last;
    motion = &before->motion;
  }
  auto model = refresher_->refresh(event.linearized_tick / options_.local.rate_hz, at, reports, motion, when_reduced);
  model->linearized_tick = event.linearized_tick;
  model->friction = friction_;
  if (friction_) model->base_friction = base_friction(options_.contact);
  model->tool_radius = radius_;
  if (model_) model->material = LiveMaterial{material_.young, material_.damping.mass, material_.damping.stiffness};
  const double took = process_time_ms() - other_ms() - start;
  tell_of_settled();
  RefreshRecord& record = open_.emplace_back(refresher_->record());
  record.event = event;
  record.delay = expected;
  record.cpu_ms = took + record.before_ms;
  record.beside_ms += record.before_ms;
  record.settings = std::exchange(applied_, {});
  record.reducers = refresher_->take_changes();
  last_tick_ = event.linearized_tick;
  ++num_refreshes_;
  const std::scoped_lock lock(guard_);
  shown_ = refresher_->state();
  memory_ = refresher_->memory();
  status_.refreshes = num_refreshes_;
  status_.linearized_tick = event.linearized_tick;
  status_.dof = model->model.dof();
  status_.patch_vertices = model->model.patch.num_vertices();
  status_.fineness = model->model.fine ? model->model.fine->fineness : std::numeric_limits<double>::quiet_NaN();
  status_.force_factor = force_factor(model->model);
  status_.refresh_ms = took;
  status_.expected_force_error = refresher_->choice().expected_force_error();
  status_.certified_error = refresher_->choice().certified_error();
  status_.reducer = refresher_->choice().chosen().name;
  show(model->model, motion);
  return model;
}

double BodySide::force_factor(const LocalModel& model) const {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const auto is_ball = [](const TouchTool& tool) { return tool.shape.kind == ToolShape::Kind::sphere; };
  if (!std::ranges::all_of(options_.tools, is_ball)) return kUnknown;
  const ModelInfo info = (model_ ? *model_ : body_.model()).info();
  if (model.fine) return refined_force_factor(info, model.fine->fineness, body_.surface().embedded != nullptr);
  const Surface& surface = body_.surface();
  const VectorX& x = body_.model().mesh().x;
  double contact = std::numeric_limits<double>::infinity(), cell = 0;
  for (const TouchTool& tool : options_.tools) contact = std::min(contact, expected_contact_radius(tool.shape));
  for (const int i : model.patch.global_triangle) {
    const Triangle& t = surface.triangles[i];
    const Vec3 a = node(x, t[0]);
    cell += std::sqrt((node(x, t[1]) - a).cross(node(x, t[2]) - a).norm());
  }
  cell /= static_cast<double>(model.patch.global_triangle.size());
  if (surface.embedded) cell = surface.embedded->spacing();
  const std::string element = fitted_element(info);
  if (!(cell > 0) || (element == "msd" && cell < kLeastSpringRatio * contact)) return kUnknown;
  return coarse_force_factor(element, cell / contact, options_.contact.surface != "flat");
}

void BodySide::start(const LocalMotion& motion, std::span<const LocalReport> reports, PreparedLocalModel& model) {
  refresher_->carry_over(motion, reports, model);
  open_.back().event.started_tick = motion.tick;
}

/// @param motion  of the local model before, at the same tick; none: there was no other
void BodySide::show(const LocalModel& model, const LocalMotion* motion) {
  picture_.refreshes = status_.refreshes;
  picture_.triangles = model.patch.global_triangle;
  picture_.nodes.clear();
  picture_.distance.clear();
  picture_.refined.clear();
  picture_.refined_edges.clear();
  if (model.fine) show_refined(*model.fine, picture_);
  if (!motion) return;
  for (int i = 0; i < static_cast<int>(motion->row.size()); ++i)
    if (const int row = motion->row[static_cast<std::size_t>(i)]; row >= 0) {
      picture_.nodes.push_back(i);
      picture_.distance.push_back((node(motion->x, row) - node(shown_.x, i)).norm());
    }
}

/// The last one stays: what the refresh after it does may still belong to it.
void BodySide::tell_of_settled() {
  constexpr std::size_t kMostOpen = 256;
  while (!open_.empty() && (open_.size() > kMostOpen || open_.front().event.adopted_tick >= 0 ||
                            open_.front().event.linearized_tick <= overtaken_)) {
    if (observer_) observer_->refreshed(open_.front());
    open_.pop_front();
  }
}

void BodySide::finish() {
  if (!open_.empty()) std::ranges::move(refresher_->take_changes(), std::back_inserter(open_.back().reducers));
  for (const RefreshRecord& record : open_)
    if (observer_) observer_->refreshed(record);
  open_.clear();
}

void BodySide::adopted(int linearized_tick, int tick, const PreparedLocalModel* old) {
  const auto record =
      std::ranges::find(open_, linearized_tick, [](const RefreshRecord& r) { return r.event.linearized_tick; });
  if (record != open_.end()) record->event.adopted_tick = tick;
  overtaken_ = linearized_tick;
  const std::scoped_lock lock(guard_);
  if (old) swaps_.add(*old);
  status_.late_ticks = tick - linearized_tick;
}

void BodySide::failed(const std::string& why) {
  const std::scoped_lock lock(guard_);
  status_.error = why;
}

TouchStatus BodySide::status() const {
  const std::scoped_lock lock(guard_);
  TouchStatus out = status_;
  out.energy = swaps_.booked();
  return out;
}

void BodySide::copy_refresh(RefreshPicture& picture) const {
  const std::scoped_lock lock(guard_);
  picture = picture_;
}

void BodySide::copy_positions(VectorX& x) const {
  const std::scoped_lock lock(guard_);
  x = shown_.x;
}

void BodySide::copy_state(TouchState& state, RefreshMemory& memory) const {
  const std::scoped_lock lock(guard_);
  state.x = shown_.x;
  state.v = shown_.v;
  memory = memory_;
}

}  // namespace kt
