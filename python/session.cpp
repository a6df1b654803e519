#include <atomic>
#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

#include "apps/outputs/run_outputs.hpp"
#include "apps/outputs/run_summary.hpp"
#include "haptics/session/session.hpp"
#include "io/files/output_file.hpp"
#include "python/bindings.hpp"
#include "python/trace.hpp"

namespace kt {
namespace {

/// A run in a thread of its own, so that Python's other threads go on and Ctrl-C is seen.
struct RunThread {
  std::atomic<bool> stop{false};
  std::mutex mutex;
  std::condition_variable changed;
  bool is_over = false;
  SessionResult result;
  std::exception_ptr error;
  std::shared_ptr<DeviceSlots> pushed;
  std::thread thread;
};

class PythonSession {
 public:
  PythonSession(const NamedScene& named, const py::object& mesh, const py::object& model) {
    check_body_source(named, mesh, model);
    std::unique_ptr<DeformableModel> own;
    std::optional<Mesh> body;
    if (!model.is_none()) own = model_of(model);
    if (!mesh.is_none()) body = mesh.cast<Mesh>();
    const Scene& scene = named.scene;
    {
      const py::gil_scoped_release no_gil;
      session_ = own    ? std::make_shared<Session>(scene, std::move(own))
                 : body ? std::make_shared<Session>(scene, filled(std::move(*body), scene.object))
                        : std::make_shared<Session>(scene);
    }
    all().insert(this);
  }
  ~PythonSession() {
    all().erase(this);
    end();
  }

  void start(const py::object& path, const PushedDevice* pushed) {
    if (run_) throw InputError("start: it runs already; stop() gives its trace");
    if (!path.is_none()) follow(path);
    ++*generation_;
    run_ = std::make_unique<RunThread>();
    if (pushed) run_->pushed = pushed->slots;
    run_->thread = std::thread([&run = *run_, session = session_] {
      try {
        SessionOptions options;
        options.stop = &run.stop;
        options.pushed = run.pushed;
        run.result = session->run(options);
      } catch (...) {
        run.error = std::current_exception();
      }
      const std::scoped_lock lock(run.mutex);
      run.is_over = true;
      run.changed.notify_all();
    });
  }

  /// Waits for its end, with an eye on Ctrl-C.
  Trace run(const py::object& path, const PushedDevice* pushed) {
    start(path, pushed);
    while (!wait(0.05))
      if (PyErr_CheckSignals() != 0) {
        end();
        throw py::error_already_set();
      }
    return take();
  }

  Trace stop() {
    if (!run_) throw InputError("stop: nothing runs; start() first");
    run_->stop = true;
    return take();
  }

  /// Whether it is over after at most so many seconds.
  bool wait(double seconds) {
    if (!run_) return true;
    const py::gil_scoped_release no_gil;
    std::unique_lock lock(run_->mutex);
    return run_->changed.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return run_->is_over; });
  }

  bool is_running() { return run_ && !wait(0); }

  std::vector<std::string> predictions() const {
    std::vector<std::string> out;
    for (const Prediction& p : session_->predictions()) out.push_back(p.message);
    return out;
  }

  /// Python ends: nothing of ours goes on behind it.
  static void end_all() {
    for (PythonSession* session : all()) session->end();
  }

 private:
  static std::set<PythonSession*>& all() {
    static std::set<PythonSession*> sessions;  // with the GIL
    return sessions;
  }

  void follow(const py::object& given) {
    using Values = py::array_t<double, py::array::c_style | py::array::forcecast>;
    const Values path = Values::ensure(given);
    if (!path || path.ndim() != 2 || path.shape(1) != 3 || path.shape(0) < 2) {
      PyErr_Clear();
      throw InputError("path: an array of shape (n, 3), n >= 2, is needed [m]: the start, then a row a tick");
    }
    std::vector<TimedPoint> points;
    const double h = 1 / session_->scene().local.rate_hz;
    const auto rows = path.unchecked<2>();
    for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
      points.push_back({static_cast<double>(i) * h, {rows(i, 0), rows(i, 1), rows(i, 2)}});
      if (!points.back().x.allFinite()) throw InputError(text("path[", i, "]: a number is not finite"));
    }
    session_->follow(std::move(points));
  }

  void end() {
    if (!run_) return;
    run_->stop = true;
    {
      const py::gil_scoped_release no_gil;
      run_->thread.join();
    }
    run_.reset();
  }

  Trace take() {
    {
      const py::gil_scoped_release no_gil;
      run_->thread.join();
    }
    const std::unique_ptr<RunThread> over = std::move(run_);
    if (over->error) std::rethrow_exception(over->error);
    auto out = std::make_shared<RunTrace>();
    out->result = std::move(over->result);
    out->session = session_;
    out->generation = *generation_;
    out->newest = generation_;
    const py::gil_scoped_release no_gil;
    out->summary = make_summary(*session_, out->result).dump();
    return {out, 0};
  }

  std::shared_ptr<Session> session_;
  std::shared_ptr<int> generation_ = std::make_shared<int>(0);
  std::unique_ptr<RunThread> run_;
};

}  // namespace

void save(const Trace& trace, const std::string& folder) {
  const RunTrace& run = *trace.run;
  if (run.generation != *run.newest) throw InputError("save: the session has run again since; save a trace before");
  const py::gil_scoped_release no_gil;
  make_folder(folder);
  write_run(folder, *run.session, run.result, nlohmann::ordered_json::parse(run.summary));
}

void bind_session(py::module_& m) {
  bind_trace(m);
  py::class_<PythonSession>(m, "Session",
                            "A scene that can be run, as often as one likes, each time from its start on.")
      .def(py::init<const NamedScene&, const py::object&, const py::object&>(), py::arg("scene"),
           py::arg("mesh") = py::none(), py::arg("model") = py::none(),
           "mesh: a kilotouch.Mesh for the scene's own; model: a kilotouch.Model for it.")
      .def(
          "run", &PythonSession::run, py::arg("path") = py::none(), py::arg("pushed") = py::none(),
          "The whole run, as `kilotouch run`: a Trace. path: (n, 3) [m] of the first tool, in place of the scene's: "
          "its start, then where it is after each tick. pushed: a PushedDevice that another thread drives. Ctrl-C ends "
          "it.")
      .def("start", &PythonSession::start, py::arg("path") = py::none(), py::arg("pushed") = py::none(),
           "The same in a thread of its own; stop() gives its trace.")
      .def("stop", &PythonSession::stop, "Ends a run that was started: its Trace. Raises what ended it before.")
      .def_property_readonly("is_running", &PythonSession::is_running)
      .def_property_readonly("predictions", &PythonSession::predictions,
                             "What is known to go wrong in a run, found at set-up: a list of sentences.");
  py::module_::import("atexit").attr("register")(py::cpp_function(&PythonSession::end_all));
}

}  // namespace kt
