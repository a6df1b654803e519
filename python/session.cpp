#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <utility>

#include "apps/outputs/run_outputs.hpp"
#include "apps/outputs/run_summary.hpp"
#include "haptics/session/session.hpp"
#include "io/files/output_folder.hpp"
#include "python/bindings.hpp"
#include "python/trace.hpp"

namespace kt {
namespace {

/// A run in a thread of its own, so that Python's other threads go on and Ctrl-C is seen.
struct RunThread {
  std::atomic<bool> stop{false};
  std::atomic<double> progress{0};
  std::mutex mutex;
  std::condition_variable changed;
  bool is_over = false;
  bool is_taken = false;  // with the GIL
  SessionResult result;
  std::exception_ptr error;

  /// Whether it is over after at most so many seconds. Without the GIL.
  bool wait(double seconds) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return is_over; });
  }
};

/// Members are touched with the GIL only; who waits without it has the run in hand.
class PythonSession {
 public:
  PythonSession(const NamedScene& named, const py::object& mesh, const py::object& model)
      : has_own_body_(!mesh.is_none() || !model.is_none()) {
    check_body_source(named, mesh, model);
    std::unique_ptr<DeformableModel> own;
    std::optional<Mesh> body;
    if (!model.is_none()) own = model_of(model);
    if (!mesh.is_none()) body = mesh.cast<Mesh>();
    const Scene& scene = named.scene;
    const NoGil no_gil;
    session_ = own    ? std::make_shared<Session>(scene, std::move(own))
               : body ? std::make_shared<Session>(scene, filled(std::move(*body), scene.object))
                      : std::make_shared<Session>(scene);
    course_ = session_->course();
  }
  /// Nobody waits for a run in a thread that it may be waiting for.
  ~PythonSession() {
    const std::shared_ptr<RunThread> run = run_;
    if (!run) return;
    run->stop = true;
    if (is_in_model()) return;
    const NoGil no_gil;
    while (!run->wait(1)) {
    }
  }

  void start(const py::object& path, std::shared_ptr<PushedDevice> pushed) {
    if (is_in_model()) throw RunError("Session: not to be called from the model's own functions");
    if (run_) throw InputError("start: it runs already; stop() gives its trace");
    session_->take(course_);
    if (!path.is_none()) follow(path);
    check_pushed(pushed.get());
    if (pushed && pushed->in_use.exchange(true)) throw InputError("pushed: another session ticks this device");
    auto run = std::make_shared<RunThread>();
    try {
      in_background([run, pushed, session = session_]() mutable { carry_out(*run, pushed, session); },
                    [run] { run->stop = true; });
    } catch (...) {
      if (pushed) pushed->in_use = false;
      throw;
    }
    ++*generation_;
    run_ = std::move(run);
  }

  Trace run(const py::object& path, std::shared_ptr<PushedDevice> pushed) {
    start(path, std::move(pushed));
    const std::shared_ptr<RunThread> run = run_;
    try {
      return take(run);
    } catch (const py::error_already_set&) {  // Ctrl-C ends it
      run->stop = true;
      {
        const NoGil no_gil;
        while (!run->wait(1)) {
        }
      }
      if (run_ == run) run_.reset();
      throw;
    }
  }

  Trace stop() {
    if (is_in_model()) throw RunError("Session: not to be called from the model's own functions");
    if (!run_) throw InputError("stop: nothing runs; start() first");
    run_->stop = true;
    return take(run_);
  }

  bool is_running() const {
    const std::shared_ptr<RunThread> run = run_;
    if (!run) return false;
    const NoGil no_gil;
    return !run->wait(0);
  }

  double progress() const {
    const std::shared_ptr<RunThread> run = run_;
    return run ? run->progress.load() : 0;
  }

  std::vector<Finding> predicted() const {
    std::vector<Finding> out;
    for (const Prediction& p : session_->predictions()) out.push_back(p.finding);
    return out;
  }

 private:
  static void carry_out(RunThread& run, std::shared_ptr<PushedDevice>& pushed, std::shared_ptr<Session>& session) {
    try {
      SessionOptions options;
      options.stop = &run.stop;
      options.progress = [&run](double share) { run.progress = share; };
      if (pushed) options.pushed = pushed->slots;
      run.result = session->run(options);
    } catch (...) {
      run.error = std::current_exception();
    }
    if (pushed) pushed->in_use = false;
    session.reset();
    const std::scoped_lock lock(run.mutex);
    run.is_over = true;
    run.changed.notify_all();
  }

  void check_pushed(const PushedDevice* pushed) const {
    const Scene& scene = session_->scene();
    const auto is_pushed = [](const SceneTool& tool) { return tool.path.device && tool.path.device->name == "pushed"; };
    const int tools = is_pushed(scene.tool) + (scene.second_tool && is_pushed(*scene.second_tool));
    if (pushed && tools == 0) throw InputError("pushed: the scene's tool.path.device.name is not pushed");
    if (pushed && tools > 1) throw InputError("pushed: two tools of the scene are pushed; one can be");
  }

