// How far methods are from the reference (the full nonlinear body at 10 kHz), and what they cost: scenes x models x
// methods x global rates x latencies. A reference is computed once and kept in a folder.
//   build/release/bench/multirate_accuracy [SCENE.json...] [--methods wall1,krylov] [--models msd,fem]
//     [--rates 10,30,60] [--latencies 0,1] [--reference-rate 10000] [--cache DIR] [--json FILE] [--set KEY=VALUE]...
//     [--traces DIR] [--diagnose]      latencies in frames of the global rate; --set is for every run
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "haptics/session/metrics.hpp"
#include "io/files/output_file.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

struct Method {
  const char* name;
  std::vector<std::string> settings;
};

/// A new method is a line here.
const std::vector<Method> kMethods = {
    {"wall1", {"local.reducer=wall", "local.rings=1"}},
    {"wall3", {"local.reducer=wall", "local.rings=3"}},
    {"condensed", {"local.reducer=condensed"}},
    {"krylov", {"local.reducer=krylov"}},
    {"modal", {"local.reducer=modal"}},
    {"auto", {"local.reducer=auto"}},
    {"full", {"local.reducer=full"}},
    // What others do; docs/methods.md.
    {"hold", {"local.method=hold", "local.reducer=wall"}},
    {"legacy", {"local.method=legacy", "local.reducer=wall"}},
    {"frozen", {"local.method=frozen", "local.reducer=wall"}},
    {"penalty", {"local.method=penalty", "local.reducer=wall"}},
    // The same with a better local model below than their originals have.
    {"hold_condensed", {"local.method=hold", "local.reducer=condensed"}},
    {"frozen_condensed", {"local.method=frozen", "local.reducer=condensed"}},
    {"penalty_condensed", {"local.method=penalty", "local.reducer=condensed"}},
    // Parts of the way over to a new local model, and refreshes that come early where the body bends.
    {"krylov_bare", {"local.reducer=krylov", "local.catch_up=false", "local.blend_ms=0"}},
    {"krylov_catch_up", {"local.reducer=krylov", "local.catch_up=true", "local.blend_ms=0"}},
    {"krylov_blend", {"local.reducer=krylov", "local.catch_up=false", "local.blend_ms=12"}},
    {"krylov_no_look_ahead", {"local.reducer=krylov", "global.look_ahead=false"}},
    {"krylov_early", {"local.reducer=krylov", "global.early_refresh=true"}},
};

const std::vector<Method> kModels = {
    {"msd", {"object.model.type=msd"}},
    {"fem", {"object.model.type=fem", "object.model.material=neo_hookean"}},
    {"linear", {"object.model.type=fem", "object.model.material=linear"}},
};

/// Press for 0.2 s, then drag at 50 mm/s: comparable between scenes, and cheap.
const std::vector<std::string> kCommon = {"duration=0.6", "tool.path.press_drag.press_time=0.2",
                                          "tool.path.press_drag.speed=0.05", "link.type=lockstep", "link.latency_ms=0"};

struct Arguments {
  std::vector<std::string> scenes{KT_SOURCE_DIR "/scenes/slab_drag.json"},
      methods{"wall1", "condensed", "krylov", "full"}, models{"msd", "fem"}, set;
  std::vector<double> rates{10, 30, 60}, latencies{0, 1};
  double reference_rate = 10000;
  std::string cache = "reference_cache", json, traces;
  bool diagnose = false;
};

const Method& find(const std::vector<Method>& table, const std::string& what, const std::string& name) {
  std::vector<std::string> known;
  for (const Method& m : table) {
    if (name == m.name) return m;
    known.push_back(m.name);
  }
  throw_unknown(what, name, known);
}

class Table {
 public:
  explicit Table(const Arguments& arguments) : arguments_(arguments) {
    std::printf("%-6s %-14s %4s %3s | %7s %6s %7s %7s | %7s %8s %7s %4s %5s | %5s %7s %7s %8s\n", "model", "method",
                "Hz", "lat", "error", "jnd", "gain_n", "gain_t", "refresh", "crossing", "inside", "lost", "clamp",
                "dof", "us p50", "us p99", "refr ms");
  }

