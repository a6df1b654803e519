// The C interface over HeldTouch. Nothing is decided here.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>

#include "api/held_touch.hpp"
#include "api/kilotouch.h"
#include "api/kilotouch.hpp"

const char* kt::version() noexcept { return KT_VERSION; }

struct kt_touch : kt::HeldTouch {
  using HeldTouch::HeldTouch;
};

namespace {

thread_local std::string last_error = "no call has failed";

kt_status fail(kt_status status, const char* what) noexcept try {
  last_error = what;
  return status;
} catch (...) {
  return status;
}

constexpr const char* kNoMemory = "more memory is needed than there is: take a coarser mesh";

/// Runs f; no exception leaves it.
template <class F>
kt_status guarded(F&& f) noexcept try {
  f();
  return KT_OK;
} catch (const kt::MisuseError& e) {
  return fail(KT_MISUSE, e.what());
} catch (const kt::InputError& e) {
  const std::string_view words = e.what(), option = "--set ";  // of a setting: there is no command line here
  return fail(KT_INPUT, e.what() + (words.starts_with(option) ? option.size() : 0));
} catch (const std::bad_alloc&) {
  return fail(KT_RUN, kNoMemory);
} catch (const std::length_error&) {
  return fail(KT_RUN, kNoMemory);
} catch (const std::exception& e) {
  return fail(KT_RUN, e.what());
} catch (...) {
  return fail(KT_RUN, "unknown failure");
}

kt_status misuse(const char* what) noexcept { return fail(KT_MISUSE, what); }

std::vector<std::string> texts(const char* const* settings, std::size_t count) {
  std::vector<std::string> out;
  constexpr std::size_t kMost = 100000;
  if (count > kMost) throw kt::MisuseError(kt::text("settings: count is ", count, ", must be at most ", kMost));
  if (count > 0 && !settings) throw kt::MisuseError("settings: a null pointer");
  for (std::size_t i = 0; i < count; ++i) {
    if (!settings[i]) throw kt::MisuseError(kt::text("settings[", i, "]: a null pointer"));
    out.emplace_back(settings[i]);
  }
  return out;
}

#if KT_BUILD_APPS
kt::Scene scene_of(const std::vector<std::string>& settings) {
  return kt::parse_scene("{\"object\": {\"mesh\": \"-\"}}", settings, "settings");
}
kt::Scene scene_file(const char* file, const std::vector<std::string>& settings) {
  return kt::load_scene(file, settings);
}
#else
kt::Scene scene_of(const std::vector<std::string>& settings) {
  if (!settings.empty()) throw kt::InputError("settings: this build reads none (KT_BUILD_APPS is off)");
  return {};
}
kt::Scene scene_file(const char*, const std::vector<std::string>&) {
  throw kt::InputError("this build reads no scene files (KT_BUILD_APPS is off)");
}
#endif

/// More are no numbers of ours: three or four times as many are counted in 31 bits.
void check_count(const char* what, std::size_t count) {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max() / 4;
  if (count > kMost) throw kt::InputError(kt::text(what, " is ", count, ", must be at most ", kMost));
}

template <class F>
kt_touch* opened(F&& open) noexcept {
  kt_touch* out = nullptr;
  guarded([&] { out = open(); });
  return out;
}

/// Element i of a caller's array, whose elements may be shorter or longer than ours.
template <class T>
const T* at(const T* array, std::size_t i) noexcept {
  return reinterpret_cast<const T*>(reinterpret_cast<const char*>(array) + i * array->size);
}

constexpr std::size_t kPoseSize = offsetof(kt_pose, turn) + sizeof(kt_pose::turn);
constexpr std::size_t kFrameHead = offsetof(kt_frame, t) + sizeof(double);

bool to_poses(const kt_pose* tools, std::size_t count, std::array<kt::Pose, kt::kMaxTools>& out) noexcept {
  if (tools->size < kPoseSize) return false;
  for (std::size_t k = 0; k < count; ++k) {
    const kt_pose& p = *at(tools, k);
    out[k] = {{p.x[0], p.x[1], p.x[2]}, kt::Quaternion(p.turn[0], p.turn[1], p.turn[2], p.turn[3])};
  }
  return true;
}

void put(const kt::LocalFrame& f, kt_frame* out, std::size_t room) noexcept {
  kt_frame frame{};
  frame.size = static_cast<std::uint32_t>(room);
  frame.flags = f.flags;
  frame.t = f.t;
  const auto copy = [](const kt::Vec3& v, double* to) { std::copy_n(v.data(), 3, to); };
  copy(f.force, frame.force);
  copy(f.torque, frame.torque);
  copy(f.normal, frame.normal);
  copy(f.point, frame.point);
  frame.f_n = f.f_n;
  frame.f_t = f.f_t;
  frame.gap = f.gap;
  frame.mode = static_cast<std::int32_t>(f.mode);
  frame.triangle = f.triangle;
  frame.contacts = f.contacts;
  frame.model_frame = f.model_frame;
  std::memcpy(out, &frame, std::min(room, sizeof frame));
}

template <class Tick>
kt_status ticked(kt_touch* touch, const kt_pose* tools, std::size_t count, kt_frame* frames, Tick&& tick) noexcept {
  if (!touch || !tools || !frames) return misuse("kt_tick: a null pointer");
  if (count != touch->touch.num_tools()) return misuse("kt_tick: as many poses and frames as there are tools");
  std::array<kt::Pose, kt::kMaxTools> poses;
  const std::size_t room = frames->size;
  if (!to_poses(tools, count, poses)) return misuse("kt_pose.size: set it to sizeof(kt_pose)");
  if (room < kFrameHead) return misuse("kt_frame.size: set it to sizeof(kt_frame)");
  const std::span<const kt::LocalFrame> out = tick(std::span<const kt::Pose>(poses.data(), count));
  for (std::size_t k = 0; k < count; ++k)
    put(out[k], reinterpret_cast<kt_frame*>(reinterpret_cast<char*>(frames) + k * room), room);
  return KT_OK;
}

template <class Number, class Values>
kt_status copied(const Values& values, Number* out, std::size_t room, std::size_t* needed) {
  if (needed) *needed = values.size();
  if (!out) return KT_OK;
  if (room < values.size()) return misuse("there is not enough room: see `needed`");
  std::copy(values.begin(), values.end(), out);
  return KT_OK;
}

}  // namespace

