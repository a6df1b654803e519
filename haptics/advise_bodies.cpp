// First half of an advice: models and meshes, pressed in equilibrium.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/global_simulation.hpp"
#include "core/parallel.hpp"
#include "haptics/advise_parts.hpp"
#include "haptics/press.hpp"
#include "io/refine_surface.hpp"
#include "io/tetrahedralize.hpp"

namespace kt {
namespace {

constexpr int kMostNodes = 40000;                  // of a body that is pressed for an advice
constexpr double kRungs[] = {1, 8, 0.25, 0.0625};  // of the scene's own largest tetrahedron; the most telling first
constexpr double kStiffness = 100;  // of the press's contact, over young * radius: some hundred times the body's

double process_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

PressResult press_scene(const AdviceScene& scene, const Session& session, const AdviceClock& clock, double share) {
  PressOptions options;
  options.stiffness = kStiffness * scene.scene.object.model.young * session.tool().radius;
  options.steps = std::clamp(static_cast<int>(std::ceil(2 * scene.site.depth / session.tool().radius)), 1, 8);
  options.solver = scene.scene.global.solver;
  options.stop = [&] {
    clock.show();
    return clock.stopped() || clock.left(share) < 0;
  };
  return press(session.model(), session.start(), session.tool().radius, scene.site.from, scene.site.to, options);
}

Mesh fill(const AdviceScene& scene, const Mesh& surface, double max_volume, const AdviceClock& clock) {
  const SceneTetrahedralize wanted = scene.scene.object.tetrahedralize.value_or(SceneTetrahedralize{});
  TetrahedralizeOptions options;
  options.name = scene.scene.object.mesh;
  options.backend = wanted.backend;
  options.quality = wanted.quality;
  options.max_volume = max_volume;
  options.stop = clock.stop();
  return tetrahedralize(surface, options);
}

/// Of the 10-node elements of a mesh: one on every edge besides the corners.
int quadratic_nodes(const Mesh& mesh) {
  const int tets = static_cast<int>(mesh.tetrahedra.size()), faces = static_cast<int>(mesh.triangles.size());
  // Edges by Euler's formula for a ball: n - e + f - t = 1 with f = (4 t + faces) / 2.
  return 2 * mesh.num_nodes() + (4 * tets + faces) / 2 - tets - 1;
}

/// Measures the truth and then every rung, as far as the time reaches.
class BodyBench {
 public:
  BodyBench(const AdviceScene& scene, const AdviceClock& clock, double share, std::vector<std::string>& notes)
      : scene_(scene), clock_(clock), share_(share), notes_(notes) {}

  AdviceBodies run() {
    const Mesh surface{scene_.mesh.x, scene_.mesh.triangles, {}};
    find_truth(surface);
    const std::string own = model_name(scene_.scene.object.model);
    std::vector<std::string> models{own};
    for (const char* name : {"tet4", "msd", "tet10"})
      if (name != own) models.emplace_back(name);
    const double base = volume_limit(surface);
    for (double factor : kRungs) {
      if (factor != 1 && !scene_.has_ladder) break;
      Mesh mesh = scene_.mesh;
      if (factor != 1) try {
          mesh = fill(scene_, surface, factor * base, clock_);
        } catch (const std::runtime_error& e) {
          notes_.push_back(text("no mesh with object.tetrahedralize.max_volume ", factor * base, ": ", e.what()));
          continue;
        }
      if (seen(mesh)) continue;
      for (const std::string& model : models)
        measure(model, mesh, factor == 1 ? std::nullopt : std::optional<double>(factor * base));
    }
    return std::move(out_);
  }

 private:
  double volume_limit(const Mesh& surface) const {
    const auto& wanted = scene_.scene.object.tetrahedralize;
    // Four digits: it is to be pasted.
    const double exact = wanted && wanted->max_volume ? *wanted->max_volume : automatic_max_volume(surface);
    const double unit = std::pow(10, std::floor(std::log10(exact)) - 3);
    return std::round(exact / unit) * unit;
  }

  bool seen(const Mesh& mesh) const {
    return std::ranges::any_of(out_.meshes, [&](const Mesh& other) {
      return other.num_nodes() == mesh.num_nodes() && other.tetrahedra.size() == mesh.tetrahedra.size();
    });
  }

  void measure(const std::string& model, const Mesh& mesh, std::optional<double> max_volume) {
    AdviceBody body{.model = model,
                    .max_volume = max_volume,
                    .nodes = mesh.num_nodes(),
                    .tetrahedra = static_cast<int>(mesh.tetrahedra.size())};
    if (model == "tet10") body.nodes = quadratic_nodes(mesh);
    Mesh used;
    if (body.nodes > kMostNodes)
      body.note = text("not measured: more than ", kMostNodes, " nodes");
    else if (clock_.stopped())
      body.note = "not measured: stopped";
    else if (expected_seconds(body) > clock_.left(share_))
      body.note = "not measured: beyond the time budget";
    else {
      press_body(mesh, body);
      used = mesh;
    }
    clock_.show();
    out_.bodies.push_back(std::move(body));
    out_.meshes.push_back(std::move(used));
  }

