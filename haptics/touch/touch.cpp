#include "haptics/touch/touch.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>

#include "core/base/ticks.hpp"
#include "core/body/embedded_surface.hpp"
#include "haptics/contact/scene_friction.hpp"
#include "haptics/cost/force_factor.hpp"
#include "haptics/link/mailbox.hpp"
#include "haptics/touch/body_link.hpp"
#include "haptics/touch/keep_memory.hpp"
#include "haptics/touch/patch_lead.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "haptics/watch/flag_counts.hpp"
#include "haptics/watch/touch_watch.hpp"
#include "self_contact/touching_model.hpp"

namespace kt {
namespace {

constexpr double kShapeEvery = 0.016;  // [s] between two shapes for pictures

TouchOptions checked(TouchOptions options) {
  check_options(options);
  return options;
}

SurfaceFriction friction_of(const Body& body, const TouchOptions& options) {
  std::vector<std::string> none;
  return scene_friction(options.contact, body.surface(), body.model().mesh().x, none);
}

}  // namespace

struct Touch::Parts {
  Parts(const Body& touched, TouchOptions wanted, const TouchState* begins = nullptr)
      : body(touched),
        from(begins ? std::optional(*begins) : std::nullopt),
        given(checked(std::move(wanted))),
        options(given),
        friction(friction_of(body, options)),
        haptic(options, friction),
        side(make_side(options)) {
    const double stale_s = options.link.type == "network" ? 1e-3 * options.link.stale_ms : options.stale_s;
    const double slow = std::max(stale_s, 4 / options.global.rate_hz) + 1e-3 * options.link.latency_ms;
    stale_ticks = static_cast<int>(std::llround(slow * options.local.rate_hz));
    shape_every = ticks_in(kShapeEvery, options.local.rate_hz);
    recent.resize(2 * static_cast<std::size_t>(ticks_per_refresh(options)));
    if (from && from->moment) place_as_before(*from->moment);
  }
  std::unique_ptr<BodySide> make_side(const TouchOptions& with) const {
    return std::make_unique<BodySide>(body, with, from ? &*from : nullptr);
  }
  void place_as_before(const TouchMoment& moment) noexcept {
    std::array<Pose, kMaxTools> at;
    for (std::size_t k = 0; k < haptic.num_tools(); ++k) at[k] = moment.last().tools[k].pose;
    haptic.place({at.data(), haptic.num_tools()});
    haptic.go_on_from(moment.force);
    is_placed = true;
  }
  std::size_t slot_of(int tick) const noexcept { return static_cast<std::size_t>(tick) % recent.size(); }
  /// Ticks and times from the next tick on, contacts on triangles: a new local model has other facets.
  void tell_from_now(const ContactSurface& surface, LocalReport& report) const noexcept {
    report.tick -= haptic.next_tick();
    report.model_frame = TouchMoment::kBefore;
    for (TickContact& contact : std::span(report.samples).first(report.contacts().size())) {
      contact.t -= haptic.next_tick() * haptic.h();
      if (contact.facet >= 0)
        contact.bary = weights_in_triangle(contact.facet % (1 << (2 * surface.levels)), surface.levels, contact.bary);
      contact.facet = -1;
    }
  }
  /// Forces of tools that are still where the moment has them go on.
  void drop_forces_of_moved() noexcept {
    std::array<std::optional<Vec3>, kMaxTools> force;
    if (const TouchMoment* moment = from ? from->moment.get() : nullptr)
      for (std::size_t k = 0; k < haptic.num_tools(); ++k)
        if (moment->is_at(k, haptic.poses()[k])) force[k] = moment->force[k];
    haptic.go_on_from(force);
  }
  std::span<LocalFrame> all_frames() noexcept { return {frames.data(), haptic.num_tools()}; }
  std::span<const LocalFrame> tick(std::span<const Pose> tools) noexcept;
  void start(const std::string& type, const LinkMaker& make);
  void refresh_if_due() noexcept;
  bool is_stale() const noexcept;
  RemoteBody* remote() const noexcept { return link ? link->remote() : nullptr; }
  std::unique_ptr<TouchWatch> make_watch() const;
  ModelObserver* observed_by(const std::unique_ptr<TouchWatch>& one) const { return one ? one.get() : observer; }
  void show_shape() noexcept;

  void keep(SettingChange change);

