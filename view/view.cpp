#include "view/view.hpp"

#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <future>
#include <map>

#include "core/base/cpu_time.hpp"
#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "haptics/halves/live_settings.hpp"
#include "io/files/child_process.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/scene/named_here.hpp"
#include "io/scene/scene_json.hpp"
#include "view/page_scene.hpp"
#include "view/page_texts.hpp"
#include "view/server/page_message.hpp"

namespace kt {
namespace {

using Kind = PageMessage::Kind;
using Bytes = std::shared_ptr<const std::string>;

Bytes bytes(std::string s) { return std::make_shared<const std::string>(std::move(s)); }

const char* name_of(Kind kind) {
  constexpr const char* kNames[] = {"target", "set",    "restart", "check", "open", "reset",
                                    "pause",  "record", "cancel",  "take",  "seek"};
  return kNames[static_cast<int>(kind)];
}

/// Line ends of what a library says are no more than pauses on a page.
std::string one_line(const std::string& told) {
  std::string out;
  for (const char c : told)
    if (c != '\n')
      out += c;
    else if (!out.empty() && !out.ends_with("; "))
      out += "; ";
  if (out.ends_with("; ")) out.resize(out.size() - 2);
  return visible(out);
}

constexpr int kMostErrors = 200;  // of one page: then it is not listened to any more
constexpr int kStatusEvery = 12;  // ticks of the server

/// The pages of a run or a session.
class Pages : public ServerHandler {
 public:
  explicit Pages(const ViewOptions& options) : options_(options), server_(options.server, *this) {}
  void serve() {
    if (options_.ready) options_.ready(server_.url());
    static const std::atomic<bool> never{false};
    server_.run(options_.stop ? *options_.stop : never);
  }

  void received(int page, const std::string& message) override {
    int& errors = errors_[page];
    if (errors > kMostErrors) return;
    Kind kind = Kind::target;
    try {
      const PageMessage parsed = parse_page_message(message);
      kind = parsed.kind;
      obey(page, parsed);
    } catch (const std::exception& e) {
      ++errors;
      answer(page, name_of(kind), "", one_line(e.what()));
    }
  }
  void joined(int page) override {
    errors_[page] = 0;
    greet(page);
  }
  void left(int page) override { errors_.erase(page); }
  std::string uploaded(const std::string&, const std::string&) override {
    throw InputError("a session is played: no mesh can be opened here");
  }

 protected:
  virtual void greet(int page) = 0;
  virtual void obey(int page, const PageMessage& message) = 0;
  std::vector<int> all() const {
    std::vector<int> out;
    for (const auto& [page, errors] : errors_) out.push_back(page);
    return out;
  }
  void answer(int page, const std::string& to, const std::string& what, const std::string& error) {
    server_.send(page, Server::Kind::text, bytes(answer_text(to, what, without_temporary_folders(error))));
  }
  const ViewOptions& options_;
  Server server_;

 private:
  std::map<int, int> errors_;
};

std::string picture_bytes(const LiveRun::Picture& p, unsigned echo, double stamp) {
  return frame_bytes({p.t, echo, stamp, p.refreshes, p.target, p.tools, p.ticks, &p.positions});
}

class LivePages final : public Pages {
 public:
  LivePages(const Scene& scene, const ViewOptions& options) : Pages(options), own_scene_(scene), scene_(scene) {
    run_ = make_run(scene);
    run_->start(nullptr);
  }
  ~LivePages() override { is_cancelled_ = true; }  // next_ is waited for

  void left(int page) override {
    Pages::left(page);
    if (page != holder_) return;
    holder_ = 0;
    run_->retreat();
  }

  /// In a child process with limits, as third parties' files have everything in them; in a thread of its own.
  std::string uploaded(const std::string& name, const std::string& content) override {
    const std::string extension = mesh_extension(name);
    const std::vector<std::string> known = readable_mesh_extensions();
    if (std::ranges::find(known, extension) == known.end())
      throw InputError(text(visible(name), ": no mesh file that can be read; known: ", join(known)));
    auto folder = std::make_shared<PrivateFolder>();
    const std::string file = *folder / dropped_name(name);
    write_file_whole(file, content);
    std::string findings;
    try {
      findings = options_.examine(file);
    } catch (const std::exception& e) {
      throw InputError(one_line(without_temporary_folders(e.what())));
    }
    const std::scoped_lock lock(dropped_guard_);
    dropped_ = {file, name, std::move(folder)};  // the one before goes, unless its mesh is shown
    return findings;
  }

