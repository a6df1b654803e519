// What a run is compared with: the full model in fine steps, one computed before, or a better run.
#include <cmath>
#include <filesystem>

#include "apps/console/commands.hpp"
#include "apps/run/run_session.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/session/metrics.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

/// The start and the place at each tick of a tool that no force moves; none for a hand, which answers.
std::optional<PosePath> planned_path(const Session& session) {
  const Scene& scene = session.scene();
  if (scene.tool.path.hand || scene.tool.path.device) return {};
  const double h = 1 / scene.local.rate_hz;
  const auto device = scene_device(scene, scene.tool, session.paths()[0]);
  const auto ticks = static_cast<int>(std::llround(scene.duration * scene.local.rate_hz));
  PosePath out{device->pose(0)};
  for (int tick = 0; tick < ticks; ++tick) out.push_back(device->pose((tick + 1) * h));
  return out;
}

/// A wrong file is found before the run: what it says of itself, and its key as far as the path is known by then.
std::optional<Reference> read_reference_before(const Session& session, const std::string& file) {
  if (file.empty()) return {};
  const Scene& scene = session.scene();
  const auto path = scene.second_tool ? std::nullopt : planned_path(session);
  Reference out =
      path ? read_reference(file, reference_key(session, {&*path, 1})) : read_reference(file, key_in_reference(file));
  const auto ticks = static_cast<std::size_t>(std::llround(scene.duration * scene.local.rate_hz));
  const bool has_second = !out.second_force.empty();
  if (out.force.size() < ticks)
    throw InputError(text("--reference-file: ", file, " has ", out.force.size(), " forces; this run has ", ticks,
                          " ticks; run with --reference to compute its own"));
  if (scene.second_tool && !has_second)
    throw InputError(text("--reference-file: ", file, " has no force of a second tool, which this scene has"));
  return out;
}

std::optional<Reference> read_truth(const std::string& file, const Scene& scene) {
  if (file.empty()) return {};
  Reference out = read_forces(file);
  const auto ticks = static_cast<std::size_t>(std::llround(scene.duration * scene.local.rate_hz));
  constexpr double kRounding = 1e-9;
  if (std::abs(out.h * scene.local.rate_hz - 1) > kRounding || out.force.size() < ticks)
    throw InputError(text("--truth: ", file, " has ", out.force.size(), " forces, one every ", out.h, " s; needed are ",
                          ticks, ", one every ", 1 / scene.local.rate_hz, " s"));
  return out;
}

/// The summary's `reference`: how far the run's forces are from it, and its warnings.
void add_reference(Json& summary, const SessionResult& result, const Reference& reference) {
  const ForceError error = compare_forces(result.tools[0].model_force, reference);  // it knows no device
  summary["reference"] = {{"force_error", error.force_error},
                          {"jnd_fraction", error.jnd_fraction},
                          {"floor_n", error.floor},
                          {"rate_hz", reference.rate_hz},
                          {"seconds", reference.seconds}};
  if (result.tools.size() > 1) {
    const ForceError second = compare_forces(result.tools[1].model_force, second_tool_of(reference));
    summary["reference"]["second_tool"] = {
        {"force_error", second.force_error}, {"jnd_fraction", second.jnd_fraction}, {"floor_n", second.floor}};
  }
  for (const std::string& warning : reference.warnings) summary["warnings"].push_back(warning);
}

/// The summary's `truth`: the same against forces of another body, law or mesh along the same tool path, and how far
/// the tool's work is off.
void add_truth(Json& summary, const SessionResult& result, const Reference& truth) {
  const std::span<const Vec3> forces = result.tools[0].model_force;
  const PosePath path = tool_paths(result)[0];
  const ForceError error = compare_forces(forces, truth);
  const double work = tool_work(forces, path), true_work = tool_work(truth.force, path);
  summary["truth"] = {{"force_error", error.force_error},
                      {"jnd_fraction", error.jnd_fraction},
                      {"work_j", work},
                      {"true_work_j", true_work},
                      {"work_error", true_work != 0 ? Json(std::abs(work / true_work - 1)) : Json(nullptr)}};
}

class ReferenceComparison final : public RunComparison {
 public:
  bool compute = false;
  double rate_hz = 10000;
  std::string file, truth_file;

  bool is_asked() const override { return compute || !file.empty() || !truth_file.empty(); }

  void prepare(Scene& scene) override {
    if (compute && !(rate_hz >= scene.local.rate_hz && rate_hz <= kMostReferenceRate))
      throw InputError(text("--reference-rate: ", rate_hz, " Hz, must be at least local.rate_hz, ", scene.local.rate_hz,
                            ", at most ", kMostReferenceRate));
    if (scene.global.self_contact && (compute || !file.empty()))
      throw InputError("--reference: the full model in fine steps passes through itself; not with global.self_contact");
    if (!file.empty() && !std::filesystem::exists(file))
      throw InputError(text("--reference-file: ", file, " does not exist"));
    if (scene.is_endless && compute)
      throw InputError("--reference: is computed for a duration; this run has none (duration null)");
    if (scene.is_endless && is_asked())
      throw InputError("duration: is null, until it is stopped; a reference has an end");
    if (compute || !file.empty()) scene = with_own_cells(scene);
    truth_ = read_truth(truth_file, scene);
  }

  void check(const Session& session) override { read_reference_before(session, file); }

  void complete(const Session& session, RunOutcome& run) override {
    if (run.result.stopped) return;
    find_reference(session, run.result);
    if (reference_) add_reference(run.summary, run.result, *reference_);
    if (truth_) add_truth(run.summary, run.result, *truth_);
  }

  void write(const std::string& folder) override {
    if (reference_) write_reference(folder + "/reference.csv", *reference_);
  }

 private:
  /// Along the path that the run took; none when it was stopped.
  void find_reference(const Session& session, const SessionResult& result) {
    const std::vector<PosePath> paths = tool_paths(result);
    if (!file.empty()) reference_ = read_reference(file, reference_key(session, paths));
    if (!compute) return;
    const std::string& title = session.scene().title;
    ReferenceOptions options;
    options.rate_hz = rate_hz;
    options.progress = progress_bar((title.empty() ? "running" : title) + ", reference");
    options.stop = &stop_requested();
    Reference out = run_reference(session, paths, options);
    if (out.force.size() >= result.tools[0].frames.size()) reference_ = std::move(out);
  }

  std::optional<Reference> reference_, truth_;
};

}  // namespace

std::shared_ptr<RunComparison> add_reference_options(CLI::App& command) {
  auto out = std::make_shared<ReferenceComparison>();
  auto* compute = command.add_flag("--reference", out->compute,
                                   "also run the full model in fine steps along the same path, and compare");
  command.add_option("--reference-rate", out->rate_hz, "steps of the full model [Hz]")
      ->capture_default_str()
      ->needs(compute);
  command
      .add_option("--reference-file", out->file,
                  "compare with the reference.csv of an earlier run on the same body and path")
      ->excludes(compute);
  command.add_option(
      "--truth", out->truth_file,
      "also compare with reference.csv or trace.csv of a better run along the same tool path, as on a finer mesh");
  return out;
}

}  // namespace kt
