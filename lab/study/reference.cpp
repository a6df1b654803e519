#include "lab/study/reference.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/cpu_time.hpp"
#include "core/body/state.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "haptics/refresh/refresher.hpp"

namespace kt {
namespace {

double cpu_seconds() { return 1e-3 * thread_time_ms(); }

int steps_per_tick(const Scene& scene, double rate_hz) {
  if (!(rate_hz >= scene.local.rate_hz && rate_hz <= kMostReferenceRate))
    throw InputError(text("reference rate: ", rate_hz, " Hz, must be at least local.rate_hz, ", scene.local.rate_hz,
                          ", at most ", kMostReferenceRate));
  return static_cast<int>(std::ceil(rate_hz / scene.local.rate_hz - 1e-9));
}

FullOptions full_options(const Session& session, std::span<const PosePath> paths, const ReferenceOptions& options,
                         int n) {
  const Scene& scene = session.scene();
  FullOptions out;
  out.h = 1 / (n * scene.local.rate_hz);
  out.matrix_time = options.matrix_time;
  out.tangent = options.tangent;
  out.exact_force = options.exact_force;
  for (const PosePath& path : paths)
    for (std::size_t i = 1; i < path.size(); ++i)
      out.max_speed = std::max(out.max_speed, (path[i].x - path[i - 1].x).norm() * scene.local.rate_hz);
  // The paper's laws are their metric; the others agree as the step shrinks, and the implicit one is the most accurate.
  if (is_geometric(scene.contact.law)) out.metric = contact_metric(scene.contact.metric);
  out.collision_backend = scene.collision.backend;
  TouchOptions own = session.options();
  own.local.refine = "off";
  out.smoothing = contact_smoothing(session.model(), session.surface(), own, false);
  return out;
}

}  // namespace

Scene with_own_cells(Scene scene) {
  if (scene.local.refine == "auto") scene.local.refine = "off";
  return scene;
}

Reference run_reference(const Session& session, std::span<const PosePath> paths, const ReferenceOptions& options) {
  const Scene& scene = session.scene();
  if (scene.global.self_contact)
    throw InputError("reference: the full model in fine steps passes through itself; not with global.self_contact");
  for (const PosePath& path : paths)
    if (paths.size() != session.tools().size() || path.size() != paths[0].size() || path.empty())
      throw InputError(text("reference: ", paths.size(), " paths of tools, the last one with ", path.size(),
                            " places, must be ", session.tools().size(), " with ", paths[0].size(), " each"));
  const int n = steps_per_tick(scene, options.rate_hz), ticks = static_cast<int>(paths[0].size()) - 1;
  const double started = cpu_seconds();
  FullSimulation full(
      session.model(), session.surface(), session.tools(),
      make_contact_solver(scene.contact.law, session.friction().everywhere, session.friction().of_triangle),
      full_options(session, paths, options, n), session.start());
  std::array<std::vector<Vec3>, kMaxTools> forces;
  std::array<ToolSweep, kMaxTools> sweeps;
  std::array<LocalFrame, kMaxTools> frames;
  constexpr double kSolved = 1e-3;  // of a contact's impulse
  int exhausted = 0, lost = 0, crowded = 0, unsolved = 0;
  for (int tick = 0; tick < ticks && !(options.stop && options.stop->load()); ++tick) {
    for (int k = 0; k < n; ++k) {
      for (std::size_t i = 0; i < paths.size(); ++i) {
        const Pose &from = paths[i][tick], &to = paths[i][tick + 1];
        const auto at = [&](int step) {
          const double share = step / double(n);
          return Pose{from.x + share * (to.x - from.x), from.r.slerp(share, to.r)};
        };
        sweeps[i] = {at(k), at(k + 1)};
      }
      full.step_tools(std::span(sweeps).first(paths.size()), std::span(frames).first(paths.size()));
      for (std::size_t i = 0; i < paths.size(); ++i) forces[i].push_back(frames[i].force);
      exhausted += (frames[0].flags & kEventsExhausted) != 0;
      lost += ((frames[0].flags | frames[1].flags) & kLostAnchor) != 0;
      crowded += ((frames[0].flags | frames[1].flags) & kContactsExhausted) != 0;
      unsolved += !(frames[0].residual <= kSolved);
    }
    if (options.progress) options.progress((tick + 1.0) / ticks);
  }
  Reference out;
  out.key = reference_key(session, paths);
  out.rate_hz = n * scene.local.rate_hz;
  out.h = 1 / scene.local.rate_hz;
  out.force = resample_forces(forces[0], n);
  out.second_force = resample_forces(forces[1], n);
  if (exhausted + lost > 0)
    out.warnings.push_back(text("reference: more impacts than are resolved in ", exhausted,
                                " steps, contact lost at a new matrix in ", lost, " of ", forces[0].size(), " steps"));
  if (crowded + unsolved > 0)
    out.warnings.push_back(text("reference: ", kMaxContacts, " places or more touch in ", crowded,
                                " steps, contact not solved to ", kSolved, " in ", unsolved, " of ", forces[0].size(),
                                " steps; its force is no truth there: take coarser cells or a smaller tool"));
  int inverted = 0;
  for (const Tetrahedron& t : session.model().mesh().tetrahedra) inverted += tetrahedron_volume(full.state().x, t) < 0;
  if (inverted > 0) out.warnings.push_back(text("reference: ", inverted, " tetrahedra are inside out at its end"));
  out.seconds = cpu_seconds() - started;
  return out;
}

std::vector<Vec3> resample_forces(std::span<const Vec3> steps, int n) {
  std::vector<Vec3> out;
  const int count = static_cast<int>(steps.size());
  for (int end = n; end <= count; end += n) {
    Vec3 sum = Vec3::Zero();
    double weights = 0;
    for (int k = -(n / 2); k <= n / 2; ++k) {
      const int step = end - 1 + k;
      if (step >= count) break;
      const double weight = n % 2 == 0 && std::abs(k) == n / 2 ? 0.5 : 1.0;
      sum += weight * steps[step];
      weights += weight;
    }
    out.push_back(sum / weights);
  }
  return out;
}

std::vector<PosePath> tool_paths(const SessionResult& result) {
  std::vector<PosePath> out;
  for (const ToolRun& tool : result.tools) {
    PosePath& path = out.emplace_back();
    path.push_back(tool.start);
    for (const LocalFrame& f : tool.frames) path.push_back(f.pose);
  }
  return out;
}

std::uint64_t reference_key(const Session& session, std::span<const PosePath> paths) {
  const DeformableModel& model = session.model();
  const ContactSettings& contact = session.scene().contact;
  StateHash hash;
  const auto add_words = [&](const std::string& words) { hash.add(words.data(), words.size()); };
  for (int i : model.fixed_nodes()) hash.add(i);
  for (const Triangle& t : session.surface().triangles)
    for (int i : t) hash.add(i);
  hash.add(model.mesh().x);
  hash.add(session.start().x);
  // The parameters by what they do: the forces of a body that is stretched, sheared and moves.
  State state = rest_state(model);
  const Mat3 strain = (Mat3() << 1.01, 0.02, 0.003, 0.01, 0.98, 0.02, 0.005, 0.01, 1.02).finished();
  for (int i = 0; i < model.mesh().num_nodes(); ++i) {
    node(state.v, i) = strain.transpose() * node(state.x, i) + 0.1 * std::sin(i) * Vec3::Ones();
    node(state.x, i) = strain * node(state.x, i);
  }
  VectorX force;
  model.force(state, force);
  hash.add(force);
  hash.add(VectorX(model.mass() * state.v));
  add_words(contact.law);
  if (is_geometric(contact.law)) add_words(contact.metric);
  hash.add(contact.mu_static);
  hash.add(contact.mu_kinetic);
  if (contact.stribeck > 0) hash.add(contact.stribeck);
  if (contact.surface != "flat") {
    add_words(contact.surface);
    hash.add(contact.surface_levels);
    hash.add(contact.ridge_deg);
  }
  for (const Friction& f : session.friction().of_triangle) {
    hash.add(f.mu_static);
    hash.add(f.mu_kinetic);
  }
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const ToolShape& shape = session.tools()[k];
    add_words(k == 0 ? session.scene().tool.shape : session.scene().second_tool->shape);
    hash.add(shape.radius);
    for (const Vec3& corner : shape.corners) hash.add(corner);
    if (k == 0) hash.add(session.scene().local.rate_hz);
    for (const Pose& pose : paths[k]) hash.add(pose.x);
    const auto is_turned = [](const Pose& pose) { return pose.r.w() != 1; };
    if (std::ranges::none_of(paths[k], is_turned) || shape.corners.empty()) continue;
    for (const Pose& pose : paths[k]) {
      hash.add(pose.r.w());
      hash.add(Vec3(pose.r.vec()));
    }
  }
  return hash.value();
}