  const Body& body;
  const std::optional<TouchState> from;  // none: the body's start
  const TouchOptions given;              // before start()
  TouchOptions options;
  SurfaceFriction friction;
  HapticSide haptic;
  std::unique_ptr<BodySide> side;
  mutable std::mutex beginning;  // of whoever asks while start() makes the side and the link anew
  ModelObserver* observer = nullptr;
  bool checks = true;                 // see check_contacts()
  std::unique_ptr<TouchWatch> watch;  // as the link; with `beginning`
  std::unique_ptr<BodyLink> link;     // from the first tick, or start(), on
  std::array<LocalFrame, kMaxTools> frames;
  std::vector<LocalReport> recent;            // of the last two intervals, by tick, for state()
  std::array<FlagCounts, kMaxTools> flagged;  // in how many ticks of each tool
  std::atomic<bool> has_touched = false;
  std::vector<SettingChange> changed;  // since the start, the last value of each key last; with `beginning`
  bool is_placed = false, is_stopped = false;
  double owed = 0;  // [s] that have passed and were not stepped
  int stale_ticks = 0, shape_every = 1;
  // The shape of the contact's surroundings, for copy_positions().
  std::atomic<bool> is_watched{false};
  Mailbox<LocalMotion> shape, free_shape;
  std::unique_ptr<LocalMotion> next_shape;  // of the ticking thread
  std::mutex watching;
  std::unique_ptr<LocalMotion> shown;  // of whoever watches
  std::optional<PatchLead> lead;       // the same
  void fade(const VectorX& before, VectorX& x) {
    if (!lead) lead.emplace(body.model().mesh(), still_nodes(body.model()));
    lead->fade(before, x);
    if (const auto& embedded = body.model().mesh().embedded) embedded->follow(x);
  }
};

Touch::Touch(const Body& body, TouchOptions options) {
  keep_freed_memory();
  parts_ = std::make_unique<Parts>(body, std::move(options));
}

Touch::~Touch() = default;

void Touch::place(std::span<const Pose> tools) {
  Parts& p = *parts_;
  if (tools.size() != p.haptic.num_tools())
    throw MisuseError(text("place: ", tools.size(), " poses for ", p.haptic.num_tools(), " tools"));
  if (p.link)
    throw MisuseError(
        "place: called after the first tick or start(); call it before, tools are where the ticks have them");
  for (const Pose& pose : tools)
    if (!is_usable(pose)) throw InputError("place: a pose is not finite, no rotation, or beyond 1e6 m");
  p.haptic.place(tools);
  p.drop_forces_of_moved();
  p.is_placed = true;
}

void Touch::start() { parts_->start("thread", make_thread_link); }

void TouchHalves::start(Touch& touch, const LinkMaker& make) { touch.parts_->start("network", make); }

void Touch::Parts::start(const std::string& type, const LinkMaker& make) {
  if (link) throw MisuseError("start: called after the first tick, or twice; call it once, before");
  if (!is_placed) throw MisuseError("start: called before place(); the first local model is made around the tools");
  if (type == "network" && from)
    throw MisuseError("start: a body on another computer begins at its own start; call reset() without a state");
  TouchOptions with_link = options;
  with_link.link.type = type;
  auto next = make_side(with_link);
  std::vector<SettingChange> early;
  {
    const std::scoped_lock lock(beginning);
    options.link.type = type;
    early = side->waiting();
    for (const SettingChange& c : early) c.word.empty() ? next->set(c.key, c.value) : next->set(c.key, c.word);
    side.swap(next);
  }
  auto looks = make_watch();
  auto made = make(*side, haptic, friction, observed_by(looks));
  if (made->remote())
    for (const SettingChange& c : early) made->remote()->set(c);
  const std::scoped_lock lock(beginning);
  watch = std::move(looks);
  link = std::move(made);
}

/// None: a session looks itself. Methods that let tools in are not blamed for it.
std::unique_ptr<TouchWatch> Touch::Parts::make_watch() const {
  if (!checks) return nullptr;
  std::vector<ToolShape> tools;
  if (options.local.method == "multirate" && options.contact.law == "coulomb") tools = shapes_of(options);
  return std::make_unique<TouchWatch>(body.surface(), tools, haptic.h(), observer);
}

void Touch::stop() {
  BodyLink* const link = parts_->link.get();
  if (!link) return;
  link->stop();
  if (TouchWatch* const watch = parts_->watch.get(); watch && parts_->haptic.has_model())
    watch->finish(parts_->haptic.model());
  parts_->is_stopped = true;
  if (link->error()) std::rethrow_exception(link->error());
}

void Touch::reset() { renew(nullptr); }

void Touch::reset(const TouchState& state) {
  const TouchState checked = check_state(parts_->body, state);
  if (checked.moment && checked.moment->num_tools != num_tools())
    throw InputError(text("reset: a state with ", checked.moment->num_tools, " tools; this touch has ", num_tools()));
  const TouchOptions& o = parts_->options;
  if (checked.moment && (o.local.method != "multirate" || is_geometric(o.contact.law)))
    throw InputError(text("reset: local.method \"", o.local.method, "\" with contact.law \"", o.contact.law,
                          "\" does not go on from contacts; take multirate with coulomb, or positions and velocities "
                          "alone"));
  renew(&checked);
}

/// Whatever fails, the touch stays as it was, without its thread.
void Touch::renew(const TouchState* from) {
  if (parts_->link) parts_->link->stop();
  auto next = std::make_unique<Parts>(parts_->body, parts_->given, from);
  next->observer = parts_->observer;
  next->checks = parts_->checks;
  for (const SettingChange& c : parts_->changed) {
    c.word.empty() ? next->side->set(c.key, c.value) : next->side->set(c.key, c.word);
    next->keep(c);
  }
  parts_ = std::move(next);
}

TouchState Touch::state() const {
  const Parts& p = *parts_;
  const std::scoped_lock lock(p.beginning);
  if (p.remote()) throw MisuseError("state: the body is on another computer; ask for it there");
  TouchState out;
  auto moment = std::make_shared<TouchMoment>();
  p.side->copy_state(out, moment->memory);
  if (!p.haptic.has_model() || p.haptic.next_tick() == 0) {  // no tick was done
    if (p.from) out.moment = p.from->moment;
    return out;
  }
  const PreparedLocalModel& model = p.haptic.model();
  moment->body = p.body.identity();
  moment->num_tools = p.haptic.num_tools();
  moment->motion = make_local_motion(p.body.model().mesh().num_nodes());
  p.haptic.record_motion(moment->motion);
  moment->motion.tick = 0;
  moment->motion.frame = TouchMoment::kBefore;
  moment->fine = model.surface.fine;
  if (moment->fine) moment->offset = offsets_of(model.surface);
  const int since = p.haptic.next_tick() - p.side->status().linearized_tick;
  moment->age = std::clamp(since, 1, static_cast<int>(p.recent.size()));
  const int before = std::max(moment->age, ticks_in(kVelocityTime, p.options.local.rate_hz));
  moment->reports.push_back(p.haptic.past_report(before));
  for (int back = moment->age; back > 0; --back)
    moment->reports.push_back(p.recent[p.slot_of(p.haptic.next_tick() - back)]);
  for (LocalReport& report : moment->reports) p.tell_from_now(model.surface, report);
  for (std::size_t k = 0; k < moment->num_tools; ++k)
    if (p.frames[k].mode != ContactMode::free) moment->force[k] = p.frames[k].force;
  out.moment = std::move(moment);
  return out;
}

namespace {

Finding coarse_cells_finding(const TouchStatus& status, const std::string& refine) {
  const bool is_refined = std::isfinite(status.fineness);
  Finding out{told("object.mesh: the cells under the tool give about ", status.force_factor,
                   " times the force of the continuum",
                   is_refined ? "" : " of a press by a sixteenth of the tool's radius")};
  if (!is_refined && refine == "off") out.cures.push_back(set_to("local.refine", "auto"));
  out.cures.push_back(advise("take a body of elements (object.model.type fem), or smaller cells under the tool"));
  return std::move(out).at("object.mesh", status.force_factor, kCoarseForce);
}

}  // namespace

std::vector<Finding> Touch::findings() const {
  const Parts& p = *parts_;
  std::vector<Finding> found;
  for (const Finding& finding : p.body.findings())
    if (finding.weight != Finding::Weight::note) found.push_back(finding);
  {
    const std::scoped_lock lock(p.beginning);
    const bool is_remote = p.options.link.type == "network";
    const bool keeps_cells = p.options.local.refine == "set-up";
    for (std::size_t k = 0; k < p.haptic.num_tools(); ++k) p.flagged[k].tell(k, is_remote, keeps_cells, found);
    const SelfContact* const touching = p.body.self_contact();
    if (p.watch)
      p.watch->tell(p.flagged[0].all(), p.body.model().mesh().tetrahedra.size(),
                    touching ? touching->options.stiffness : 0, found);
  }
  const TouchStatus s = status();
  if (p.has_touched && (s.force_factor > kCoarseForce || s.force_factor < 1 / kCoarseForce))
    found.push_back(coarse_cells_finding(s, p.options.local.refine));
  if (p.has_touched && p.options.local.method == "multirate" && !is_geometric(p.options.contact.law))
    if (auto wrong = find_wrong_local_model(s.expected_force_error, s.reducer, p.options.local.reducer))
      found.push_back(*std::move(wrong));
  if (const std::string& error = s.error; !error.empty())
    found.push_back({text("the body's simulation ended: ", error), {}, Finding::Weight::failure});
  return found;
}

void Touch::check_contacts(bool on) { parts_->checks = on; }

void Touch::Parts::keep(SettingChange change) {
  std::erase_if(changed, [&](const SettingChange& c) { return c.key == change.key; });
  changed.push_back(std::move(change));
}

void TouchHalves::refresh_if_due(Touch& touch) noexcept { touch.parts_->refresh_if_due(); }

void Touch::Parts::refresh_if_due() noexcept {
  if (!is_placed) return;
  if (!link) {
    auto looks = make_watch();
    if (looks && body.self_contact()) side->refresher().look_for_crossings = true;
    auto made = make_lockstep_link(*side, observed_by(looks));
    const std::scoped_lock lock(beginning);
    watch = std::move(looks);
    link = std::move(made);
  }
  link->before_tick(haptic);
}

std::span<const LocalFrame> Touch::tick(std::span<const Pose> tools) noexcept { return parts_->tick(tools); }

std::span<const LocalFrame> Touch::Parts::tick(std::span<const Pose> tools) noexcept {
  const std::span<LocalFrame> out = all_frames();
  if (tools.size() < out.size()) return out;                                     // wrong use: nothing happens
  if (!is_placed && !std::ranges::all_of(tools.first(out.size()), is_usable)) {  // nobody has said where it begins
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k] = {};
      out[k].flags = kNoModel | kBadPose;
      flagged[k].add(out[k].flags, 0, 0);
    }
    return out;
  }
  if (!is_placed) haptic.place(tools);
  is_placed = true;
  refresh_if_due();
  const LocalReport& report = haptic.tick(tools, out);
  recent[slot_of(report.tick)] = report;
  link->after_tick(haptic, report);
  unsigned flags = link->has_failed() ? kBodyFailed : 0u;
  if (is_stale()) flags |= kStaleModel;
  if (flags != 0)
    for (LocalFrame& frame : out) frame.flags |= flags;
  for (std::size_t k = 0; k < out.size(); ++k) {
    flagged[k].add(out[k].flags, out[k].residual, out[k].t);
    if (out[k].mode != ContactMode::free) has_touched.store(true, std::memory_order_relaxed);
  }
  if (watch && !is_stopped) watch->ticked(haptic, out);
  if (is_watched.load(std::memory_order_relaxed) && haptic.next_tick() % shape_every == 0) show_shape();
  return out;
}

