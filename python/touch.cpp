#include <unistd.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "api/held_touch.hpp"
#include "python/bindings.hpp"
#include "python/device_reading.hpp"

namespace kt {
namespace {

/// Throws InputError.
TouchState state_of(const py::object& positions, const py::object& velocities) {
  const auto numbers = [](const py::object& given, const char* which) {
    const Floats rows = numbers_of(given, which, "(n, 3)");
    if (rows.ndim() != 2 || rows.shape(1) != 3) throw InputError(text(which, ": must be (n, 3)"));
    return VectorX(Eigen::Map<const VectorX>(rows.data(), rows.size()));
  };
  return {numbers(positions, "positions"), numbers(velocities, "velocities"), nullptr};
}

/// A touch in Python. One thread at a time ticks; a second one is told so.
class PythonTouch {
 public:
  PythonTouch(const NamedScene& named, const py::object& mesh, const py::object& model, const py::object& body_of) {
    if (!body_of.is_none()) {
      share(named, mesh, model, body_of);
      return;
    }
    check_body_source(named, mesh, model);
    std::unique_ptr<DeformableModel> own;
    std::optional<Mesh> body;
    if (!model.is_none()) own = model_of(model);
    if (!mesh.is_none()) body = mesh.cast<Mesh>();
    const NoGil no_gil;
    const Scene& scene = named.scene;
    const auto make = [&] {
      if (own) return Body(std::move(own), body_options(scene));
      return body ? body_of_mesh(std::move(*body), scene) : Body(body_options(scene));
    };
    core_ = std::make_shared<Core>(scene, make);
    scene_of_body_ = scene_of_body(scene);
  }
  /// The body's thread may wait for the interpreter; and it may be that thread which drops the last reference.
  ~PythonTouch() {
    if (!is_in_model()) {
      const NoGil no_gil;
      core_.reset();
      return;
    }
    try {
      in_background([core = core_]() mutable { core.reset(); });
    } catch (const RunError&) {  // Python ends: it is left as it is
      new std::shared_ptr<Core>(core_);
    }
  }

  Touch& touch() { return core_->held.touch; }
  HeldTouch& held() { return core_->held; }
  bool is_started() const { return core_->is_started; }

  /// Alone, and without the GIL.
  template <class F>
  auto alone(F&& f) {
    if (is_in_model()) throw RunError("Touch: not to be called from the model's own functions");
    const NoGil no_gil;
    const Alone lock(*core_);
    return f();
  }

  void start() {
    alone([&] { touch().start(); });
    core_->is_started = true;
    std::erase_if(started(), [](const std::weak_ptr<Core>& one) { return one.expired(); });
    started().push_back(core_);
  }
  void stop() {
    alone([&] { touch().stop(); });
    core_->is_started = false;
  }

  void reset(const TouchState* state) {
    alone([&] { held().reset(state); });
    core_->is_started = false;
  }