std::vector<Vec3> tick_forces(std::span<const LocalFrame> frames) {
  std::vector<Vec3> out;
  for (const LocalFrame& f : frames) out.push_back(f.force);
  return out;
}

double tool_work(std::span<const Vec3> forces, const PosePath& tool) {
  double out = 0;
  for (std::size_t i = 0; i < forces.size() && i + 1 < tool.size(); ++i) {
    const Vec3 before = i > 0 ? forces[i - 1] : Vec3(Vec3::Zero());
    out -= 0.5 * (before + forces[i]).dot(tool[i + 1].x - tool[i].x);
  }
  return out;
}

int steps_per_tick(const Reference& reference) {
  return std::max(1, static_cast<int>(std::lround(reference.rate_hz * reference.h)));
}

Reference second_tool_of(const Reference& reference) {
  Reference out = reference;
  out.force = reference.second_force;
  out.second_force.clear();
  return out;
}

namespace {

/// At the ends of n steps a tick, linear between the ends of ticks; before the first of them as after it.
std::vector<Vec3> drawn_out(std::span<const Vec3> forces, int n) {
  std::vector<Vec3> out;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Vec3 before = i > 0 ? forces[i - 1] : forces.size() > 1 ? Vec3(2 * forces[0] - forces[1]) : forces[0];
    for (int k = 1; k <= n; ++k) out.push_back(before + k / double(n) * (forces[i] - before));
  }
  return out;
}

}  // namespace

ForceError compare_forces(std::span<const Vec3> forces, const Reference& reference) {
  const int n = steps_per_tick(reference);
  if (n == 1) return compare_forces(forces, reference.force);
  return compare_forces(resample_forces(drawn_out(forces, n), n), reference.force);
}

ForceError compare_forces(std::span<const Vec3> forces, std::span<const Vec3> reference) {
  ForceError out;
  const std::size_t count = std::min(forces.size(), reference.size());
  double difference_sq = 0, reference_sq = 0;
  for (std::size_t i = 0; i < count; ++i) {
    difference_sq += (forces[i] - reference[i]).squaredNorm();
    reference_sq += reference[i].squaredNorm();
  }
  if (!(reference_sq > 0)) return out;
  out.force_error = std::sqrt(difference_sq / reference_sq);
  out.floor = kForceFloor * std::sqrt(reference_sq / static_cast<double>(count));
  int judged = 0, noticed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double size = reference[i].norm();
    if (size <= out.floor) continue;
    ++judged;
    noticed += (forces[i] - reference[i]).norm() > kNoticeableForce * size;
  }
  if (judged > 0) out.jnd_fraction = static_cast<double>(noticed) / judged;
  return out;
}

}  // namespace kt