/// Over a network models are old by themselves: there it counts that none comes any more, for longer than their usual
/// age and stale_ticks; of the first model, which was there at once, that age is not known.
bool Touch::Parts::is_stale() const noexcept {
  if (!haptic.has_model()) return false;
  if (options.link.type != "network") return haptic.next_tick() - haptic.model_tick() > stale_ticks;
  const int age = haptic.adopted_tick() - haptic.model_tick();
  const int usual = age > 0 ? std::min(age, stale_ticks) : stale_ticks;
  return haptic.next_tick() - haptic.adopted_tick() > stale_ticks + usual;
}

std::span<const LocalFrame> Touch::tick(std::span<const Pose> tools, double dt) noexcept {
  Parts& p = *parts_;
  const std::span<LocalFrame> out = p.all_frames();
  if (tools.size() < out.size()) return out;
  if (!p.is_placed) return p.tick(tools);
  constexpr double kMostOwed = 1e9;  // steps: beyond, what is left of one is lost in rounding
  if (dt > 0) p.owed += std::min(dt, kMostOwed * h());
  const double steps = std::floor(p.owed / h() + 0.5);
  p.owed -= steps * h();
  const int most = ticks_in(kMostTime, p.options.local.rate_hz, kMostSteps);
  const int count = static_cast<int>(std::min<double>(steps, most));
  std::array<Pose, kMaxTools> from, at;
  for (std::size_t k = 0; k < out.size(); ++k) from[k] = p.haptic.poses()[k];
  for (int i = 1; i <= count; ++i) {
    const double share = static_cast<double>(i) / count;
    for (std::size_t k = 0; k < out.size(); ++k) {
      at[k] = tools[k];
      if (i < count) at[k] = {from[k].x + share * (tools[k].x - from[k].x), from[k].r.slerp(share, tools[k].r)};
    }
    p.tick(std::span<const Pose>(at.data(), out.size()));
  }
  if (steps > count)
    for (LocalFrame& frame : out) frame.flags |= kLateTick;
  if (steps > count) p.flagged[0].add_call(kLateTick, p.haptic.next_tick() * h());
  return out;
}