extern "C" {

const char* kt_version(void) { return kt::version(); }
uint32_t kt_api_version(void) { return KT_API_VERSION; }
const char* kt_last_error(void) { return last_error.c_str(); }

kt_touch* kt_open_scene(const char* file, const char* const* settings, size_t count) {
  if (!file) return misuse("kt_open_scene: a null pointer"), nullptr;
  return opened([&] { return new kt_touch(scene_file(file, texts(settings, count))); });
}

kt_touch* kt_open_mesh(const char* file, const char* const* settings, size_t count) {
  if (!file) return misuse("kt_open_mesh: a null pointer"), nullptr;
  return opened([&] {
    kt::Scene scene = scene_of(texts(settings, count));
    scene.object.mesh = file;
    return new kt_touch(scene);
  });
}

kt_touch* kt_open_arrays(const double* xyz, size_t nodes, const int32_t* triangles, size_t num_triangles,
                         const int32_t* tetrahedra, size_t num_tetrahedra, const char* const* settings, size_t count) {
  if (!xyz || (!triangles && num_triangles > 0) || (!tetrahedra && num_tetrahedra > 0))
    return misuse("kt_open_arrays: a null pointer"), nullptr;
  return opened([&] {
    check_count("nodes", nodes);
    check_count("num_triangles", num_triangles);
    check_count("num_tetrahedra", num_tetrahedra);
    kt::Mesh mesh;
    mesh.x = Eigen::Map<const kt::VectorX>(xyz, static_cast<Eigen::Index>(3 * nodes));
    for (size_t i = 0; i < num_triangles; ++i)
      mesh.triangles.push_back({triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]});
    for (size_t i = 0; i < num_tetrahedra; ++i)
      mesh.tetrahedra.push_back(
          {tetrahedra[4 * i], tetrahedra[4 * i + 1], tetrahedra[4 * i + 2], tetrahedra[4 * i + 3]});
    const kt::Scene scene = scene_of(texts(settings, count));
    return new kt_touch(scene, [&] { return kt::body_of_mesh(std::move(mesh), scene); });
  });
}