  void press_body(const Mesh& mesh, AdviceBody& body) try {
    const double started = clock_.seconds();
    const Session session(with_model(scene_.scene, body.model), mesh);
    body.nodes = session.model().mesh().num_nodes();
    const PressResult pressed = press_scene(scene_, session, clock_, share_);
    if (!pressed.converged) {
      body.note = "not measured: the press found no equilibrium";
      return;
    }
    body.force = pressed.force.norm();
    body.error = (pressed.force - truth_).norm() / truth_.norm();
    body.global_ms = measure_global_step(session, pressed.state);
    body.measured = true;
    int inverted = 0;
    for (const Tetrahedron& t : session.model().mesh().tetrahedra)
      inverted += tetrahedron_volume(pressed.state.x, t) < 0;
    if (inverted > 0) body.note = text(inverted, " tetrahedra turned inside out");
    unit_seconds_[body.model] = (clock_.seconds() - started) / std::pow(body.nodes, 1.5);
  } catch (const std::runtime_error& e) {
    body.note = text("not measured: ", e.what());
  }

  /// From the last body of the same model, else from the truth's; factors of 3D bodies take n^1.5 to n^2.
  double expected_seconds(const AdviceBody& body) const {
    const auto last = unit_seconds_.find(body.model);
    const double unit = last != unit_seconds_.end() ? last->second : unit_seconds_.at("");
    return unit * std::pow(body.nodes, 1.5);
  }

  /// 10-node elements of the scene's own material, on a mesh that is fine where the tool touches. Refining inside alone
  /// does not do: the tetrahedralizer keeps the surface, and with it the triangles under the tool.
  void find_truth(const Mesh& surface) {
    const double contact = std::sqrt(scene_.scene.tool.radius * scene_.site.depth);  // Hertz
    const Vec3 centre = scene_.site.to;
    PressResult finer;
    for (const double parts : scene_.has_ladder ? std::vector<double>{2} : std::vector<double>{1}) {
      const double started = clock_.seconds();
      Mesh mesh = scene_.mesh;
      if (scene_.has_ladder) {
        const SurfaceSize size{centre, 1.5 * contact, contact / parts};
        mesh =
            fill(scene_, refine_surface(surface, size, surface.num_nodes() + 5000), 8 * volume_limit(surface), clock_);
      }
      const int nodes = quadratic_nodes(mesh);
      const bool first = out_.truth.what.empty();
      const double expected = first ? 0 : unit_seconds_.at("") * std::pow(nodes, 1.5);
      if (nodes > kMostNodes || expected > 0.5 * clock_.left(share_)) {
        if (first)
          throw RunError(text("the body is too large to be judged: 10-node elements on its mesh take ", nodes,
                              " nodes, of ", kMostNodes, " at most"));
        notes_.push_back("the truth's own error was not measured: beyond the time budget");
        break;
      }
      const Session session(with_model(scene_.scene, "tet10"), mesh);
      PressResult pressed;
      try {
        pressed = press_scene(scene_, session, clock_, first ? 0.35 : share_);
      } catch (const RunError&) {
        if (first) throw;
        notes_.push_back("the truth's own error was not measured: beyond the time budget");
        break;
      }
      if (!pressed.converged || !(pressed.force.norm() > 0)) {
        if (first) throw RunError("the press on the finest body found no equilibrium: press less deep");
        break;
      }
      if (!first) out_.truth.uncertainty = (pressed.force - truth_).norm() / pressed.force.norm();
      truth_ = pressed.force;
      out_.truth.force = truth_.norm();
      out_.truth.nodes = session.model().mesh().num_nodes();
      out_.truth.tetrahedra = static_cast<int>(mesh.tetrahedra.size());
      out_.truth.edge = scene_.has_ladder ? contact / parts : 0;
      out_.truth.what = text("fem tet10 ", scene_.scene.object.model.material,
                             scene_.has_ladder ? ", surface split under the tool" : ", on the scene's own mesh");
      unit_seconds_[""] = (clock_.seconds() - started) / std::pow(out_.truth.nodes, 1.5);
      clock_.show();
    }
  }

  const AdviceScene& scene_;
  const AdviceClock& clock_;
  double share_;
  std::vector<std::string>& notes_;
  AdviceBodies out_;
  Vec3 truth_ = Vec3::Zero();  // [N]
  std::map<std::string, double> unit_seconds_;
};

}  // namespace

double measure_global_step(const Session& session, const State& state) {
  const SceneGlobal& g = session.scene().global;
  // As a session steps it: an explicit integrator in as many steps as its limit asks for.
  GlobalSimulation body(
      session.model(),
      make_integrator(g.integrator, {.solver = g.solver, .tolerance = g.tolerance, .definite = g.definite}),
      1 / g.rate_hz, state);
  std::vector<double> ms;
  with_threads(1, [&] {
    for (int i = 0; i < 4; ++i) {
      const double started = process_ms();
      body.advance(body.state().t + 1 / g.rate_hz, {});
      if (i > 0) ms.push_back(process_ms() - started);  // the first one analyses the pattern
    }
  });
  std::ranges::sort(ms);
  return ms[ms.size() / 2];
}

AdviceBodies measure_bodies(const AdviceScene& scene, const AdviceClock& clock, double share,
                            std::vector<std::string>& notes) {
  AdviceBodies out;
  out.unjudged = scene.only_own;
  if (out.unjudged.empty()) try {
      return BodyBench(scene, clock, share, notes).run();
    } catch (const RunError& e) {
      out.unjudged = text("no truth to judge models and meshes by: ", e.what());
    }
  const Session session(scene.scene, scene.mesh);
  out.bodies.push_back({.model = model_name(scene.scene.object.model),
                        .nodes = session.model().mesh().num_nodes(),
                        .tetrahedra = static_cast<int>(scene.mesh.tetrahedra.size()),
                        .global_ms = measure_global_step(session, session.start()),
                        .note = "not judged: " + out.unjudged,
                        .measured = true});
  out.meshes.push_back(scene.mesh);
  return out;
}

}  // namespace kt
