#include "apps/outputs/session_file.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "apps/outputs/run_summary.hpp"
#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "core/body/state.hpp"
#include "haptics/device/recording.hpp"
#include "haptics/halves/live_settings.hpp"
#include "io/files/json_file.hpp"
#include "io/files/text_reader.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/scene/named_here.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

std::uint64_t hash_of(const std::string& content) {
  StateHash hash;
  hash.add(content.data(), content.size());
  return hash.value();
}

/// Of a key of the scene; null: the scene has none.
const std::string* mesh_of(const Scene& scene, const std::string& key) {
  if (key == "object.mesh") return &scene.object.mesh;
  if (key == "tool.mesh") return &scene.tool.mesh;
  if (key == "second_tool.mesh" && scene.second_tool) return &scene.second_tool->mesh;
  return nullptr;
}

/// Seen from every folder.
Scene with_absolute_paths(Scene scene) {
  const auto make = [](std::string& path) {
    if (!path.empty()) path = fs::absolute(path).lexically_normal().string();
  };
  make(scene.object.mesh);
  for (SceneTool* tool : {&scene.tool, scene.second_tool ? &*scene.second_tool : nullptr}) {
    if (!tool) continue;
    make(tool->mesh);
    if (tool->path.recording) make(*tool->path.recording);
  }
  return scene;
}

/// A session file with its name for the messages: every value is looked at before it is used.
class SessionFile {
 public:
  explicit SessionFile(std::string file) : file_(std::move(file)), json_(read_json_file(file_)) {
    if (!json_.is_object()) fail("", "is no group { }");
    for (const char* key : {"scene", "recording", "refreshes", "max_speed", "hash"})
      if (!json_.contains(key)) fail("", text("\"", key, "\" is missing"));
  }

  Scene scene() const {
    if (!json_["scene"].is_object()) fail("scene", "must be a group");
    // The scene keeps its own path, so that figures and outputs are those of the run; the tool goes the way that it
    // went.
    Scene out = parse_scene(json_text(json_["scene"]), {}, file_);
    for (const NamedPlace& named : device_places(out)) named.place->clear();      // a replay opens no device
    if (out.tool.path.recording) out.tool.path.recording = recording(json_, "");  // what it was made from may be gone
    if (out.second_tool && out.second_tool->path.recording)
      out.second_tool->path.recording = recording(second(), "second_tool.");
    return out;
  }