  void add(const std::string& scene, const std::string& model, const std::string& method, double rate, double latency,
           const Scene& settings, int nodes, const SessionResult& result, const Reference& reference) {
    const int n = static_cast<int>(std::lround(settings.local.rate_hz * reference.h));
    const std::vector<Vec3> forces = resample_forces(tick_forces(result.tools[0].frames), n);
    const ForceError error = compare_forces(forces, reference);
    const double from = settings.tool.path.press_drag ? settings.tool.path.press_drag->press_time + 0.1 : 0.3;
    const ForceMetrics m = measure_forces(result.tools[0].frames, from, 1 / settings.local.rate_hz);
    const double inside = result.tools[0].penetration.empty() ? 0
                                                              : *std::max_element(result.tools[0].penetration.begin(),
                                                                                  result.tools[0].penetration.end());
    const auto [normal, tangential] = gains(forces, reference, from);
    std::printf(
        "%-6s %-14s %4g %3g | %6.2f%% %5.1f%% %7.4f %7.4f | %6.2f%% %7.2f%% %5.1fum %4d %5d | %5d %7.1f %7.1f %8.1f\n",
        model.c_str(), method.c_str(), rate, latency, 100 * error.force_error, 100 * error.jnd_fraction, normal,
        tangential, 100 * m.refresh_jump, 100 * m.crossing_jump, 1e6 * inside, m.lost_contacts,
        result.refresh.definite_tangents, result.last_dof, percentile(result.step_us, 0.5),
        percentile(result.step_us, 0.99), percentile(result.refresh.refresh_ms, 0.5));
    std::fflush(stdout);
    keep(scene, model, method, rate, latency,
         text("\"force_error\": ", error.force_error, ", \"jnd_fraction\": ", error.jnd_fraction,
              ", \"gain_n\": ", normal, ", \"gain_t\": ", tangential, ", \"refresh_jump\": ", m.refresh_jump,
              ", \"crossing_jump\": ", m.crossing_jump, ", \"penetration_max_m\": ", inside,
              ", \"lost_contacts\": ", m.lost_contacts, ", \"definite_tangents\": ", result.refresh.definite_tangents,
              ", \"dof\": ", result.last_dof, ", \"step_us\": {\"p50\": ", percentile(result.step_us, 0.5),
              ", \"p99\": ", percentile(result.step_us, 0.99), ", \"p999\": ", percentile(result.step_us, 0.999),
              "}, \"refresh_ms\": ", percentile(result.refresh.refresh_ms, 0.5),
              ", \"global_ms\": ", percentile(result.refresh.global_ms, 0.5),
              ", \"refreshes_per_s\": ", static_cast<double>(result.refreshes.size()) / settings.duration,
              ", \"inside_out\": ", result.refresh.inverted.most, ", \"nodes\": ", nodes,
              ", \"mean_force\": ", mean_force(reference.force)));
    write_trace(text(model, "_", method, "_", rate, "_", latency), forces, reference.h, &result.refreshes);
  }

  /// A run that ended before its time.
  void add_failure(const std::string& scene, const std::string& model, const std::string& method, double rate,
                   double latency, const std::string& why) {
    std::printf("%-6s %-14s %4g %3g | failed: %s\n", model.c_str(), method.c_str(), rate, latency, why.c_str());
    std::fflush(stdout);
    keep(scene, model, method, rate, latency, "\"force_error\": null");
  }

  /// DIR/NAME.csv: the force on the tool at the end of each tick, and whether a new local model came in before it.
  void write_trace(const std::string& name, const std::vector<Vec3>& forces, double h,
                   const std::vector<RefreshEvent>* refreshes) const {
    if (arguments_.traces.empty()) return;
    std::vector<char> adopted(forces.size(), 0);
    if (refreshes)
      for (const RefreshEvent& event : *refreshes)
        if (event.adopted_tick >= 0 && event.adopted_tick < static_cast<int>(adopted.size()))
          adopted[static_cast<std::size_t>(event.adopted_tick)] = 1;
    std::string out = "t,force_x,force_y,force_z,refresh\n";
    for (std::size_t i = 0; i < forces.size(); ++i)
      out += text(static_cast<double>(i + 1) * h, ",", forces[i].x(), ",", forces[i].y(), ",", forces[i].z(), ",",
                  adopted[i] ? 1 : 0, "\n");
    make_folder(arguments_.traces);
    write_file_whole(arguments_.traces + "/" + name + ".csv", out);
  }