  void tick() override {
    take_new_run();
    tell_recordings();
    if (server_.num_pages() == 0) return;
    const double start = thread_time_us();
    if (run_->take(picture_)) {
      server_.send_all(Server::Kind::bytes, bytes(picture_bytes(picture_, echo_, stamp_)), true);
      if (run_->take_refresh(refresh_))
        server_.send_all(Server::Kind::bytes, bytes(refresh_bytes(refresh_, run_->shape())));
      frame_us_ = 0.9 * frame_us_ + 0.1 * (thread_time_us() - start);
    }
    if (++ticks_ % kStatusEvery == 0) tell_status();
  }

 private:
  void greet(int page) override {
    if (holder_ == 0) holder_ = page;
    tell_body(page);
  }

  std::unique_ptr<LiveRun> make_run(const Scene& scene) {
    return std::make_unique<LiveRun>(
        scene, options_.by_pointer, options_.save,
        [this](const std::string& folder, const std::string& error) {
          const std::scoped_lock lock(recordings_guard_);
          recordings_.push_back({folder, error});
        },
        options_.count_allocations, options_.link);
  }

  void tell_body(int page) {
    const std::string hello = hello_text(run_->session(), 0, options_.scenes, options_.by_pointer);
    server_.send(page, Server::Kind::text, bytes(without_temporary_folders(hello)));
    server_.send(page, Server::Kind::bytes, bytes(body_bytes(run_->shape(), run_->session().start().x)));
  }

  void tell_status() {
    LiveStatus status = run_->status();
    status.frame_us = frame_us_;
    std::vector<std::pair<std::string, std::string>> settings;
    for (const LiveSetting& s : live_settings()) settings.emplace_back(s.key, run_->setting(s.key));
    const Bytes others = bytes(status_text(status, false, server_.num_pages(), settings));
    for (const int page : all())
      server_.send(page, Server::Kind::text,
                   page == holder_ ? bytes(status_text(status, true, server_.num_pages(), settings)) : others);
  }

  void tell_recordings() {
    const std::scoped_lock lock(recordings_guard_);
    for (const auto& [folder, error] : recordings_)
      server_.send_all(Server::Kind::text, bytes(answer_text("record", folder, error)));
    recordings_.clear();
  }

  void require_tool(int page) const {
    if (page != holder_) throw InputError("another page has the tool; \"take the tool\" first");
  }

  void obey(int page, const PageMessage& m) override {
    if (m.kind == Kind::take) {
      holder_ = page;
      return answer(page, "take", "", "");
    }
    if (m.kind == Kind::seek) throw InputError("seek: nothing is played, the body is live");
    require_tool(page);
    switch (m.kind) {
      case Kind::target:
        echo_ = m.number;
        stamp_ = m.stamp;
        return run_->move(m.x);
      case Kind::set:
        return set(page, m);
      case Kind::restart:
        if (options_.link) throw InputError("the body's computer has the scene: change it there and start it again");
        return begin(page, "restart", [scene = changed(scene_, m.settings)] { return scene; });
      case Kind::check:  // what a restart would take
        changed(scene_, m.settings);
        break;
      case Kind::open:
        if (options_.link) throw InputError("the body's computer has the scene: another one is opened there");
        return open(page, m);
      case Kind::cancel:
        if (!next_.valid()) throw InputError("cancel: no body is being built");
        is_cancelled_ = true;
        return;  // answered as what asked for the body
      case Kind::reset:
        run_->reset();
        break;
      case Kind::pause:
        run_->pause(m.on);
        break;
      case Kind::record:
        if (m.on && options_.before_recording) options_.before_recording();
        run_->record(m.on);
        return;  // answered when it is written
      default:
        break;
    }
    answer(page, name_of(m.kind), "", "");
  }

  static std::pair<std::string, std::string> key_and_value(const std::string& setting) {
    if (setting.find('=') == std::string::npos) throw InputError(text("\"", setting, "\" must be KEY=VALUE"));
    return split_override(setting);
  }

  Scene changed(const Scene& scene, const std::vector<std::string>& settings) const {
    return page_scene(scene, settings, options_.folder);
  }

  /// Checked as --set is, against the values that it runs with, then as what can change while it runs. The scene has
  /// it from now on: a restart keeps it.
  void set(int page, const PageMessage& m) {
    for (const std::string& given : m.settings) {
      const auto [key, value] = key_and_value(given);
      live_setting(key);
      const std::string setting = text(key, "=", value);
      Scene next = with_live_value(scene_, key, setting);
      run_->set(key, value);
      scene_ = std::move(next);
      if (next_.valid()) since_begun_.emplace_back(key, value);
      answer(page, "set", setting, "");
    }
  }

