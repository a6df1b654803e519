#pragma once
// The reference of a session: the full nonlinear body, same contact law and geometry code, at a fine rate, along the
// tool path that the session took. What methods are off from it is their error; docs/method.md#8-what-is-measured.
#include <span>

#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "lab/study/full_simulation.hpp"

namespace kt {

/// The start of a tool, then its pose at the end of each tick.
using PosePath = std::vector<Pose>;

/// The scene whose runs a reference tells the error of: local.refine auto leaves the mesh's own cells, which the
/// reference has, too.
Scene with_own_cells(Scene scene);

constexpr double kMostReferenceRate = 1e7;  ///< [Hz] of its steps

struct ReferenceOptions {
  double rate_hz = 10000;                     ///< at least; rounded up to a whole number of steps a tick
  double matrix_time = 0.02;                  ///< [s], see FullOptions
  TangentKind tangent = TangentKind::exact;   ///< see FullOptions
  bool exact_force = true;                    ///< see FullOptions
  std::function<void(double)> progress = {};  ///< share done, 0..1
  const std::atomic<bool>* stop = nullptr;    ///< end after this tick and keep what is there
};

struct Reference {
  std::uint64_t key = 0;  ///< of the body, the contact law and the tool path: reference_key()
  double rate_hz = 0;     ///< of its steps
  double h = 0;           ///< of a tick [s]: force[i] belongs to t = (i + 1) h
  double seconds = 0;     ///< CPU time that it took
  /// On the tool [N], the mean over one tick's length around the end of each tick: fine steps see vibrations that no
  /// haptic tick can show, and an average to one side would be late.
  std::vector<Vec3> force;
  std::vector<Vec3> second_force;  ///< the same on a second tool; empty: there is none
  std::vector<std::string> warnings;
};

/// @param paths  of each of the session's tools: in between it moves and turns evenly
/// Throws InputError for a rate below the session's, RunError when the body leaves the finite numbers.
Reference run_reference(const Session& session, std::span<const PosePath> paths, const ReferenceOptions& options = {});

/// Of each tool: what run_reference takes.
std::vector<PosePath> tool_paths(const SessionResult& result);

/// Equal for sessions whose references are the same: hash of body, contact law, tool and its path, not of the methods.
std::uint64_t reference_key(const Session& session, std::span<const PosePath> paths);

/// What the tool does on the body along `tool` (the start, then the place at each tick): - sum of F dx [J], F the
/// mean over each tick. Of as many ticks as both have.
double tool_work(std::span<const Vec3> forces, const PosePath& tool);

struct ForceError {
  double force_error = 0;   ///< || F - F_ref || / || F_ref || over all ticks
  double jnd_fraction = 0;  ///< share of the ticks with |F_ref| above the floor where |F - F_ref| > 10 % of |F_ref|
  double floor = 0;         ///< [N] kForceFloor of the root mean square of F_ref
};

/// Of as many ticks as both have. Like with like: the forces, those at the ends of ticks and linear in between, are
/// averaged as those of the reference's steps were; else a kink would be an error.
/// @param forces  one a tick [N]
ForceError compare_forces(std::span<const Vec3> forces, const Reference& reference);
/// Of forces as they stand.
ForceError compare_forces(std::span<const Vec3> forces, std::span<const Vec3> reference);
std::vector<Vec3> tick_forces(std::span<const LocalFrame> frames);

/// One force a tick from n a tick: means over a tick's length around the end of every tick (n even: half of the two
/// outermost); shorter at the end of the path.
std::vector<Vec3> resample_forces(std::span<const Vec3> steps, int n);

/// CSV: comment lines with key, rate and warnings, then t,force_x,force_y,force_z, with a second tool also its force.
void write_reference(const std::string& file, const Reference& reference);

/// Throws InputError when the file cannot be read or belongs to another body, law or path than `key`.
Reference read_reference(const std::string& file, std::uint64_t key);

/// The key that a file of write_reference has. @throws InputError when it is none
std::uint64_t key_in_reference(const std::string& file);

/// Steps of the reference in a tick, over which its forces are means; 1: they are those at the ends of ticks.
int steps_per_tick(const Reference& reference);
/// The reference of the second tool, alone.
Reference second_tool_of(const Reference& reference);

/// The columns t, force_x, force_y and force_z of any run's reference.csv or trace.csv: only `h` and `force` are set,
/// and of a reference.csv its rate.
/// Throws InputError when they are not there, or not one a tick.
Reference read_forces(const std::string& file);

}  // namespace kt
