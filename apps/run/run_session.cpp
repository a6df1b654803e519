#include "apps/run/run_session.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <iterator>

#include "apps/console/allocation_counter.hpp"
#include "apps/console/commands.hpp"
#include "apps/console/report.hpp"
#include "apps/console/stop_signals.hpp"
#include "apps/console/words.hpp"
#include "apps/outputs/cures_in_force.hpp"
#include "apps/outputs/run_outputs.hpp"
#include "apps/outputs/run_summary.hpp"
#include "apps/run/network_run.hpp"
#include "apps/run/print_summary.hpp"
#include "apps/run/record_room.hpp"
#include "apps/run/run_folder.hpp"
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

/// A message begins with the file that the scene came from, where that is not the mesh itself.
static Session make_session(const Scene& scene, const std::string& file, SceneFiles files) {
  try {
    return Session(scene, std::move(files));
  } catch (const InputError& e) {
    if (file.empty() || file == scene.object.mesh) throw;
    throw InputError(file + ": " + e.what());
  }
}

int run_exit_code(const RunOutcome& outcome) { return outcome.summary.at("trust").at("failed").get<bool>() ? 1 : 0; }

/// What is known to fail before the run.
static std::vector<Finding> known_findings(const Session& session) {
  std::vector<Finding> out;
  std::ranges::transform(session.predictions(), std::back_inserter(out), &Prediction::finding);
  return out;
}

static void save(const RunSettings& settings, const Session& session, const RunOutcome& run, const BodyFilm& film) {
  const SavingResults saving;
  write_run(settings.out, session, run.result, run.summary, &film);
  // Of an earlier run in this folder. This one's pictures are drawn later, if at all.
  for (const char* name :
       {"reference.csv", "report.html", "force.png", "force.svg", "force.pdf", "mesh.png", "mesh.svg", "mesh.pdf"})
    std::filesystem::remove(settings.out + '/' + name);
  if (settings.comparison) settings.comparison->write(settings.out);
  if (settings.states) write_states(settings.out, session, run.result);
}

/// What a wrong word would spoil is told before anything is built.
static void check_settings(const Scene& scene, const RunSettings& settings) {
  if (!settings.out.empty()) require_writable_folder(settings.out, "--out " + settings.out);
  require_room(scene, needed_room(scene, !settings.out.empty()), free_room(settings.out));
}

static std::unique_ptr<OutputFolder> take_folder(const std::string& out) {
  return out.empty() ? nullptr : std::make_unique<OutputFolder>(out, "--out " + out, run_output_names());
}

RunOutcome run_scene(Scene scene, RunSettings settings) {
  if (settings.comparison) settings.comparison->prepare(scene);
  check_settings(scene, settings);
  const std::string title = scene.title.empty() ? "running" : scene.title;
  // A folder that is there is taken now; a new one is made when there is a body, so that wrong scenes leave none.
  std::unique_ptr<OutputFolder> folder;
  if (std::filesystem::exists(settings.out)) folder = take_folder(settings.out);
  const FolderHolds before =
      settings.out.empty() ? FolderHolds::nothing : look_at_folder(settings.out, scene, settings.force);
  Session session = make_session(scene, settings.input, std::move(settings.files));
  if (stop_requested()) throw RunError("stopped before the run began; nothing is written");
  const bool is_replay = !settings.session.replay.refreshes.empty();
  if (!settings.session.link && !is_replay) put_body_beside(scene, settings);
  if (!folder) folder = take_folder(settings.out);
  if (settings.comparison) settings.comparison->check(session);
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
  if (settings.comparison) settings.comparison->complete(session, out);
  if (!settings.out.empty()) save(settings, session, out, film);
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
