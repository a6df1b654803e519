#include "lab/advise/advise.hpp"
#include "lab/study/reference.hpp"

#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "io/mesh/mesh_io.hpp"
#include "lab/advise/advise_parts.hpp"

namespace kt {
namespace {

constexpr double kBodiesShare = 0.5;  // of the budget at which the bodies end
constexpr double kPath = 0.3;         // [s] of the path that is judged, from the first touch on
constexpr double kRun = 0.15;         // of the budget, for the scene as it is

void require(const Scene& scene) {
  if (scene.local.method != "multirate")
    throw InputError(
        text("advise chooses among the engine's own local models: it needs local.method \"multirate\", not \"",
             scene.local.method, "\""));
  if (scene.global.self_contact)
    throw InputError("advise compares with a body that passes through itself; not with global.self_contact");
  if (scene.second_tool) throw InputError("advise judges by the force on one tool; not with second_tool");
}

/// Along the normal of the undeformed surface, to where the tool is.
PressSite site_of(const Vec3& tool, const Mesh& mesh, double radius) {
  ClosestPoint nearest{.distance_sq = std::numeric_limits<double>::infinity()};
  Vec3 normal = Vec3::Zero();
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = node(mesh.x, t[0]), b = node(mesh.x, t[1]), c = node(mesh.x, t[2]);
    const ClosestPoint at = closest_point_on_triangle(tool, a, b, c);
    if (!(at.distance_sq < nearest.distance_sq)) continue;
    nearest = at;
    normal = (b - a).cross(c - a).normalized();
  }
  const double depth = radius - normal.dot(tool - nearest.point);
  return {tool + depth * normal, tool, radius};
}

/// Runs the scene as it is and takes the tool's path from the first touch on: the same for all methods, also of a hand
/// that answers to the force.
AdviceScene prepare(const Scene& given, const AdviceClock& clock) {
  const Scene scene = with_own_cells(given);  // against references
  if (scene.link.type == "network")
    throw InputError(
        "link.type network: advise runs the scene many times in this process; take lockstep, and set the link for the "
        "run "
        "itself");
  if (is_live(scene))
    throw InputError(
        "tool.path.device: advise runs the scene many times, and whoever holds the device goes another "
        "way each time; give it a recording of a session, tool.path.recording");
  AdviceScene out{.scene = scene};
  std::vector<std::string> notes;
  out.mesh = load_body_mesh(body_options(scene), notes);
  out.may_refine =
      given.local.refine != "off" && given.tool.shape != "point" && may_refine(given.contact, given.local).refines;
  out.from_surface = load_mesh(scene.object.mesh).tetrahedra.empty() && !scene.object.layers;
  Scene plain = scene;
  plain.link.type = "lockstep";
  if (!scene.tool.path.hand) {  // only the place counts: the cheapest way there
    plain.local.reducer = "wall";
    plain.global.rate_hz = 10;
    plain.global.early_refresh = false;
  }
  std::atomic<bool> over{false};
  SessionOptions options;
  options.check_contacts = false;
  options.stop = &over;
  options.progress = watch(clock, kRun, over);
  Session session(plain, out.mesh);
  const SessionResult run = session.run(options);
  const auto touches = [](const LocalFrame& f) { return f.f_n > 0; };
  const auto first = std::ranges::find_if(run.tools[0].frames, touches);
  if (first == run.tools[0].frames.end()) {
    if (run.stopped) throw RunError("the time ended before the tool touched the body; raise --budget-seconds");
    throw InputError("advise: the tool does not press into the body along its path, so there is no force to judge");
  }
  const auto ticks =
      std::min<std::ptrdiff_t>(run.tools[0].frames.end() - first, std::lround(kPath * scene.local.rate_hz));
  const std::span<const LocalFrame> judged(first, static_cast<std::size_t>(ticks));
  for (const LocalFrame& f : judged) {
    const PressSite site = site_of(f.pose.x, out.mesh, session.tool().radius);
    if (site.depth() > out.site.depth()) out.site = site;
  }
  out.tool = {first == run.tools[0].frames.begin() ? run.tools[0].start : std::prev(first)->pose};
  for (const LocalFrame& f : judged) out.tool.push_back(f.pose);

  ScenePath path;
  path.press_drag.reset();
  path.waypoints.emplace();
  for (std::size_t i = 0; i < out.tool.size(); ++i)
    path.waypoints->push_back({static_cast<double>(i) / scene.local.rate_hz, out.tool[i].x});
  out.scene.tool.path = path;
  out.scene.duration = static_cast<double>(ticks) / scene.local.rate_hz;
  return out;
}

template <class Rows, class ToCandidate>
Choice choose_of(const Rows& rows, double tolerance, const ToCandidate& to_candidate) {
  std::vector<Candidate> candidates;
  for (const auto& row : rows) candidates.push_back(to_candidate(row));
  return choose(candidates, tolerance);
}

/// Bodies within the limits, the cheapest first; without one the nearest to them; without a truth the scene's own.
std::vector<int> bodies_worth_trying(const Advice& a) {
  if (!a.truth.why_none.empty()) return {0};
  std::vector<Candidate> left;
  for (const AdviceBody& b : a.bodies) left.push_back(candidate_of(b));
  std::vector<int> out;
  for (;;) {
    const Choice next = choose(left, a.tolerance);
    if (next.index < 0 || (!next.found() && !out.empty())) return out;
    out.push_back(next.index);
    if (!next.found()) return out;
    left[next.index] = {};
  }
}

std::vector<std::string> settings_of(const Advice& a) {
  if (a.row.index < 0) return {};
  const AdviceRow& r = a.rows[a.row.index];
  const AdviceBody& b = a.bodies[r.body];
  std::vector<std::string> out{text("object.model.type=", b.model == "msd" ? "msd" : "fem")};
  if (b.model != "msd") out.push_back(text("object.model.element=", b.model == "tet10" ? "tet10" : "auto"));
  out.push_back(text("local.refine=", b.refined ? "follow" : "off"));
  if (b.mesh_name != "own" && b.filled.max_volume)
    out.push_back(text("object.tetrahedralize.max_volume=", *b.filled.max_volume));
  if (b.mesh_name != "own" && b.filled.max_edge)
    out.push_back(text("object.tetrahedralize.max_edge=", *b.filled.max_edge));
  out.push_back(text("global.rate_hz=", r.rate_hz));
  out.push_back("local.reducer=" + r.reducer);
  if (r.reducer == "wall") out.push_back("local.rings=1");
  return out;
}

}  // namespace

Advice advise(const Scene& scene, const AdviseOptions& options) {
  require(scene);
  const AdviceClock clock(options);
  Advice out;
  out.tolerance = options.tolerance;
  const AdviceScene judged = prepare(scene, clock);
  press_bodies(judged, clock, kBodiesShare, out);
  for (int body : bodies_worth_trying(out)) {
    if (!out.rows.empty() && clock.is_over()) break;
    measure_rates(judged, body, clock, out);
    out.row =
        choose_of(out.rows, out.tolerance, [&](const AdviceRow& r) { return candidate_of(r, scene.local.rate_hz); });
    if (out.row.found()) break;
  }
  out.settings = settings_of(out);
  out.stopped = clock.stopped();
  out.seconds = clock.seconds();
  if (options.progress) options.progress(1);
  return out;
}

}  // namespace kt
