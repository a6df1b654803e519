#include "haptics/advise.hpp"

#include <algorithm>
#include <cmath>

#include "collision/closest_point.hpp"
#include "haptics/advise_parts.hpp"
#include "io/mesh_io.hpp"

namespace kt {
namespace {

constexpr double kBodiesShare = 0.45;  // of the budget at which the bodies end
constexpr double kDrag = 0.1;          // [s] of the path after the press

void require(const Scene& scene) {
  if (scene.contact.law == "penalty" || scene.local.method != "multirate")
    throw InputError(
        text("advise chooses among the engine's own local models: it needs local.method \"multirate\" and a ",
             "contact.law other than \"penalty\", not ", scene.local.method, " with ", scene.contact.law));
}

/// The tick that presses hardest, of the scene as it is.
SessionResult run_as_is(const Scene& scene, const Mesh& mesh, const AdviceClock& clock) {
  Scene plain = scene;
  plain.link.type = "lockstep";
  SessionOptions options;
  options.check_contacts = false;
  options.stop = clock.stop();
  options.progress = [&](double) { clock.show(); };
  return Session(plain, mesh).run(options);
}

double distance_to(const Mesh& mesh, const Vec3& p) {
  double out_sq = std::numeric_limits<double>::infinity();
  for (const Triangle& t : mesh.triangles)
    out_sq = std::min(
        out_sq, closest_point_on_triangle(p, node(mesh.x, t[0]), node(mesh.x, t[1]), node(mesh.x, t[2])).distance_sq);
  return std::sqrt(out_sq);
}

/// Back along the contact's normal until the tool is clear of the undeformed surface.
PressSite site_of(const LocalFrame& frame, const Mesh& mesh, double radius) {
  PressSite out{frame.tool, frame.tool, 0};
  const double step = 0.05 * radius;
  for (int i = 0; i < 200 && (i == 0 || distance_to(mesh, out.from) < radius); ++i) out.from += step * frame.normal;
  out.depth = (out.from - out.to).norm();
  return out;
}

std::vector<Waypoint> waypoints_until(const std::vector<Waypoint>& path, double end) {
  std::vector<Waypoint> out;
  for (const Waypoint& w : path) {
    out.push_back(w);
    if (w.t >= end) break;
  }
  return out;
}

/// Writes the tool's path out and shortens it.
void fix_path(AdviceScene& out, const AdviceClock& clock, std::vector<std::string>& notes) {
  Scene& scene = out.scene;
  const Session session(scene, out.mesh);
  std::vector<Waypoint> path;
  for (const TimedPoint& p : session.path()) path.push_back({p.t, p.x});
  double end = 0;
  if (const auto& press = scene.tool.path.press_drag) {
    out.site = {path.at(0).position, path.at(1).position, press->depth};
    // The way down through the air costs the reference as much as contact does, and says nothing.
    const Vec3 way = out.site.to - out.site.from;
    const double air = std::max(0.0, 1 - 1.05 * press->depth / way.norm());
    path[0].position += air * way;
    for (std::size_t i = 1; i < path.size(); ++i) path[i].t -= air * press->press_time;
    end = path[1].t + kDrag;
  } else {
    const SessionResult result = run_as_is(scene, out.mesh, clock);
    const auto hardest = std::ranges::max_element(result.frames, {}, &LocalFrame::f_n);
    const auto first = std::ranges::find_if(result.frames, [](const LocalFrame& f) { return f.f_n > 0; });
    if (first == result.frames.end()) return;
    out.site =
        site_of(*hardest, out.mesh, std::max(session.tool().radius, 1e-3));  // a point is not pressed, see prepare()
    end = first->t + 2 * kDrag;
    if (!scene.tool.path.waypoints) {
      path = {{0, result.start}};
      for (const LocalFrame& f : result.frames) path.push_back({f.t, f.tool});
      if (scene.tool.path.hand)
        notes.push_back("the hand's path is the one it took with the scene's own settings, for all rows");
    }
  }
  if (end < scene.duration) {
    notes.push_back(
        text("the rates are judged on ", end, " s of the path, from the first touch to ", kDrag, " s after the press"));
    scene.duration = end;
  }
  scene.tool.path = ScenePath{};
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = waypoints_until(path, end);
}

AdviceScene prepare(const Scene& scene, const AdviceClock& clock, std::vector<std::string>& notes) {
  AdviceScene out{.scene = scene};
  std::vector<std::string> mesh_notes;
  out.mesh = load_scene_mesh(scene, mesh_notes);
  const SceneModel& model = scene.object.model;
  out.has_ladder = !scene.object.fixed.nodes && load_mesh(scene.object.mesh).tetrahedra.empty();
  if (scene.tool.shape == "point")
    out.only_own = "the force on a point tool depends on the mesh and has no limit; its own mesh and model are kept";
  else if (scene.object.layers)
    out.only_own = "the body has layers of masses instead of tetrahedra";
  else if (model.type == "msd" && !model.calibrate)
    out.only_own = "springs with a given stiffness have no continuum that they approximate";
  else if (!out.has_ladder)
    notes.push_back(scene.object.fixed.nodes ? "object.fixed.nodes are nodes of the scene's own mesh: no other is tried"
                                             : "the scene brings its own tetrahedra: no other mesh is tried");
  fix_path(out, clock, notes);
  if (!(out.site.depth > 0) && !clock.stopped())
    throw InputError("advise: the tool does not press into the body along its path, so there is no force to judge");
  return out;
}

std::string percent(double value) {
  char out[32];
  std::snprintf(out, sizeof out, "%.1f %%", 100 * value);
  return out;
}

std::string milliseconds(double value) {
  char out[32];
  std::snprintf(out, sizeof out, "%.3g ms", value);
  return out;
}

std::string body_words(const AdviceBody& b) {
  return text(b.model, " with ", b.nodes, " nodes", b.max_volume ? "" : " (the scene's own mesh)");
}

std::string miss_words(const Choice& choice, const Candidate& c, double tolerance) {
  if (choice.missed == Limit::slow_load)
    return text("its slow side takes ", percent(c.slow_load), " of its interval on one core");
  if (choice.missed == Limit::tick_load)
    return text("its haptic tick takes ", percent(c.tick_load), " of its period (p99)");
  return text("its force is off by ", percent(c.error), ", ", percent(tolerance), " is allowed");
}

std::string body_reason(const Advice& a) {
  if (a.body.index < 0) return "no model could be measured";
  const AdviceBody& b = a.bodies[a.body.index];
  if (!a.body.found())
    return text("no model and mesh is within the limits; nearest is ", body_words(b), ": ",
                miss_words(a.body, candidate_of(b), a.tolerance),
                b.error > a.tolerance && a.truth.edge > 0
                    ? "; if finer insides do not help, the surface's triangles under the tool are too large"
                    : "");
  if (std::isnan(b.error)) return text(body_words(b), " was kept unjudged");
  return text(body_words(b), " is the cheapest body within the tolerance (", percent(b.error), ", ",
              milliseconds(b.global_ms), " a step)");
}

std::string row_reason(const Advice& a, double local_rate_hz) {
  if (a.row.index < 0) return "no rate and reducer could be measured on it";
  const AdviceRow& r = a.rows[a.row.index];
  const std::string words = text(r.reducer, " at ", r.rate_hz, " Hz");
  if (!a.row.found())
    return text("no rate and reducer is within the limits; nearest is ", words, ": ",
                miss_words(a.row, candidate_of(r, local_rate_hz), a.tolerance));
  return text(words, " is the cheapest on it (", percent(r.error), ", ", percent(r.core_share), " of a core)");
}

/// With no body within the limits, the nearest is the one that rates are measured on.
std::vector<std::string> settings_of(const Advice& a) {
  std::vector<std::string> out;
  if (a.body.index < 0) return out;
  const AdviceBody& b = a.bodies[a.body.index];
  out.push_back(text("object.model.type=", b.model == "msd" ? "msd" : "fem"));
  if (b.model != "msd") out.push_back("object.model.element=" + b.model);
  if (b.max_volume) out.push_back(text("object.tetrahedralize.max_volume=", *b.max_volume));
  if (a.row.index < 0) return out;
  const AdviceRow& r = a.rows[a.row.index];
  out.push_back(text("global.rate_hz=", r.rate_hz));
  out.push_back("local.reducer=" + r.reducer);
  if (r.reducer == "wall") out.push_back("local.rings=1");
  return out;
}

template <class Rows, class ToCandidate>
Choice choose_of(const Rows& rows, double tolerance, const ToCandidate& to_candidate) {
  std::vector<Candidate> candidates;
  for (const auto& row : rows) candidates.push_back(to_candidate(row));
  return choose(candidates, tolerance);
}

}  // namespace

Scene with_model(Scene scene, const std::string& model) {
  SceneModel& m = scene.object.model;
  m.type = model == "msd" ? "msd" : "fem";
  if (model == "msd")
    m.calibrate = true;
  else
    m.element = model;
  return scene;
}

std::string model_name(const SceneModel& model) { return model.type == "fem" ? model.element : model.type; }

Advice advise(const Scene& scene, const AdviseOptions& options) {
  if (!(options.tolerance > 0)) throw InputError(text("tolerance: ", options.tolerance, ", must be above 0"));
  require(scene);
  const AdviceClock clock(options);
  Advice out;
  out.tolerance = options.tolerance;
  AdviceScene judged = prepare(scene, clock, out.notes);
  AdviceBodies bodies = measure_bodies(judged, clock, kBodiesShare, out.notes);
  out.truth = bodies.truth;
  out.bodies = bodies.bodies;
  out.body = choose_of(out.bodies, options.tolerance, [](const AdviceBody& b) { return candidate_of(b); });
  if (!bodies.unjudged.empty()) out.body = {0, Limit::none, 0};
  if (out.body.index >= 0) {
    if (bodies.unjudged.empty()) judged.scene = with_model(judged.scene, out.bodies[out.body.index].model);
    measure_rates(judged, bodies.meshes[out.body.index], clock, out);
  }
  const double local_rate = scene.local.rate_hz;
  out.row = choose_of(out.rows, options.tolerance, [&](const AdviceRow& r) { return candidate_of(r, local_rate); });
  out.settings = settings_of(out);
  out.reason = text(body_reason(out), "; ", row_reason(out, local_rate), ".");
  out.stopped = clock.stopped();
  out.seconds = clock.seconds();
  if (options.progress) options.progress(1);
  return out;
}

}  // namespace kt