  static void end_all() {
    for (const std::weak_ptr<Core>& one : std::exchange(started(), {})) {
      const std::shared_ptr<Core> core = one.lock();
      if (!core || !core->is_started) continue;
      const NoGil no_gil;
      core->is_last = true;
      for (int i = 0; i < 100 && core->ticking.test_and_set(); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      try {
        core->held.touch.stop();
      } catch (const std::exception&) {  // nobody is there to be told
      }
    }
  }

 private:
  /// What of a scene the body is made of.
  static std::string scene_of_body(const Scene& scene) {
    const auto json = nlohmann::json::parse(to_json(scene));
    return json.value("object", nlohmann::json()).dump() +
           json.value(nlohmann::json::json_pointer("/global/self_contact"), nlohmann::json()).dump();
  }
  void share(const NamedScene& named, const py::object& mesh, const py::object& model, const py::object& body_of) {
    if (!py::isinstance<PythonTouch>(body_of)) throw InputError("body_of: must be a kilotouch.Touch");
    if (!mesh.is_none() || !model.is_none())
      throw InputError("body_of: give no mesh or model, the other touch has the body");
    const PythonTouch& other = body_of.cast<const PythonTouch&>();
    scene_of_body_ = scene_of_body(named.scene);
    if (scene_of_body_ != other.scene_of_body_)
      throw InputError("body_of: object or global.self_contact of this scene is not that of the other touch's");
    const NoGil no_gil;
    core_ = std::make_shared<Core>(named.scene, other.core_->held.shared_body());
  }

  struct Core {
    template <class Source>
    Core(const Scene& scene, const Source& body) : held(scene, body) {}
    HeldTouch held;
    std::atomic_flag ticking;
    std::atomic<bool> is_started{false}, is_last{false};  // the latter: Python ends, nobody ticks any more
  };
  struct Alone {
    explicit Alone(Core& its) : core(its) {
      if (!core.ticking.test_and_set()) return;
      const bool is_last = core.is_last;
      if (!is_last) throw RunError("two threads tick one Touch: one at a time may");
      for (;;) pause();  // Python ends
    }
    ~Alone() { core.ticking.clear(); }
    Alone(const Alone&) = delete;
    Alone& operator=(const Alone&) = delete;
    Core& core;
  };
  static std::vector<std::weak_ptr<Core>>& started() {
    static auto* all = new std::vector<std::weak_ptr<Core>>;  // with the GIL
    return *all;
  }
  std::shared_ptr<Core> core_;
  std::string scene_of_body_;
};

}  // namespace
}  // namespace kt

KT_MADE_ONLY(kt::PythonTouch);

namespace kt {
namespace {

struct Tools {
  std::array<Pose, kMaxTools> poses;
  std::size_t count = 0;
  std::span<const Pose> span() const { return {poses.data(), count}; }
};

void check_count(PythonTouch& t, std::size_t given) {
  if (given != t.touch().num_tools())
    throw InputError(text("poses: ", given, " given; the scene has ", t.touch().num_tools(), " tools"));
}

Tools tools_of(PythonTouch& t, const py::args& poses) {
  check_count(t, poses.size());
  Tools out;
  for (const auto& pose : poses) out.poses[out.count++] = pose_of(pose);
  return out;
}

std::optional<double> time_of(const py::object& given) {
  if (given.is_none()) return {};
  const double dt = number_of(given, "dt");
  if (!(dt > 0) || !std::isfinite(dt)) throw InputError(text("dt: ", dt, ", must be above 0 [s]"));
  return dt;
}

/// One frame, or a tuple of as many as there are tools. In lockstep a body that failed is told by its own words.
py::object frames_of(PythonTouch& t, std::span<const LocalFrame> frames) {
  if (std::exchange(was_interrupted(), false)) PyErr_SetInterrupt();
  if (!t.is_started() && (frames[0].flags & kBodyFailed) != 0U && t.touch().error())
    std::rethrow_exception(t.touch().error());
  if (frames.size() == 1) return py::cast(frames[0]);
  py::tuple out(frames.size());
  for (std::size_t k = 0; k < frames.size(); ++k) out[k] = py::cast(frames[k]);
  return out;
}

py::object tick(PythonTouch& t, const py::args& poses, const py::object& time) {
  const Tools tools = tools_of(t, poses);
  const std::optional<double> dt = time_of(time);
  return frames_of(t, t.alone([&] { return dt ? t.touch().tick(tools.span(), *dt) : t.touch().tick(tools.span()); }));
}

py::object tick_device(PythonTouch& t, const py::args& readings, const py::object& time) {
  check_count(t, readings.size());
  const double seconds = time_of(time).value_or(t.touch().h());
  Tools tools;
  std::array<DeviceState, kMaxTools> states;
  for (const auto& given : readings) {
    if (!py::isinstance<DeviceReadingAt>(given)) throw InputError("tick_device: a kilotouch.DeviceReading a tool");
    const auto& reading = given.cast<const DeviceReadingAt&>();
    tools.poses[tools.count] = reading.pose;
    states[tools.count++] = reading.state;
  }
  return frames_of(t, t.alone([&] {
    return t.held().tick_devices(tools.span(), std::span<const DeviceState>(states.data(), tools.count), seconds);
  }));
}

void set(PythonTouch& t, const std::string& key, const py::object& value) {
  if (py::isinstance<py::str>(value))
    t.touch().set(key, value.cast<std::string>());
  else
    t.touch().set(key, number_of(value, key.c_str()));
}

py::object get(PythonTouch& t, const std::string& key) {
  try {
    return py::float_(t.touch().number(key));
  } catch (const InputError&) {
    return py::str(t.touch().word(key));  // or throws: no such setting
  }
}

}  // namespace

void end_touches() { PythonTouch::end_all(); }

void bind_touch(py::module_& m) {
  py::class_<TouchStatus>(m, "Status", "State of a touch after its last refresh.")
      .def_readonly("refreshes", &TouchStatus::refreshes, "refreshes so far")
      .def_readonly("linearized_tick", &TouchStatus::linearized_tick)
      .def_readonly("dof", &TouchStatus::dof, "size of its local model")
      .def_readonly("patch_vertices", &TouchStatus::patch_vertices)
      .def_readonly("refresh_ms", &TouchStatus::refresh_ms, "CPU time, with its global step")
      .def_readonly("late_ticks", &TouchStatus::late_ticks, "ticks until the last local model was in use")
      .def_readonly("expected_force_error", &TouchStatus::expected_force_error,
                    "share, nan where not certified, or the motion and the force are not known for long enough")
      .def_readonly("certified_error", &TouchStatus::certified_error, "error of the impedance, nan where not certified")
      .def_readonly("fineness", &TouchStatus::fineness,
                    "refined cells over the contact radius, nan where none are refined")
      .def_readonly("force_factor", &TouchStatus::force_factor,
                    "force to expect of the cells under the tools over the continuum's, nan where not known")
      .def_readonly("reducer", &TouchStatus::reducer)
      .def_readonly("error", &TouchStatus::error, "why the body's simulation ended; empty: it goes on");

  py::class_<TouchState>(m, "State",
                         "A touch at one moment, from which episodes can begin: the body as the last refresh had it, "
                         "and what its ticks had come to since.")
      .def(py::init(&state_of), py::arg("positions"), py::arg("velocities"),
           "A body alone: positions [m] and velocities [m/s] of its nodes, (n, 3) each.")
      .def("__copy__", [](const TouchState& s) { return s; })
      .def("__deepcopy__", [](const TouchState& s, const py::dict&) { return s; })
      .def("__reduce__",
           [](const TouchState&) -> py::object {
             throw InputError("State: has a local model of this process; pickle its positions and velocities");
           })
      .def_property_readonly(
          "positions", [](const TouchState& s) { return rows_of(s.x); }, "of the body's nodes [m], (n, 3), a copy")
      .def_property_readonly(
          "velocities", [](const TouchState& s) { return rows_of(s.v); }, "of the body's nodes [m/s], (n, 3), a copy");

  py::class_<PythonTouch>(m, "Touch",
                          "A body that tools touch, one call a haptic tick. Without start() the body is refreshed "
                          "inside some ticks, and the same poses give the same bits.")
      .def(py::init<const NamedScene&, const py::object&, const py::object&, const py::object&>(), py::arg("scene"),
           py::arg("mesh") = py::none(), py::arg("model") = py::none(), py::arg("body_of") = py::none(),
           "scene has tools and settings. Its path is not followed. mesh is a kilotouch.Mesh for the scene's own, "
           "model a "
           "kilotouch.Model for it, body_of a Touch whose body this one shares, with the first local model that it "
           "found. InputError with quantity, place, value and allowed range.")
      .def(
          "place",
          [](PythonTouch& t, const py::args& poses) {
            const Tools tools = tools_of(t, poses);
            t.alone([&] { t.touch().place(tools.span()); });
          },
          "Poses of the tools before the first tick.")
      .def(
          "start", [](PythonTouch& t) { t.start(); },
          "The body from now on in a thread of its own. Call it after place(), before the first tick.")
      .def(
          "stop", [](PythonTouch& t) { t.stop(); },
          "Ends that thread. Raises the exception that ended the body's simulation before.")
      .def(
          "reset", [](PythonTouch& t, const TouchState* state) { t.reset(state); }, py::arg("state") = py::none(),
          "Back to before the first tick, with the body as it was at the start, settings as they were set last. With "
          "a state, of this touch or of another one of the same body, the body goes on from there, and the tools are "
          "where they were. A thread of the body's own ends.")
      .def_property_readonly(
          "state", [](PythonTouch& t) { return t.alone([&] { return t.touch().state(); }); },
          "A copy of the touch at this moment, a State, for reset().")
      .def(
          "tick", &tick, py::arg("dt") = py::none(),
          "tick(pose, ...) takes the poses that the tools have come to, one each, (3,) [m], or (7,) with the turn as a "
          "quaternion w x y z. It gives a Frame, of two tools a tuple. dt are the seconds since the last call, for a "
          "loop that does "
          "not keep local.rate_hz.")
      .def(
          "tick_device", &tick_device, py::arg("dt") = py::none(),
          "tick_device(reading, ...) is the same for devices that a person holds, a DeviceReading each. Forces and "
          "torques of the frames are to be written to the devices now. They are made safe by tool.path.device's limits "
          "(docs/devices.md). Call it each period of local.rate_hz. One call is one tick. dt are the seconds that "
          "really passed since the last one.")
      .def("__getitem__", &get, py::arg("key"))
      .def("__setitem__", &set, py::arg("key"), py::arg("value"))
      .def_property_readonly(
          "positions",
          [](PythonTouch& t) {
            VectorX x;
            {
              const NoGil no_gil;
              t.touch().copy_positions(x);
            }
            return rows_of(x);
          },
          "Positions of the body's nodes, as the last refresh had them, with the part around the contact as it was "
          "some "
          "ticks ago, (n, 3) [m], a copy.")
      .def_property_readonly(
          "mesh", [](PythonTouch& t) { return t.held().body.model().mesh(); }, "The mesh at rest, a copy.")
      .def_property_readonly(
          "status", [](PythonTouch& t) { return t.touch().status(); }, "Status after the last refresh.")
      .def_property_readonly(
          "warnings", [](PythonTouch& t) { return lines(t.held().findings()); },
          "Facts against the forces so far, of body and ticks, a line each.")
      .def_property_readonly(
          "findings", [](PythonTouch& t) { return dicts_of(t.held().findings()); },
          "The same as values, a dict each, with what, weight (note, doubt, failure), where, value, limit, and cures "
          "(key, value, told).")
      .def_property_readonly(
          "h", [](PythonTouch& t) { return t.touch().h(); }, "time of a tick [s]")
      .def_property_readonly("num_tools", [](PythonTouch& t) { return t.touch().num_tools(); });
}

}  // namespace kt
