#include "view/live_run.hpp"

#include <algorithm>
#include <array>
#include <chrono>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "core/base/ticks.hpp"
#include "haptics/halves/body_side.hpp"
#include "haptics/session/metrics.hpp"
#include "haptics/touch/touch.hpp"

namespace kt {
namespace {

constexpr double kSeconds = 3;      // that gauges look back
constexpr double kRetreat = 0.015;  // [m] from the body when nobody holds the pointer
constexpr double kLongest = 600;    // [s] of a recording
constexpr double kMostTime = 0.6;   // [s] of the plot in one frame: a page that was away gets the newest

Scene in_threads(Scene scene, bool over_network) {
  scene.link.type = over_network ? "network" : "thread";
  scene.link.charge_refreshes = "none";
  return scene;
}

}  // namespace

LiveRun::LiveRun(const Scene& scene, bool by_pointer, Save save, Told told,
                 std::function<long long()> count_allocations, NewLink new_link)
    : session_(in_threads(scene, new_link != nullptr)),
      by_pointer_(by_pointer),
      save_(std::move(save)),
      told_(std::move(told)),
      count_allocations_(std::move(count_allocations)),
      new_link_(std::move(new_link)),
      shape_(make_body_shape(session_.surface(), session_.model().mesh().num_nodes(), still_nodes(session_.model()))) {
  if (by_pointer) session_.hold();
  last_target_ = first_place();
}

void LiveRun::start(std::unique_ptr<LiveRun> before) {
  thread_ = std::thread([this, before = std::move(before)]() mutable {
    before.reset();
    go_on();
  });
}

LiveRun::~LiveRun() {
  {
    const std::scoped_lock lock(guard_);
    quits_ = stop_ = true;
  }
  wakes_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void LiveRun::go_on() {
  while (!quits_) {
    try {
      run_once();
    } catch (const std::exception& e) {
      std::unique_lock lock(guard_);
      error_ = e.what();
      waits_ = true;
      wakes_.wait(lock, [this] { return quits_ || !waits_; });
    }
  }
}

void LiveRun::run_once() {
  SessionOptions options;
  {
    const std::scoped_lock lock(guard_);
    stop_ = quits_.load();
    target_ = by_pointer_ ? std::make_shared<MovedTarget>(first_place(), kFollowedSpeed) : nullptr;
    last_target_ = first_place();
    keeps_ = options.keeps_records = options.check_contacts = records_;
    error_.clear();
    step_us_.clear();
    refreshes_.clear();
    ticks_ = misses_ = allocations_ = shown_refresh_ = 0;
  }
  options.watcher = this;
  options.count_allocations = count_allocations_;
  options.stop = &stop_;
  options.pause = &pause_;
  options.target = target_;
  options.is_endless = by_pointer_ || is_live(session_.scene());
  if (new_link_) options.link = new_link_();
  BodyFilm film(session_.model().mesh());
  if (options.keeps_records) options.film = &film;
  SessionResult result = session_.run(options);
  if (!options.keeps_records || result.tools[0].frames.empty()) return;
  {
    const std::scoped_lock lock(guard_);
    records_ = false;
  }
  try {
    told_(save_(session_, result, film), "");
  } catch (const std::exception& e) {
    told_("", e.what());
  }
}

void LiveRun::begun(Touch& touch) {
  const std::scoped_lock lock(guard_);
  touch_ = &touch;
  newest_.tools.clear();  // the run before's
  newest_.ticks.clear();
  for (const SettingChange& change : changed_)
    change.word.empty() ? touch.set(change.key, change.value) : touch.set(change.key, change.word);
}

void LiveRun::ended() {
  const std::scoped_lock lock(guard_);
  touch_ = nullptr;
}

void LiveRun::ticked(std::span<const LocalFrame> frames, double step_us, long long allocations) {
  const std::scoped_lock lock(guard_);
  newest_.tools.assign(frames.begin(), frames.end());
  newest_.t = frames[0].t;
  const int most = ticks_in(kMostTime, session_.scene().local.rate_hz, 16);
  if (static_cast<int>(newest_.ticks.size()) >= most)  // not one at a time: each moves all the others
    newest_.ticks.erase(newest_.ticks.begin(), newest_.ticks.begin() + most / 4);
  newest_.ticks.push_back({static_cast<float>(frames[0].f_n), static_cast<float>(frames[0].f_t), frames[0].mode});
  const auto kept = static_cast<std::size_t>(kSeconds * session_.scene().local.rate_hz);
  if (step_us_.size() < kept)
    step_us_.push_back(static_cast<float>(step_us));
  else
    step_us_[static_cast<std::size_t>(ticks_) % kept] = static_cast<float>(step_us);
  ++ticks_;
  misses_ += step_us * session_.scene().local.rate_hz > 1e6;
  allocations_ += std::max(0LL, allocations);
  if (records_ && newest_.t > kLongest) stop_ = true;
}

void LiveRun::refreshed(const RefreshRecord& record) {
  const std::scoped_lock lock(guard_);
  refreshes_.push_back(record);
  while (refreshes_.front().t < record.t - kSeconds) refreshes_.pop_front();
}

void LiveRun::move(const Vec3& target) {
  const std::scoped_lock lock(guard_);
  if (target_) target_->move(target);
  last_target_ = target;
}

void LiveRun::retreat() {
  Vec3 to = first_place();
  {
    const std::scoped_lock lock(guard_);
    if (newest_.tools.empty()) return;
    const LocalFrame& frame = newest_.tools[0];
    if (frame.normal.squaredNorm() < 0.5) return;  // it touches nothing
    to = frame.pose.x + kRetreat * frame.normal;
  }
  move(to);
}

void LiveRun::pause(bool on) { pause_ = on; }

void LiveRun::reset() {
  {
    const std::scoped_lock lock(guard_);
    stop_ = true;
    waits_ = false;
  }
  wakes_.notify_all();
}

void LiveRun::record(bool on) {
  {
    const std::scoped_lock lock(guard_);
    if (records_ == on) return;
    if (on || !is_kept()) records_ = on;  // else the run that ends now takes it back
  }
  pause_ = false;
  reset();
}

void LiveRun::set(const std::string& key, const std::string& value) {
  const std::scoped_lock lock(guard_);
  SettingChange change{.key = key};
  if (live_setting(key).word) {
    change.word = value;
  } else {
    const std::optional<double> number = to_double(value);
    if (!number) throw InputError(text(key, " is \"", value, "\", must be a number"));
    change.value = *number;
  }
  if (touch_)
    change.word.empty() ? touch_->set(key, change.value) : touch_->set(key, change.word);
  else
    require_next(change);
  remember(change);  // begun() sets it where no run is under way
}

LiveCopy LiveRun::next_values() const {
  LiveCopy out{session_.options(), session_.scene().object.model};
  for (const SettingChange& change : changed_) change_setting(change, out);
  return out;
}

/// A wrong value is told now, not by the next run, which it would end.
void LiveRun::require_next(const SettingChange& change) const {
  LiveCopy next = next_values();
  change_setting(change, next);
}

/// The friction coefficients move one another: kept is what they have come to, in an order that can be set again.
void LiveRun::remember(const SettingChange& change) {
  const std::array<std::string, 3> friction{"contact.mu", "contact.mu_static", "contact.mu_kinetic"};
  const bool moves_others = touch_ && std::ranges::find(friction, change.key) != friction.end();
  std::erase_if(changed_, [&](const SettingChange& c) {
    return c.key == change.key || (moves_others && std::ranges::find(friction, c.key) != friction.end());
  });
  if (!moves_others) return changed_.push_back(change);
  for (const char* key : {"contact.mu_static", "contact.mu_kinetic"})
    changed_.push_back({.key = key, .value = touch_->number(key)});
}

std::string LiveRun::setting(const std::string& key) const {
  const std::scoped_lock lock(guard_);
  const LiveSetting& s = live_setting(key);
  if (touch_) return s.word ? touch_->word(key) : text(touch_->number(key));
  LiveCopy next = next_values();
  return s.word ? *s.word(next) : text(*s.number(next));
}

bool LiveRun::take(Picture& out) {
  {
    const std::scoped_lock lock(guard_);
    if (!touch_ || newest_.tools.empty()) return false;
    touch_->copy_positions(x_);
    newest_.refreshes = touch_->status().refreshes;
    newest_.target = by_pointer_ ? last_target_ : newest_.tools[0].pose.x;
    out = newest_;
    newest_.ticks.clear();
  }
  out.positions = pack_positions(x_, shape_.nodes);
  return true;
}

bool LiveRun::take_refresh(RefreshPicture& out) {
  const std::scoped_lock lock(guard_);
  if (!touch_) return false;
  if (touch_->status().refreshes == shown_refresh_) return false;
  touch_->copy_refresh(out);
  shown_refresh_ = out.refreshes;
  return true;
}

LiveStatus LiveRun::status() {
  const std::scoped_lock lock(guard_);
  LiveStatus out;
  if (touch_) out.touch = touch_->status();
  out.wanted_hz = touch_ ? touch_->number("global.rate_hz") : session_.scene().global.rate_hz;
  out.ticks = ticks_;
  out.misses = misses_;
  out.allocations = allocations_;
  if (is_live(session_.scene()) && !newest_.tools.empty())
    out.gate = (newest_.tools[0].flags & kGated) != 0 ? "shut" : "open";
  out.is_paused = pause_;
  out.is_recording = records_;
  if (records_ && is_kept()) out.recorded_s = newest_.t;
  out.error = error_.empty() ? out.touch.error : error_;
  if (step_us_.empty() || refreshes_.empty()) return out;
  const std::vector<double> step_us(step_us_.begin(), step_us_.end());
  out.tick_p50_us = percentile(step_us, 0.5);
  out.tick_p99_us = percentile(step_us, 0.99);
  const double seconds = std::min(kSeconds, std::max(newest_.t, 1e-3));
  RefreshRun last;
  std::size_t count = 0;
  for (const RefreshRecord& record : refreshes_) {
    if (record.t < newest_.t - seconds) continue;
    last.add(record);
    ++count;
  }
  if (count == 0) last.add(refreshes_.back());  // what the last one took, however long ago
  out.real_time = judge_real_time(session_.scene(), {.seconds = seconds,
                                                     .tick_us = out.tick_p99_us,
                                                     .refreshes = count,
                                                     .wanted_hz = out.wanted_hz,
                                                     .refresh = last,
                                                     .reducer = out.touch.reducer,
                                                     .is_against_clock = true});
  out.refresh_hz = out.real_time.refresh_hz;
  return out;
}

}  // namespace kt