  static double mean_force(const std::vector<Vec3>& forces) {
    double sum = 0;
    for (const Vec3& f : forces) sum += f.norm();
    return sum / static_cast<double>(forces.size());
  }

  /// Force along the reference's over the reference's, upwards and sideways, in the drag: above 1 is too stiff.
  static std::pair<double, double> gains(const std::vector<Vec3>& forces, const Reference& reference, double from) {
    double n = 0, n_ref = 0, t = 0, t_ref = 0;
    for (std::size_t i = static_cast<std::size_t>(from / reference.h);
         i < std::min(forces.size(), reference.force.size()); ++i) {
      const Vec3 &f = forces[i], &r = reference.force[i];
      n += f.z() * r.z();
      n_ref += r.z() * r.z();
      t += f.head<2>().dot(r.head<2>());
      t_ref += r.head<2>().squaredNorm();
    }
    return {n_ref > 0 ? n / n_ref : 0, t_ref > 0 ? t / t_ref : 0};
  }

 private:
  void keep(const std::string& scene, const std::string& model, const std::string& method, double rate, double latency,
            const std::string& rest) {
    const std::string file = std::filesystem::path(scene).lexically_proximate(KT_SOURCE_DIR).string();
    rows_ += text(rows_.empty() ? "" : ",\n", "{\"scene\": \"", file, "\", \"model\": \"", model, "\", \"method\": \"",
                  method, "\", \"rate_hz\": ", rate, ", \"latency_frames\": ", latency, ", ", rest, "}");
    if (!arguments_.json.empty()) write_named_file(arguments_.json, "[" + rows_ + "]\n");
  }

  const Arguments& arguments_;
  std::string rows_;
};

std::vector<std::string> joined(std::initializer_list<std::vector<std::string>> lists) {
  std::vector<std::string> out;
  for (const auto& list : lists) out.insert(out.end(), list.begin(), list.end());
  return out;
}

Reference cached_reference(const Session& session, const std::vector<PosePath>& path, const Arguments& arguments,
                           const ReferenceOptions& options) {
  const std::uint64_t key = reference_key(session, path);
  char name[64];
  std::snprintf(name, sizeof name, "/%016llx_%g_%g_%d%s.csv", static_cast<unsigned long long>(key), options.rate_hz,
                options.matrix_time, options.exact_force, options.tangent == TangentKind::definite ? "_definite" : "");
  const std::string file = arguments.cache + name;
  if (std::filesystem::exists(file)) return read_reference(file, key);
  std::fprintf(stderr, "computing %s\n", file.c_str());
  const Reference out = run_reference(session, path, options);
  make_folder(arguments.cache);
  write_reference(file, out);
  return out;
}