void Touch::Parts::show_shape() noexcept {
  if (!haptic.has_model()) return;
  if (!next_shape) next_shape = free_shape.take();
  if (!next_shape) return;
  haptic.record_motion(*next_shape);
  next_shape = shape.put(std::move(next_shape));
}

void Touch::copy_positions(VectorX& x) {
  Parts& p = *parts_;
  const std::scoped_lock lock(p.watching, p.beginning);
  if (RemoteBody* remote = p.remote())
    remote->copy_positions(x);
  else
    p.side->copy_positions(x);
  const int nodes = p.body.model().mesh().num_own_nodes();
  if (!p.shown) {
    p.free_shape.put(std::make_unique<LocalMotion>(make_local_motion(nodes)));
    p.shown = std::make_unique<LocalMotion>(make_local_motion(nodes));
    p.is_watched = true;
  }
  if (auto newer = p.shape.take()) {
    p.free_shape.put(std::move(p.shown));
    p.shown = std::move(newer);
  }
  const VectorX before = x;
  for (int i = 0; i < nodes; ++i)
    if (const int row = p.shown->row[i]; row >= 0) node(x, i) = node(p.shown->x, row);
  p.fade(before, x);
}

void TouchHalves::copy_positions_now(Touch& touch, VectorX& x) {
  Touch::Parts& p = *touch.parts_;
  const std::scoped_lock lock(p.watching);
  if (RemoteBody* remote = p.remote())
    remote->copy_positions(x);
  else
    x = p.side->state().x;
  const VectorX before = x;
  p.haptic.lay_patch_over(x);
  p.fade(before, x);
}