  void follow(const py::object& given) {
    const char* const kShape = "an array of shape (n, 3), n >= 2, is needed [m]: the start, then a row a tick";
    const Floats path = numbers_of(given, "path", kShape);
    if (path.ndim() != 2 || path.shape(1) != 3 || path.shape(0) < 2) throw InputError(text("path: ", kShape));
    std::vector<TimedPoint> points;
    const double h = 1 / session_->scene().local.rate_hz;
    const auto rows = path.unchecked<2>();
    for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
      points.push_back({static_cast<double>(i) * h, {rows(i, 0), rows(i, 1), rows(i, 2)}});
      if (!points.back().x.allFinite()) throw InputError(text("path[", i, "]: a number is not finite"));
    }
    try {
      session_->follow(std::move(points));
    } catch (const InputError&) {
      session_->take(course_);
      throw;
    }
  }

  /// Waits for its end, with an eye on Ctrl-C.
  Trace take(const std::shared_ptr<RunThread> run) {  // a copy: another thread may take run_ away
    for (;;) {
      bool is_over = false;
      {
        const NoGil no_gil;
        is_over = run->wait(0.05);
      }
      if (is_over) break;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
    if (std::exchange(run->is_taken, true)) throw RunError("the run was ended by another thread, which has its trace");
    if (run_ == run) run_.reset();
    if (run->error) std::rethrow_exception(run->error);
    auto out = std::make_shared<RunTrace>();
    out->result = std::move(run->result);
    out->session = session_;
    out->has_own_body = has_own_body_;
    out->generation = *generation_;
    out->newest = generation_;
    const NoGil no_gil;
    out->summary = make_summary(*session_, out->result).dump();
    return {out, 0};
  }

  const bool has_own_body_;
  BuiltScene::Course course_;
  std::shared_ptr<Session> session_;
  std::shared_ptr<int> generation_ = std::make_shared<int>(0);
  std::shared_ptr<RunThread> run_;
};

}  // namespace
}  // namespace kt

KT_MADE_ONLY(kt::PythonSession);

namespace kt {

void save(const Trace& trace, const py::object& path) {
  const RunTrace& run = *trace.run;
  if (run.generation != *run.newest) throw InputError("save: the session has run again since; save a trace before");
  const std::string folder = path_of(path);
  const NoGil no_gil;
  const OutputFolder held(folder, "save: " + folder, run_output_names());
  write_run(folder, *run.session, run.result, nlohmann::ordered_json::parse(run.summary));
  if (run.has_own_body) std::filesystem::remove(folder + "/session.json");  // no file has the body: nothing to replay
}

void bind_session(py::module_& m) {
  bind_trace(m);
  py::class_<PythonSession>(m, "Session",
                            "A scene that can be run, as often as one likes, each time from its start on.")
      .def(py::init<const NamedScene&, const py::object&, const py::object&>(), py::arg("scene"),
           py::arg("mesh") = py::none(), py::arg("model") = py::none(),
           "mesh is a kilotouch.Mesh for the scene's own, model a kilotouch.Model for it.")
      .def(
          "run",
          [](PythonSession& s, const py::object& path, std::shared_ptr<PushedDevice> pushed) {
            return s.run(path, std::move(pushed));
          },
          py::arg("path") = py::none(), py::arg("pushed") = py::none(),
          "The Trace of the whole run, as of `kilotouch run`. path is (n, 3) [m] of the first tool, in place of the "
          "scene's, "
          "with its start, then its place after each tick. pushed is a PushedDevice that another thread drives. Ctrl-C "
          "ends "
          "it.")
      .def(
          "start",
          [](PythonSession& s, const py::object& path, std::shared_ptr<PushedDevice> pushed) {
            s.start(path, std::move(pushed));
          },
          py::arg("path") = py::none(), py::arg("pushed") = py::none(),
          "The same in a thread of its own. stop() gives its trace.")
      .def(
          "stop", [](PythonSession& s) { return s.stop(); },
          "Ends a run that was started, and gives its Trace. Raises the exception that ended it before.")
      .def_property_readonly("is_running", [](PythonSession& s) { return s.is_running(); })
      .def_property_readonly(
          "progress", [](PythonSession& s) { return s.progress(); },
          "Share of the started run that is done, 0 to 1, and 0 until its first tick.")
      .def_property_readonly(
          "predictions", [](PythonSession& s) { return lines(s.predicted()); },
          "Faults of a run that were found at set-up, a list of sentences.")
      .def_property_readonly(
          "findings", [](PythonSession& s) { return dicts_of(s.predicted()); },
          "The same as values, as Touch.findings.");
}

}  // namespace kt