/// The full model in steps as long as a tick, and linear between refreshes: the parts of the error that no reducer and
/// no global step has a share in.
void diagnose(const Session& session, const std::vector<PosePath>& path, const Arguments& arguments,
              const Reference& reference) {
  struct Part {
    std::string name;
    ReferenceOptions options;
  };
  const double tick_rate = session.scene().local.rate_hz;
  std::vector<Part> parts = {
      {"reference in twice as fine steps", {.rate_hz = 2 * arguments.reference_rate}},
      {"reference with a new matrix every ms", {.rate_hz = arguments.reference_rate, .matrix_time = 1e-3}},
      {"full, one step a tick, exact force", {.rate_hz = tick_rate}}};
  for (double rate : arguments.rates) {
    const std::string linear = text(" Hz, linear for 1/", rate, " s from its own state");
    for (double step_rate : {arguments.reference_rate, tick_rate})
      parts.push_back(
          {text("full at ", step_rate, linear), {.rate_hz = step_rate, .matrix_time = 1 / rate, .exact_force = false}});
    parts.push_back(
        {text("full at ", tick_rate, linear, ", definite"),
         {.rate_hz = tick_rate, .matrix_time = 1 / rate, .tangent = TangentKind::definite, .exact_force = false}});
  }
  for (const auto& [name, options] : parts) try {
      const Reference other = cached_reference(session, path, arguments, options);
      const auto [n, t] = Table::gains(other.force, reference, 0.3);
      std::printf("       %-66s %6.3f%%  gains %.4f %.4f\n", name.c_str(),
                  100 * compare_forces(other.force, reference.force).force_error, n, t);
    } catch (const RunError&) {  // an indefinite stiffness, held long enough
      std::printf("       %-66s diverges\n", name.c_str());
    }
  std::fflush(stdout);
}

void go(const Arguments& arguments) {
  for (const std::string& m : arguments.methods) find(kMethods, "method", m);
  for (const std::string& m : arguments.models) find(kModels, "model", m);
  Table table(arguments);
  for (const std::string& scene_file : arguments.scenes)
    for (const std::string& model : arguments.models) {
      const auto settings = [&](const std::vector<std::string>& more) {
        return load_scene(scene_file, joined({kCommon, find(kModels, "model", model).settings, arguments.set, more}));
      };
      Session session(settings({"local.reducer=wall"}));
      const std::vector<PosePath> path = tool_paths(session.run());
      const Reference reference = cached_reference(session, path, arguments, {.rate_hz = arguments.reference_rate});
      std::printf("%-6s %s: %d nodes, reference %g Hz, %.1f s CPU, mean force %.4g N\n", model.c_str(),
                  std::filesystem::path(scene_file).stem().c_str(), session.model().mesh().num_nodes(),
                  reference.rate_hz, reference.seconds, Table::mean_force(reference.force));
      for (const std::string& warning : reference.warnings) std::printf("       %s\n", warning.c_str());
      table.write_trace(model + "_reference", reference.force, reference.h, nullptr);
      if (arguments.diagnose) diagnose(session, path, arguments, reference);
      for (const std::string& method : arguments.methods)
        for (double rate : arguments.rates)
          for (double latency : arguments.latencies) {
            const Scene scene =
                settings(joined({find(kMethods, "method", method).settings,
                                 {text("global.rate_hz=", rate), text("link.latency_ms=", 1e3 * latency / rate)}}));
            try {
              table.add(scene_file, model, method, rate, latency, scene, session.model().mesh().num_nodes(),
                        Session(scene).run(), reference);
            } catch (const RunError& e) {  // the body left the finite numbers
              table.add_failure(scene_file, model, method, rate, latency, e.what());
            }
          }
    }
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Arguments arguments;
  CLI::App app;
  app.add_option("scenes", arguments.scenes);
  app.add_option("--methods", arguments.methods)->delimiter(',')->allow_extra_args(false);
  app.add_option("--models", arguments.models)->delimiter(',')->allow_extra_args(false);
  app.add_option("--rates", arguments.rates)->delimiter(',')->allow_extra_args(false);
  app.add_option("--latencies", arguments.latencies)->delimiter(',')->allow_extra_args(false);
  app.add_option("--reference-rate", arguments.reference_rate);
  app.add_option("--cache", arguments.cache);
  app.add_option("--json", arguments.json);
  app.add_option("--traces", arguments.traces);
  app.add_option("--set", arguments.set)->allow_extra_args(false);
  app.add_flag("--diagnose", arguments.diagnose);
  CLI11_PARSE(app, argc, argv);
  try {
    kt::go(arguments);
  } catch (const kt::InputError& e) {
    std::cerr << "multirate_accuracy: " << e.what() << '\n';
    return 2;
  } catch (const std::exception& e) {
    std::cerr << "multirate_accuracy: " << e.what() << '\n';
    return 1;
  }
}