void kt_close(kt_touch* touch) { delete touch; }
int32_t kt_num_tools(const kt_touch* touch) { return touch ? static_cast<int32_t>(touch->touch.num_tools()) : 0; }

kt_status kt_place(kt_touch* touch, const kt_pose* tools, size_t count) {
  if (!touch || !tools) return misuse("kt_place: a null pointer");
  if (count != touch->touch.num_tools()) return misuse("kt_place: as many poses as there are tools");
  std::array<kt::Pose, kt::kMaxTools> poses;
  if (!to_poses(tools, count, poses)) return misuse("kt_pose.size: set it to sizeof(kt_pose)");
  return guarded([&] { touch->touch.place(std::span<const kt::Pose>(poses.data(), count)); });
}

kt_status kt_start(kt_touch* touch) {
  if (!touch) return misuse("kt_start: a null pointer");
  return guarded([&] { touch->touch.start(); });
}

kt_status kt_stop(kt_touch* touch) {
  if (!touch) return misuse("kt_stop: a null pointer");
  return guarded([&] { touch->touch.stop(); });
}

kt_status kt_tick(kt_touch* touch, const kt_pose* tools, size_t count, kt_frame* frames) {
  return ticked(touch, tools, count, frames, [&](auto poses) { return touch->touch.tick(poses); });
}

kt_status kt_tick_after(kt_touch* touch, const kt_pose* tools, size_t count, double seconds, kt_frame* frames) {
  if (!(seconds >= 0 && std::isfinite(seconds))) return misuse("kt_tick_after: seconds must be finite, 0 or more");
  return ticked(touch, tools, count, frames, [&](auto poses) { return touch->touch.tick(poses, seconds); });
}

kt_status kt_tick_device(kt_touch* touch, const kt_pose* tools, const kt_device* devices, size_t count, double seconds,
                         kt_frame* frames) {
  if (!devices) return misuse("kt_tick_device: a null pointer");
  if (!(seconds > 0 && std::isfinite(seconds))) return misuse("kt_tick_device: seconds must be finite, above 0");
  if (devices->size < sizeof(kt_device)) return misuse("kt_device.size: set it to sizeof(kt_device)");
  std::array<kt::DeviceState, kt::kMaxTools> states;
  for (std::size_t k = 0; k < std::min(count, states.size()); ++k) {
    const kt_device& d = *at(devices, k);
    const bool is_known = d.health >= KT_DEVICE_OK && d.health <= KT_DEVICE_UNCALIBRATED;
    states[k] = {.health = is_known ? static_cast<kt::DeviceHealth>(d.health) : kt::DeviceHealth::fault,
                 .age = d.age,
                 .buttons = d.buttons,
                 .delay = d.delay,
                 .delays = d.delays};
  }
  return ticked(touch, tools, count, frames, [&](std::span<const kt::Pose> poses) {
    return touch->tick_devices(poses, std::span<const kt::DeviceState>(states.data(), count), seconds);
  });
}