  /// The kinetic friction coefficient follows the static one down, as in change_setting().
  Scene with_live_value(const Scene& scene, const std::string& key, const std::string& setting) const {
    if (key != "contact.mu_static") return changed(scene, {setting});
    Scene out = changed(scene, {"contact.mu_kinetic=0", setting});
    out.contact.mu_kinetic = std::min(scene.contact.mu_kinetic, out.contact.mu_static);
    return out;
  }

  void open(int page, const PageMessage& m) {
    if (m.name == "dropped mesh") {
      const std::scoped_lock lock(dropped_guard_);
      if (!dropped_.folder) throw InputError("open: no mesh was dropped into the page");
      return begin(
          page, "open",
          [this, file = dropped_.file, name = dropped_.name, repairs = m.on] {
            Scene scene = options_.scene_of_mesh(repairs ? options_.repair(file) : file);
            scene.title = visible(name) + " (dropped)";
            return scene;
          },
          dropped_.folder);
    }
    if (std::ranges::find(options_.scenes, m.name) == options_.scenes.end())
      throw_unknown("scene", m.name, options_.scenes);
    begin(page, "open", [this, name = m.name] {
      Scene scene = options_.load_scene(name);
      require_named_here(scene, own_scene_, SceneDoor::others, name);
      return scene;
    });
  }

  /// The next body is built while this one runs on.
  /// @param folder  that the scene's mesh lies in, to be kept as long as it is shown
  void begin(int page, const std::string& what, std::function<Scene()> make,
             std::shared_ptr<PrivateFolder> folder = nullptr) {
    if (next_.valid()) throw InputError(text(what, ": the body before is still being built; a moment"));
    asked_ = {page, what};
    is_cancelled_ = false;
    since_begun_.clear();
    if (!folder && what == "restart") folder = scene_folder_;
    next_ = std::async(std::launch::async, [this, make, folder] {
      const StopsChildren stops(is_cancelled_);
      Next out;
      out.folder = folder;
      out.scene = make();
      try {
        out.run = make_run(out.scene);
      } catch (const InputError& e) {
        throw InputError(without_words_of_files(e.what(), out.scene, folder ? folder->path() : ""));
      }
      return out;
    });
  }

  void take_new_run() {
    if (!next_.valid() || next_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    try {
      Next next = next_.get();
      if (is_cancelled_) throw ChildStopped();
      next.run->start(std::move(run_));
      run_ = std::move(next.run);
      scene_ = std::move(next.scene);
      if (asked_.second == "restart") set_again();
      scene_folder_ = std::move(next.folder);
      for (const int page : all()) tell_body(page);
      answer(asked_.first, asked_.second, scene_.title, "");
    } catch (const ChildStopped&) {
      answer(asked_.first, asked_.second, "", "cancelled: the body before stays");
    } catch (const std::exception& e) {
      answer(asked_.first, asked_.second, "", one_line(e.what()));
    }
  }

  /// What was set while the body was built anew; its scene may not take all of it.
  void set_again() {
    for (const auto& [key, value] : since_begun_) try {
        Scene next = with_live_value(scene_, key, text(key, "=", value));
        run_->set(key, value);
        scene_ = std::move(next);
      } catch (const InputError& e) {
        answer(asked_.first, "set", "", one_line(e.what()));
      }
  }

  struct Next {
    Scene scene;
    std::unique_ptr<LiveRun> run;
    std::shared_ptr<PrivateFolder> folder;
  };
  /// A mesh that was dropped into a page, and the temporary folder that it lies in.
  struct Dropped {
    std::string file, name;  // as the page had it
    std::shared_ptr<PrivateFolder> folder;
  };
  const Scene own_scene_;  // that this computer has named
  Scene scene_;
  int holder_ = 0;  // the page that has the tool
  unsigned echo_ = 0;
  double stamp_ = 0;
  int ticks_ = 0;
  double frame_us_ = 0;  // CPU time of a frame for all pages, mean of the last ten or so
  LiveRun::Picture picture_;
  RefreshPicture refresh_;
  std::mutex recordings_guard_;
  std::vector<std::pair<std::string, std::string>> recordings_;  // written, not told yet
  std::mutex dropped_guard_;
  Dropped dropped_;
  std::shared_ptr<PrivateFolder> scene_folder_;
  std::pair<int, std::string> asked_;
  std::vector<std::pair<std::string, std::string>> since_begun_;  // key, value: set while the next body is built
  std::unique_ptr<LiveRun> run_;
  std::atomic<bool> is_cancelled_{false};  // of next_
  std::future<Next> next_;                 // goes before what it uses
};

class SessionPages final : public Pages {
 public:
  SessionPages(const Scene& scene, SceneFiles files, SessionOptions replay, const ViewOptions& options)
      : Pages(options), playback_(scene, std::move(files), std::move(replay)) {}