  /// The meshes as they were in the run: beside the session, else where the scene names them, while they are the same.
  SceneFiles files(const Scene& scene) const {
    SceneFiles out;
    if (!json_.contains("files")) return out;  // an older session: its meshes lie where the scene names them
    const Json& list = json_["files"];
    if (!list.is_array()) fail("files", "must be a list");
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string at = text("files[", i, "]");
      if (!list[i].is_object()) fail(at, "must be a group");
      const std::string key = word(list[i], "key", at + "."), name = word(list[i], "file", at + ".");
      const std::string* const named = mesh_of(scene, key);
      if (!named) fail(at, text("is of ", shown_json(Json(key)), ", which the scene does not have"));
      fs::path path = *named;
      if (path.extension() != fs::path(name).extension()) path.replace_extension(fs::path(name).extension());
      const std::string content = held_content(list[i], at);
      out[path.string()] = content;
      path.replace_extension(mesh_extension(name));  // of a pair in capitals the small letters are asked for
      out[path.string()] = content;
    }
    return out;
  }

  SessionOptions options(const Scene& scene, const SceneFiles& files) const {
    SessionOptions out;
    const auto path = [&](const std::string& file) {
      Recording read = read_recording(file, 1 / scene.local.rate_hz);
      return ToolPath{std::move(read.path), std::move(read.poses)};
    };
    out.tool_paths.push_back(path(recording(json_, "")));
    out.max_speeds.push_back(speed(json_, ""));
    if (scene.second_tool) {
      out.tool_paths.push_back(path(recording(second(), "second_tool.")));
      out.max_speeds.push_back(speed(second(), "second_tool."));
    }
    out.replay.refreshes = refreshes(scene);
    if (json_.contains("reducer_changes")) out.replay.reducer_changes = reducer_changes();
    if (json_.contains("setting_changes")) out.replay.changes = setting_changes(scene, files);
    return out;
  }

  std::string hash() const { return word(json_, "hash", ""); }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    throw InputError(text(file_, ": not a session file: ", key, key.empty() ? "" : " ", what));
  }

  const Json& second() const {
    if (!json_.contains("second_tool") || !json_["second_tool"].is_object()) fail("second_tool", "must be a group");
    return json_["second_tool"];
  }

  std::string word(const Json& group, const char* key, const std::string& prefix) const {
    if (!group.contains(key)) fail(prefix + key, "is missing");
    if (!group[key].is_string()) fail(prefix + key, text("is ", shown_json(group[key]), ", must be a text"));
    return group[key].get<std::string>();
  }

  double speed(const Json& group, const std::string& prefix) const {
    constexpr double kFastest = 1e6;  // [m/s]
    if (!group.contains("max_speed")) fail(prefix + "max_speed", "is missing");
    const Json& value = group["max_speed"];
    if (value.is_null()) return std::numeric_limits<double>::infinity();  // of a live device no bound is known
    const double speed = value.is_number() ? value.get<double>() : -1;
    if (!(speed >= 0 && speed <= kFastest))
      fail(prefix + "max_speed",
           text("is ", shown_json(value), ", must be a number 0 .. ", kFastest, " m/s, or null: no bound is known"));
    return speed;
  }

  /// In a folder, wherever that lies: a session that came from elsewhere opens no other file.
  std::string inside(const fs::path& folder, const std::string& name, const std::string& key) const {
    const fs::path path = folder / name;
    std::error_code none;
    if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos ||
        fs::is_symlink(path, none))
      fail(key, text("is ", shown_json(Json(name)), ", must be the name of a file in the session's folder"));
    return path.string();
  }

  std::string recording(const Json& group, const std::string& prefix) const {
    return inside(fs::path(file_).parent_path(), word(group, "recording", prefix), prefix + "recording");
  }

  std::string held_content(const Json& file, const std::string& key) const {
    const std::string hash = word(file, "hash", key + "."), from = unescape_bytes(word(file, "from", key + "."));
    const fs::path folder = fs::path(file_).parent_path() / kHeldFiles;
    std::error_code none;
    if (fs::is_symlink(folder, none)) fail(key, text("lies in ", folder.string(), ", which is a link"));
    const std::string held = inside(folder, word(file, "file", key + "."), key + ".file");
    const std::string read = fs::exists(held, none) ? held : from;
    if (!fs::exists(read, none))
      throw InputError(text(file_, ": the run's mesh is gone: neither ", held, " nor ", read, " is there"));
    std::string out = read_whole_file(read);
    if (hash_text(hash_of(out)) != hash)
      throw InputError(text(read, ": is not the mesh of the run any more (its content has the hash ",
                            hash_text(hash_of(out)), ", in the run ", hash, "); a replay needs that mesh as it was"));
    return out;
  }

  std::vector<RefreshEvent> refreshes(const Scene& scene) const {
    const Json& list = json_["refreshes"];
    const long long ticks = std::llround(scene.duration * scene.local.rate_hz);
    if (!list.is_array() || list.empty()) fail("refreshes", "must be a list with one entry or more");
    std::vector<RefreshEvent> out;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const auto is_tick = [&](const Json& v) { return v.is_number_integer() && v >= -1 && v <= ticks; };
      const Json& r = list[i];
      // Of a network also the delay that was expected, and the ticks whose reports were lost.
      const bool has_lost = r.is_array() && r.size() == 5 && r[4].is_array();
      const std::size_t numbers = has_lost ? 4 : r.size();
      if (!r.is_array() || numbers < 3 || numbers > 4 ||
          !std::all_of(r.begin(), r.begin() + static_cast<long>(numbers), is_tick) ||
          (has_lost && !std::ranges::all_of(r[4], is_tick)))
        fail(text("refreshes[", i, "]"),
             text("is ", shown_json(r),
                  ", must be three ticks: linearized, adopted, started; over a network four and a list"));
      RefreshEvent event{r[0], r[1], r[2]};
      if (numbers == 4) event.delay_ticks = r[3];
      if (has_lost) event.lost = r[4].get<std::vector<int>>();
      if (!std::ranges::is_sorted(event.lost)) fail(text("refreshes[", i, "]"), "has lost ticks that are not in order");
      const bool starts_later = event.started_tick > event.linearized_tick;  // only in two threads
      if (starts_later &&
          (scene.link.type != "thread" || (event.adopted_tick >= 0 && event.started_tick > event.adopted_tick)))
        fail(text("refreshes[", i, "]"),
             text("is ", shown_json(r), ", its local model starts after ",
                  scene.link.type == "thread" ? "it is adopted"
                                              : "its linearization, which link.type thread does only"));
      const bool in_order = i == 0 ? event == RefreshEvent{0, 0, 0}
                                   : event.linearized_tick > out.back().linearized_tick && event.started_tick >= 0 &&
                                         (event.adopted_tick == -1 || event.adopted_tick >= event.linearized_tick);
      if (!in_order)
        fail(text("refreshes[", i, "]"),
             text("is ", shown_json(r), i == 0 ? ", must be [0, 0, 0]" : ", must follow the one before it"));
      out.push_back(event);
    }
    return out;
  }

  /// Of the run's own choice, which may have gone by the clock.
  std::vector<ReducerChange> reducer_changes() const {
    const Json& list = json_["reducer_changes"];
    if (!list.is_array()) fail("reducer_changes", "must be a list");
    std::vector<ReducerChange> out;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Json& c = list[i];
      if (!c.is_array() || c.size() != 3 || !c[0].is_number_integer() || !c[1].is_string() || !c[2].is_string())
        fail(text("reducer_changes[", i, "]"), text("is ", shown_json(c), ", must be a tick, a reducer and why"));
      out.push_back({.tick = c[0], .from = "", .to = c[1], .why = c[2]});
    }
    return out;
  }

  /// That a user made while it ran.
  std::vector<SettingChange> setting_changes(const Scene& scene, const SceneFiles& files) const {
    const Json& list = json_["setting_changes"];
    if (!list.is_array()) fail("setting_changes", "must be a list");
    std::vector<SettingChange> out;
    TouchOptions touch = touch_options(scene, keeping_reader(std::make_shared<SceneFiles>(files)));
    SceneModel material = scene.object.model;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Json& c = list[i];
      if (!c.is_array() || c.size() != 3 || !c[0].is_number_integer() || !c[1].is_string() ||
          !(c[2].is_number() || c[2].is_string()))
        fail(text("setting_changes[", i, "]"), "must be a tick, a key of the scene and its value");
      SettingChange change{.tick = c[0], .key = c[1]};
      if (c[2].is_number()) change.value = c[2];
      if (c[2].is_string()) change.word = c[2];
      try {
        change_setting(change, {touch, material});
      } catch (const InputError& e) {
        fail(text("setting_changes[", i, "]:"), e.what());
      }
      out.push_back(std::move(change));
    }
    return out;
  }

  std::string file_;
  Json json_;
};

}  // namespace