/// Here first: what is wrong is told at once, and number() has it.
void Touch::set(const std::string& key, double value) {
  const std::scoped_lock lock(parts_->beginning);
  parts_->side->set(key, value);
  parts_->keep({0, key, value, ""});
  if (RemoteBody* remote = parts_->remote()) remote->set({0, key, value, ""});
}
void Touch::set(const std::string& key, const std::string& word) {
  const std::scoped_lock lock(parts_->beginning);
  parts_->side->set(key, word);
  parts_->keep({0, key, 0, word});
  if (RemoteBody* remote = parts_->remote()) remote->set({0, key, 0, word});
}
double Touch::number(const std::string& key) const {
  const std::scoped_lock lock(parts_->beginning);
  return parts_->side->number(key);
}
std::string Touch::word(const std::string& key) const {
  const std::scoped_lock lock(parts_->beginning);
  return parts_->side->word(key);
}
TouchStatus Touch::status() const {
  const std::scoped_lock lock(parts_->beginning);
  if (const RemoteBody* remote = parts_->remote()) return remote->status();
  return parts_->side->status();
}
void Touch::copy_refresh(RefreshPicture& picture) const {
  const std::scoped_lock lock(parts_->beginning);
  parts_->side->copy_refresh(picture);
}
const Body& Touch::body() const { return parts_->body; }
const TouchOptions& Touch::options() const { return parts_->options; }
std::size_t Touch::num_tools() const { return parts_->haptic.num_tools(); }
int Touch::next_tick() const noexcept { return parts_->haptic.next_tick(); }
double Touch::h() const noexcept { return parts_->haptic.h(); }
std::exception_ptr Touch::error() const noexcept { return parts_->link ? parts_->link->error() : nullptr; }

void TouchHalves::observe(Touch& touch, ModelObserver* observer) { touch.parts_->observer = observer; }
BodySide& TouchHalves::slow(Touch& touch) { return *touch.parts_->side; }
const BodySide& TouchHalves::slow(const Touch& touch) { return *touch.parts_->side; }
const HapticSide& TouchHalves::fast(const Touch& touch) { return touch.parts_->haptic; }
int TouchHalves::lost_reports(const Touch& touch) {
  return touch.parts_->link ? touch.parts_->link->lost_reports() : 0;
}
std::span<const TickContact> TouchHalves::last_samples(const Touch& touch) noexcept {
  return touch.parts_->haptic.samples();
}

}  // namespace kt