  void tick() override {}

 private:
  void greet(int page) override {
    const Session& session = playback_.session();
    server_.send(page, Server::Kind::text, bytes(hello_text(session, playback_.duration(), {}, false)));
    server_.send(page, Server::Kind::bytes, bytes(body_bytes(playback_.shape(), session.start().x)));
    server_.send(page, Server::Kind::bytes, bytes(trace_bytes(1 / session.scene().local.rate_hz, playback_.ticks())));
    show(page, 0, 0);
  }
  void obey(int page, const PageMessage& m) override {
    if (m.kind != Kind::seek) throw InputError("a session is played: it can only be looked at");
    show(page, m.stamp, m.number);
  }
  void show(int page, double t, unsigned number) {
    server_.send(page, Server::Kind::bytes, bytes(picture_bytes(playback_.at(t), number, t)), true);
    server_.send(page, Server::Kind::bytes, bytes(refresh_bytes(playback_.refresh_at(t), playback_.shape())));
  }
  Playback playback_;
};

/// Of a body that a hand on another computer touches: it can only be looked at.
class WatchedPages final : public Pages {
 public:
  WatchedPages(const Session& session, const std::function<bool(WatchedBody&)>& look, const ViewOptions& options)
      : Pages(options),
        session_(session),
        look_(look),
        shape_(make_body_shape(session.surface(), session.model().mesh().num_nodes(), still_nodes(session.model()))) {}

  void tick() override {
    if (server_.num_pages() == 0) return;
    const bool is_touched = look_(body_);
    if (!is_touched) body_ = {session_.start().x, {}, {}};
    picture_.positions = pack_positions(body_.x, shape_.nodes);
    picture_.refreshes = body_.status.refreshes;
    picture_.tools = body_.tools;
    picture_.t = body_.tools.empty() ? picture_.t : body_.tools[0].t;
    picture_.target = body_.tools.empty() ? session_.path().front().x : body_.tools[0].pose.x;
    server_.send_all(Server::Kind::bytes, bytes(picture_bytes(picture_, 0, 0)), true);
    if (++ticks_ % kStatusEvery != 0) return;
    LiveStatus status;
    status.touch = body_.status;
    status.wanted_hz = session_.scene().global.rate_hz;
    status.refresh_hz = refresh_hz(body_.status.refreshes);
    status.told =
        text("is the hand's; here ", std::round(status.refresh_hz), " of ", status.wanted_hz, " refreshes a second");
    status.error = is_touched ? "" : "nobody touches the body now: kilotouch touch, on the hand's computer";
    server_.send_all(Server::Kind::text, bytes(status_text(status, false, server_.num_pages(), {})));
  }

 private:
  void greet(int page) override {
    server_.send(page, Server::Kind::text, bytes(hello_text(session_, 0, {}, false)));
    server_.send(page, Server::Kind::bytes, bytes(body_bytes(shape_, session_.start().x)));
  }
  void obey(int, const PageMessage&) override {
    throw InputError("the hand is on another computer: here the body can only be looked at");
  }
  /// Over the last seconds.
  double refresh_hz(int refreshes) {
    constexpr auto kWindow = std::chrono::seconds(3);
    const auto now = std::chrono::steady_clock::now();
    if (!counted_.empty() && refreshes < counted_.back().second) counted_.clear();
    counted_.emplace_back(now, refreshes);
    while (counted_.front().first < now - kWindow) counted_.pop_front();
    const double seconds = std::chrono::duration<double>(now - counted_.front().first).count();
    return seconds > 0 ? (refreshes - counted_.front().second) / seconds : 0;
  }
  std::deque<std::pair<std::chrono::steady_clock::time_point, int>> counted_;
  const Session& session_;
  std::function<bool(WatchedBody&)> look_;
  BodyShape shape_;
  WatchedBody body_;
  LiveRun::Picture picture_;
  int ticks_ = 0;
};

}  // namespace

void view_watched(const Session& session, const std::function<bool(WatchedBody&)>& look, const ViewOptions& options) {
  WatchedPages(session, look, options).serve();
}

void view_scene(const Scene& scene, const ViewOptions& options) { LivePages(scene, options).serve(); }

void view_session(const Scene& scene, SceneFiles files, SessionOptions replay, const ViewOptions& options) {
  SessionPages(scene, std::move(files), std::move(replay), options).serve();
}

}  // namespace kt