std::string session_file(const std::string& file_or_folder) {
  const std::string file = fs::is_directory(file_or_folder) ? file_or_folder + "/session.json" : file_or_folder;
  if (!fs::exists(file))
    throw InputError(text(file, ": cannot read the session (a run leaves it as OUT/session.json)"));
  return file;
}

std::string scene_text(const Scene& scene) { return to_json(with_absolute_paths(scene)); }

std::vector<HeldFile> held_files(const BuiltScene& built) {
  std::vector<HeldFile> out;
  for (const auto& [key, name] :
       {std::pair("object.mesh", "body"), {"tool.mesh", "tool"}, {"second_tool.mesh", "second_tool"}}) {
    const std::string* const named = mesh_of(built.scene(), key);
    if (!named) continue;
    const std::string extension = mesh_extension(*named);
    const bool is_pair = extension == ".node" || extension == ".ele";
    for (const auto& [path, content] : built.files())
      if (path == *named || (is_pair && fs::path(path).replace_extension() == fs::path(*named).replace_extension()))
        out.push_back({key, name + fs::path(path).extension().string(), fs::absolute(path).string(), content});
  }
  return out;
}

nlohmann::ordered_json session_json(const Session& session, const SessionResult& result) {
  Json refreshes = Json::array();
  for (const RefreshEvent& r : result.refreshes) {
    refreshes.push_back({r.linearized_tick, r.adopted_tick, r.started_tick});
    if (r.delay_ticks >= 0 || !r.lost.empty()) refreshes.back().push_back(r.delay_ticks);
    if (!r.lost.empty()) refreshes.back().push_back(r.lost);
  }
  Json out{{"kilotouch", KT_VERSION},      {"scene", Json::parse(to_json(session.scene()))},
           {"recording", "recording.csv"}, {"max_speed", result.tools[0].max_speed},
           {"refreshes", refreshes},       {"hash", hash_text(result.hash)}};
  out["files"] = Json::array();
  for (const HeldFile& f : held_files(session))
    out["files"].push_back(
        {{"key", f.key}, {"file", f.name}, {"hash", hash_text(hash_of(f.content))}, {"from", escape_bytes(f.from)}});
  out["reducer_changes"] = Json::array();
  for (const ReducerChange& c : result.reducer_changes) out["reducer_changes"].push_back({c.tick, c.to, c.why});
  if (!result.setting_changes.empty()) out["setting_changes"] = Json::array();
  for (const SettingChange& c : result.setting_changes)
    out["setting_changes"].push_back({c.tick, c.key, c.word.empty() ? Json(c.value) : Json(c.word)});
  if (result.tools.size() > 1)
    out["second_tool"] = {{"recording", "recording_2.csv"}, {"max_speed", result.tools[1].max_speed}};
  return out;
}

SavedSession read_session(const std::string& file) {
  const SessionFile session(file);
  SavedSession out{session.scene(), {}, {}, session.hash()};
  out.files = session.files(out.scene);
  out.options = session.options(out.scene, out.files);
  return out;
}

}  // namespace kt
