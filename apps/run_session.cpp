#include "apps/run_session.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <iterator>

#include "apps/allocation_counter.hpp"
#include "apps/commands.hpp"
#include "apps/network_run.hpp"
#include "apps/outputs/cures_in_force.hpp"
#include "apps/outputs/run_outputs.hpp"
#include "apps/outputs/run_summary.hpp"
#include "apps/print_summary.hpp"
#include "apps/record_room.hpp"
#include "apps/report.hpp"
#include "apps/run_folder.hpp"
#include "apps/stop_signals.hpp"
#include "apps/words.hpp"
#include "haptics/device/haptic_device.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/output_folder.hpp"

namespace kt {

namespace {

using Clock = std::chrono::steady_clock;

/// Lines that a log or another program can read; none of what takes a few seconds.
std::function<void(double)> progress_lines(const std::string& title) {
  return [title, start = Clock::now(), next = 5.0](double share) mutable {
    const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
    if (elapsed < next || share >= 1) return;
    next = elapsed + 10;
    std::fprintf(stderr, "%s: %.0f %%, %.0f s so far\n", title.c_str(), 100 * share, elapsed);
  };
}

}  // namespace

std::function<void(double)> progress_bar(const std::string& title, Piped piped) {
  if (is_quiet()) return {};
  if (!isatty(STDERR_FILENO)) return piped == Piped::lines ? progress_lines(title) : nullptr;
  return [title, start = Clock::now(), last = Clock::now()](double share) mutable {
    const auto now = Clock::now();
    const double elapsed = std::chrono::duration<double>(now - start).count();
    const bool finished = share >= 1;
    // Runs of under a second need no bar; more than ten updates a second only flicker.
    if (elapsed < 1 || (!finished && now - last < std::chrono::milliseconds(100))) return;
    last = now;
    const int width = 30, done = static_cast<int>(width * share);
    const std::string bar =
        std::string(static_cast<std::size_t>(done), '#') + std::string(static_cast<std::size_t>(width - done), '.');
    std::fprintf(stderr, "\r%s [%s] %3.0f %%  %.0f s left ", title.c_str(), bar.c_str(), 100 * share,
                 share > 0 ? elapsed * (1 - share) / share : 0.0);
    if (finished) std::fprintf(stderr, "\r\033[K");
  };
}

/// The start and the place at each tick of a tool that no force moves; none for a hand, which answers.
static std::optional<PosePath> planned_path(const Session& session) {
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
static std::optional<Reference> read_reference_before(const Session& session, const std::string& file) {
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

/// The reference of the run along the path it took; none when the run or the reference was stopped.
static std::optional<Reference> find_reference(const Session& session, const SessionResult& result,
                                               const ReferenceSettings& settings, const std::string& title) {
  if (result.stopped) return {};
  const std::vector<PosePath> paths = tool_paths(result);
  if (!settings.file.empty()) return read_reference(settings.file, reference_key(session, paths));
  if (!settings.compute) return {};
  ReferenceOptions options;
  options.rate_hz = settings.rate_hz;
  options.progress = progress_bar(title + ", reference");
  options.stop = &stop_requested();
  Reference out = run_reference(session, paths, options);
  if (out.force.size() < result.tools[0].frames.size()) return {};
  return out;
}

static std::optional<Reference> read_truth(const std::string& file, const Scene& scene) {
  if (file.empty()) return {};
  Reference out = read_forces(file);
  const auto ticks = static_cast<std::size_t>(std::llround(scene.duration * scene.local.rate_hz));
  constexpr double kRoundoff = 1e-9;
  if (std::abs(out.h * scene.local.rate_hz - 1) > kRoundoff || out.force.size() < ticks)
    throw InputError(text("--truth: ", file, " has ", out.force.size(), " forces, one every ", out.h, " s; needed are ",
                          ticks, ", one every ", 1 / scene.local.rate_hz, " s"));
  return out;
}

/// A message that starts with a key of the scene starts with the file, too.
static std::string with_file(const std::string& file, const std::string& message) {
  const std::string first = message.substr(0, message.find_first_of(".: "));
  const std::vector<std::string> keys = known_scene_keys();
  const bool starts_with_key =
      std::ranges::any_of(keys, [&](const std::string& key) { return key == first || key.starts_with(first + '.'); });
  return file.empty() || !starts_with_key ? message : file + ": " + message;
}

static Session make_session(const Scene& scene, const std::string& file, SceneFiles files) {
  try {
    return Session(scene, std::move(files));
  } catch (const InputError& e) {
    throw InputError(with_file(file, e.what()));
  }
}

int run_exit_code(const RunOutcome& outcome) { return outcome.summary.at("trust").at("failed").get<bool>() ? 1 : 0; }

/// What is known to fail before the run.
static std::vector<Finding> known_findings(const Session& session) {
  std::vector<Finding> out;
  std::ranges::transform(session.predictions(), std::back_inserter(out), &Prediction::finding);
  return out;
}

static void save(const RunSettings& settings, const Session& session, const RunOutcome& run,
                 const std::optional<Reference>& reference, const BodyFilm& film) {
  const SavingResults saving;
  write_run(settings.out, session, run.result, run.summary, &film);
  const std::string reference_file = settings.out + "/reference.csv";
  if (reference)
    write_reference(reference_file, *reference);
  else
    std::filesystem::remove(reference_file);  // an earlier run's
  if (settings.states) write_states(settings.out, session, run.result);
}

/// What a wrong word would spoil is told before anything is built.
static void check_settings(const Scene& scene, const RunSettings& settings) {
  if (const double rate = settings.reference.rate_hz;
      settings.reference.compute && !(rate >= scene.local.rate_hz && rate <= kMostReferenceRate))
    throw InputError(text("--reference-rate: ", rate, " Hz, must be at least local.rate_hz, ", scene.local.rate_hz,
                          ", at most ", kMostReferenceRate));
  if (scene.global.self_contact && (settings.reference.compute || !settings.reference.file.empty()))
    throw InputError("--reference: the full model in fine steps passes through itself; not with global.self_contact");
  if (!settings.reference.file.empty() && !std::filesystem::exists(settings.reference.file))
    throw InputError(text("--reference-file: ", settings.reference.file, " does not exist"));
  if (!settings.out.empty()) require_writable_folder(settings.out, "--out " + settings.out);
  require_room(scene, needed_room(scene, !settings.out.empty()), free_room(settings.out));
  if (scene.is_endless && settings.reference.compute)
    throw InputError("--reference: is computed for a duration; this run has none (duration null)");
  if (scene.is_endless && (!settings.reference.file.empty() || !settings.reference.truth.empty()))
    throw InputError("duration: is null, until it is stopped; a reference has an end");
}

static std::unique_ptr<OutputFolder> take_folder(const std::string& out) {
  return out.empty() ? nullptr : std::make_unique<OutputFolder>(out, "--out " + out, run_output_names());
}

RunOutcome run_scene(const Scene& scene, RunSettings settings) {
  check_settings(scene, settings);
  const std::string title = scene.title.empty() ? "running" : scene.title;
  // A folder that is there is taken now; a new one is made when there is a body, so that wrong scenes leave none.
  std::unique_ptr<OutputFolder> folder;
  if (std::filesystem::exists(settings.out)) folder = take_folder(settings.out);
  const FolderHolds before =
      settings.out.empty() ? FolderHolds::nothing : look_at_folder(settings.out, scene, settings.force);
  const std::optional<Reference> truth = read_truth(settings.reference.truth, scene);
  Session session = make_session(scene, settings.input, std::move(settings.files));
  if (stop_requested()) throw RunError("stopped before the run began; nothing is written");
  const bool is_replay = !settings.session.replay.refreshes.empty();
  if (!settings.session.link && !is_replay) put_body_beside(scene, settings);
  if (!folder) folder = take_folder(settings.out);
  read_reference_before(session, settings.reference.file);
  for (const Finding& f : with_true_cures(scene, known_findings(session)))
    std::cerr << "kilotouch: warning: " << f.line() << '\n';
  SessionOptions& options = settings.session;
  options.count_allocations = thread_allocations() >= 0 ? std::function<long long()>(thread_allocations) : nullptr;
  std::optional<SavingResults> saving;  // from the first tick on there is something to lose
  options.progress = [&saving, bar = scene.is_endless ? nullptr : progress_bar(title, settings.piped)](double share) {
    if (!saving) saving.emplace();
    if (bar) bar(share);
  };
  options.stop = &stop_requested();
  const double pressed = scene.tool.path.press_drag ? scene.tool.path.press_drag->press_time : 0.2 * scene.duration;
  if (options.snapshot_times.empty())
    for (int k = 0; k < 4; ++k) options.snapshot_times.push_back(pressed + k / 3.0 * (scene.duration - pressed));

  BodyFilm film(session.model().mesh());
  if (!settings.out.empty()) options.film = &film;
  RunOutcome out;
  out.result = session.run(options);
  if (!out.result.stopped && !stop_requested()) saving.reset();  // what comes now may be stopped, and its ticks stay
  if (settings.found) std::ranges::move(settings.found(), std::back_inserter(out.result.findings));
  out.summary = make_summary(session, out.result);
  out.summary["command"] = settings.reproduce;
  if (settings.complete) settings.complete(out.summary);
  const auto reference = find_reference(session, out.result, settings.reference, title);
  if (reference) add_reference(out.summary, out.result, *reference);
  if (truth && !out.result.stopped) add_truth(out.summary, out.result, *truth);
  if (!settings.out.empty()) save(settings, session, out, reference, film);
  write_json(settings.json_file, json_text(out.summary, 2) + "\n");
  if (!settings.quiet) print_summary(out.summary);
  if (!settings.quiet && settings.details) print_details(out.summary);
  if (settings.out.empty()) return out;
  // What a stop leaves is on the disk; pictures would make it wait.
  const bool draws = settings.report && !stop_requested();
  if (draws) write_report(settings.out, {.title = scene.title, .figures = settings.figures});
  if (settings.quiet) return out;
  std::cout << "  results       " << settings.out << (draws ? "/report.html" : "/summary.json")
            << (before == FolderHolds::other_settings ? " (in place of a run with other settings)" : "")
            << (settings.details ? "\n" : "; every figure: --details\n");
  return out;
}

}  // namespace kt
