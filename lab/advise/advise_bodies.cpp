// First part of an advice: models and meshes, pressed at rest.
#include <cmath>

#include "core/base/parallel.hpp"
#include "haptics/cells/contact_width.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "io/surface/refine_surface.hpp"
#include "lab/advise/advise_parts.hpp"

namespace kt {
namespace {

constexpr int kMostNodes = 40000;    // of a body that is pressed: its linear systems take some seconds
constexpr double kHopeless = 4;      // times too slow for the lowest rate
constexpr double kTruthShare = 0.7;  // of the time for bodies that the truth may take

/// A step of the body and the cheapest local model from it, on one core, where the tool touches [ms].
double measure_refresh(const Scene& scene, const Mesh& mesh) {
  Scene shortest = row_scene(scene, kRates[0], "wall");
  shortest.global.early_refresh = false;
  shortest.duration = 1 / kRates[0] + 1 / scene.local.rate_hz;  // the first is set-up
  Session session(shortest, mesh);
  SessionOptions options;
  options.check_contacts = false;
  SessionResult result;
  const double share = share_of_core([&] { with_threads(1, [&] { result = session.run(options); }); });
  return share * (result.refresh.global_ms.back() + result.refresh.refresh_ms.back());
}

/// Throws RunError when it is too large, too slow or does not come to rest.
PressResult press_session(const Session& session, const PressSite& site, const AdviceClock& clock, double share) {
  const int nodes = session.model().mesh().num_nodes();
  if (nodes > kMostNodes) throw RunError(text(nodes, " nodes, of ", kMostNodes, " at most"));
  PressResult out =
      press(session.model(), session.start(), site,
            {.young = session.scene().object.model.young, .solver = session.scene().global.solver, .stop = [&] {
               return clock.is_over(share);
             }});
  if (!out.settled) throw RunError("the press did not come to rest");
  return out;
}

/// Force on the tool at the end of a press by the engine itself, in lockstep and without friction [N]: only its local
/// models have refined cells.
Vec3 press_refined(Scene scene, const Mesh& mesh, const PressSite& site, const AdviceClock& clock, double share) {
  constexpr double kPress = 0.2, kRest = 0.2;  // [s]
  constexpr double kClear = 0.05;              // of the depth, before the touch
  const Vec3 way = site.to - site.from;
  scene.tool.path = {};
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = {{0, site.from - kClear * way}, {kPress, site.to}, {kPress + kRest, site.to}};
  scene.duration = kPress + kRest;
  scene.contact.mu_static = scene.contact.mu_kinetic = 0;
  scene.contact.regions.clear();
  scene.link = {};
  std::atomic<bool> over{false};
  SessionOptions options;
  options.check_contacts = false;
  options.stop = &over;
  options.progress = watch(clock, share, over);
  const SessionResult run = Session(row_scene(scene, kRates[1], "condensed"), mesh).run(options);
  if (run.stopped) throw RunError("");
  return run.tools[0].frames.back().force;
}

std::string why_no_truth(const AdviceScene& scene) {
  const SceneObject& object = scene.scene.object;
  if (scene.scene.tool.shape == "capsule" || scene.scene.tool.shape == "mesh")
    return text("the press that judges bodies knows a sphere, not a ", scene.scene.tool.shape);
  if (scene.scene.tool.shape == "point")
    return "the force on a point depends on the mesh and has no limit (docs/method.md#8-what-is-measured)";
  if (object.layers) return "the body has layers of masses instead of tetrahedra";
  if (object.model.type == "msd" && (object.model.stiffness || !object.model.calibrate))
    return "springs of a given stiffness stand for no material";
  if (object.fixed.nodes) return "object.fixed.nodes are numbers of one mesh, no finer one has them";
  return {};
}

/// 10-node elements of the scene's own material, on a surface that is split under the tool. (The tetrahedralizer keeps
/// the surface's triangles: a finer inside alone does not do.) Twice, to see what half the size changes; the second is
/// left out when the time or the nodes run out.
/// @returns the force on the tool [N]
Vec3 find_truth(const AdviceScene& scene, const AdviceClock& clock, double share, AdviceTruth& out) {
  Vec3 force = Vec3::Zero();
  const double contact = scene.site.contact_radius();
  const AdviceBody quadratic{.model = "tet10"};
  for (const double parts : {1.5, 3.0}) try {
      const SurfaceSize size{.centre = scene.site.to, .radius = 1.5 * contact, .edge = contact / parts, .growth = 0.8};
      const Mesh surface = refine_surface({scene.mesh.x, scene.mesh.triangles, {}}, size, kMostNodes);
      const Session session(with_body(scene.scene, quadratic),
                            tetrahedralize(surface, {.max_volume = 8 * automatic_max_volume(scene.mesh)}));
      const PressResult pressed = press_session(session, scene.site, clock, share);
      for (const Tetrahedron& t : session.model().mesh().tetrahedra)
        if (tetrahedron_volume(pressed.state.x, t) < 0) throw RunError("tetrahedra turned inside out");
      if (parts > 1.5) out.uncertainty = (pressed.force - force).norm() / pressed.force.norm();
      force = pressed.force;
      out.force = force.norm();
      out.nodes = session.model().mesh().num_nodes();
    } catch (const std::runtime_error& e) {
      if (parts == 1.5) throw RunError(text("the finest body gave no force: ", e.what()));
    }
  return force;
}

/// The scene's own mesh and, where it is made from a surface, one that is coarser inside and one with half the edges.
std::vector<AdviceBody> meshes_of(const AdviceScene& scene) {
  const auto two_digits = [](double value) {  // it is to be pasted
    const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
    return std::round(value / unit) * unit;
  };
  const SceneTetrahedralize own = scene.scene.object.tetrahedralize.value_or(SceneTetrahedralize{});
  std::vector<AdviceBody> out{{.mesh_name = "own", .filled = own, .mesh = scene.mesh}};
  if (!scene.from_surface) return out;
  const double volume = automatic_max_volume(scene.mesh);  // 1.5 regular tetrahedra on the mean edge
  const double edge = std::cbrt(volume * 6 * std::sqrt(2.0) / 1.5);
  AdviceBody coarser{.mesh_name = "coarse inside", .filled = own}, finer{.mesh_name = "half edges", .filled = own};
  coarser.filled.max_volume = two_digits(8 * own.max_volume.value_or(volume));
  finer.filled.max_edge = two_digits(0.7 * edge);  // halves the edges of equal triangles, and no more
  if (own.max_volume) finer.filled.max_volume = two_digits(*own.max_volume / 8);
  for (AdviceBody body : {coarser, finer}) {
    std::vector<std::string> notes;
    try {
      body.mesh = load_body_mesh(body_options(with_body(scene.scene, body)), notes);
    } catch (const std::runtime_error& e) {
      body.note = text("no such mesh: ", e.what());
    }
    out.push_back(std::move(body));
  }
  return out;
}

/// As AdviceBody::model names it.
std::string element_in(const SceneModel& model) {
  if (model.type != "fem") return model.type;
  return model.element == "tet10" ? "tet10" : "tet4";
}

/// Every model on every mesh, the scene's own first, then those that take the least time.
std::vector<AdviceBody> bodies_of(const AdviceScene& scene) {
  const SceneObject& own = scene.scene.object;
  const auto work = [&](const AdviceBody& b) {
    if (b.mesh_name == "own" && b.model == element_in(own.model)) return static_cast<std::size_t>(b.refined);
    return b.mesh.tetrahedra.size() * (b.model == "tet10" ? 20 : 1);
  };
  std::vector<AdviceBody> out;
  for (AdviceBody body : meshes_of(scene))
    for (const char* model : {"msd", "tet4", "tet10"}) {
      body.model = model;
      out.push_back(body);
      if (!scene.may_refine || std::string_view(model) == "msd") continue;  // springs come out too soft
      body.refined = true;
      out.push_back(body);
      body.refined = false;
    }
  std::ranges::stable_sort(out, {}, work);
  return out;
}

}  // namespace

Scene with_body(Scene scene, const AdviceBody& body) {
  SceneModel& m = scene.object.model;
  const bool in_lattice = scene.object.body == "lattice";  // its cubes where its tetrahedra would fail
  m.type = body.model == "msd" ? "msd" : "fem";
  if (m.type == "fem") m.element = in_lattice && body.model == "tet4" ? "auto" : body.model;
  scene.object.tetrahedralize = body.filled;
  scene.local.refine = body.refined ? "follow" : "off";
  return scene;
}

void press_bodies(const AdviceScene& scene, const AdviceClock& clock, double share, Advice& out) {
  out.truth.depth = scene.site.depth();
  out.truth.why_none = why_no_truth(scene);
  Vec3 truth = Vec3::Zero();
  if (out.truth.why_none.empty()) try {
      truth = find_truth(scene, clock, kTruthShare * share, out.truth);
    } catch (const std::runtime_error& e) {
      out.truth.why_none = e.what();
    }
  const bool is_judged = out.truth.why_none.empty();
  out.bodies = bodies_of(scene);
  if (!is_judged) out.bodies.resize(1);
  for (AdviceBody& body : out.bodies) try {
      if (!body.note.empty()) continue;
      if (clock.is_over(share) && is_judged) throw RunError("");
      const Scene changed = with_body(scene.scene, body);
      const Session session(changed, body.mesh);
      body.nodes = session.model().mesh().num_nodes();
      if (body.nodes > kMostNodes) throw RunError(text("more than ", kMostNodes, " nodes"));
      if (const auto width = find_contact_width(session, std::span(&scene.site.to, 1))) {
        body.cell_over_contact_radius = width->mean;
        body.expected_factor = width->factor;
      }
      body.refresh_ms = measure_refresh(changed, body.mesh);
      body.note = out.truth.why_none;
      if (!is_judged) continue;
      // No time for presses of what cannot be an answer, unless it is what the user has.
      if (&body != &out.bodies[0] && candidate_of(body).slow_load > kHopeless) continue;
      const Vec3 force = body.refined ? press_refined(changed, body.mesh, scene.site, clock, share)
                                      : press_session(session, scene.site, clock, share).force;
      body.force = force.norm();
      body.error = (force - truth).norm() / truth.norm();
    } catch (const std::runtime_error& e) {
      body.note = clock.is_over(share) ? "beyond the time budget" : e.what();
    }
}

}  // namespace kt