kt_status kt_triangles(kt_touch* touch, uint32_t* out, size_t room, size_t* needed) {
  if (!touch) return misuse("kt_triangles: a null pointer");
  kt_status status = KT_OK;
  const kt_status made = guarded([&] {
    std::vector<std::uint32_t> values;
    for (const kt::Triangle& t : touch->body.model().mesh().triangles)
      for (const int i : t) values.push_back(static_cast<std::uint32_t>(i));
    status = copied(values, out, room, needed);
  });
  return made == KT_OK ? status : made;
}

kt_status kt_positions(kt_touch* touch, float* xyz, size_t room, size_t* needed) {
  if (!touch) return misuse("kt_positions: a null pointer");
  kt_status status = KT_OK;
  const kt_status made = guarded([&] {
    kt::VectorX x;
    touch->touch.copy_positions(x);
    const Eigen::VectorXf values = x.cast<float>();
    status = copied(std::span(values.data(), static_cast<std::size_t>(values.size())), xyz, room, needed);
  });
  return made == KT_OK ? status : made;
}

kt_status kt_set_number(kt_touch* touch, const char* key, double value) {
  if (!touch || !key) return misuse("kt_set_number: a null pointer");
  return guarded([&] { touch->touch.set(key, value); });
}

kt_status kt_set_word(kt_touch* touch, const char* key, const char* word) {
  if (!touch || !key || !word) return misuse("kt_set_word: a null pointer");
  return guarded([&] { touch->touch.set(key, std::string(word)); });
}

kt_status kt_get_number(const kt_touch* touch, const char* key, double* value) {
  if (!touch || !key || !value) return misuse("kt_get_number: a null pointer");
  return guarded([&] { *value = touch->touch.number(key); });
}

kt_status kt_warnings(const kt_touch* touch, char* out, size_t room, size_t* needed) {
  if (!touch || !needed || (!out && room > 0)) return misuse("kt_warnings: a null pointer");
  return guarded([&] {
    std::string lines;
    for (const std::string& line : kt::lines(touch->findings())) lines += line + '\n';
    *needed = lines.size() + 1;
    if (room > 0) out[lines.copy(out, room - 1)] = 0;
  });
}

kt_status kt_finding_at(const kt_touch* touch, size_t index, kt_finding* out, size_t* count) {
  if (!touch || !count || (!out && index > 0)) return misuse("kt_finding_at: a null pointer");
  return guarded([&] {
    const std::vector<kt::Finding> found = touch->findings();
    *count = found.size();
    if (!out || index >= found.size()) return;
    const kt::Finding& f = found[index];
    const auto copy = [](const std::string& from, auto& to) {
      std::size_t size = std::min(from.size(), sizeof to - 1);
      while (size < from.size() && size > 0 && (from[size] & 0xC0) == 0x80) --size;  // whole characters of UTF-8
      to[from.copy(to, size)] = 0;
    };
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    kt_finding finding{};
    finding.size = out->size;
    finding.weight = static_cast<int32_t>(f.weight);
    finding.value = f.value.value_or(unknown);
    finding.limit = f.limit.value_or(unknown);
    copy(f.what, finding.what);
    copy(f.where, finding.where);
    if (!f.cures.empty()) {
      copy(f.cures.front().told, finding.cure);
      copy(f.cures.front().key, finding.cure_key);
      copy(f.cures.front().value, finding.cure_value);
    }
    std::memcpy(out, &finding, std::min<std::size_t>(out->size, sizeof finding));
  });
}

kt_status kt_stats_of(const kt_touch* touch, kt_stats* out) {
  if (!touch || !out) return misuse("kt_stats_of: a null pointer");
  return guarded([&] {
    const kt::TouchStatus s = touch->touch.status();
    kt_stats stats{out->size,         s.refreshes,  s.linearized_tick, s.dof,
                   s.patch_vertices,  s.refresh_ms, s.late_ticks,      s.expected_force_error,
                   s.certified_error, s.fineness,   s.force_factor};
    std::memcpy(out, &stats, std::min<std::size_t>(out->size, sizeof stats));
  });
}

}  // extern "C"
