#include "lab/chart/matrix.hpp"

#include <filesystem>

#include "core/base/error.hpp"

namespace kt {
namespace {

std::string rate_setting(int rate) { return text("global.rate_hz=", rate); }

/// One setting away each from what the engine does by itself at 30 Hz, but that cells are as they are: the full model
/// that is the truth has none that are refined.
std::vector<ChartMethod> all_methods(bool full) {
  std::vector<ChartMethod> out;
  const std::vector<int> rates = full ? std::vector{10, 20, 30, 60, 100} : std::vector{10, 30, 60};
  const std::vector<int> other_rates = full ? rates : std::vector{30};
  const auto add = [&](const std::string& family, const std::string& label, std::vector<std::string> set,
                       const std::vector<int>& at) {
    for (const int rate : at) {
      std::vector<std::string> all = {rate_setting(rate), "local.refine=off"};
      all.insert(all.end(), set.begin(), set.end());
      out.push_back({family, text(label, ", ", rate, " Hz"), std::move(all), family == "ours"});
    }
  };
  add("ours", "auto", {}, rates);
  for (const char* reducer : {"condensed", "krylov", "modal"})
    add("reducer", reducer, {text("local.reducer=", reducer)}, other_rates);
  for (const int rings : full ? std::vector{1, 2, 3, 4} : std::vector{1, 3})
    add("reducer", text("wall, rings ", rings), {"local.reducer=wall", text("local.rings=", rings)}, other_rates);
  if (full) add("reducer", "full", {"local.reducer=full"}, {30});
  add("baseline", "hold", {"local.method=hold", "local.reducer=condensed"}, rates);
  add("baseline", "legacy", {"local.method=legacy", "local.reducer=wall"}, other_rates);
  add("baseline", "frozen", {"local.method=frozen", "local.reducer=condensed"}, rates);
  add("baseline", "penalty", {"local.method=penalty", "local.reducer=condensed"}, other_rates);
  for (const char* integrator : {"symplectic_euler", "newton_euler", "sdirk2", "implicit_midpoint", "quasistatic"})
    add("global integrator", integrator, {text("global.integrator=", integrator)}, other_rates);
  for (const char* integrator : {"implicit_euler", "symplectic_euler"})
    add("local integrator", integrator, {text("local.integrator=", integrator)}, {30});
  for (const char* metric : {"identity", "mass", "implicit"})
    add("contact law", text("paper_stick_slip, ", metric),
        {"contact.law=paper_stick_slip", text("contact.metric=", metric), "local.integrator=implicit_euler"}, {30});
  add("contact law", "smooth surface", {"contact.surface=loop"}, other_rates);
  for (const char* backend : {"refit_bvh", "embree", "brute_force"})
    add("collision backend", backend, {text("collision.backend=", backend)}, {30});
  for (const char* reducer : {"auto", "condensed", "krylov"})
    add("refresh", text(reducer, ", as late as it takes"),
        {text("local.reducer=", reducer), "link.charge_refreshes=measured"}, {30});
  add("refresh", "one frame late", {"link.latency_ms=33"}, {30});
  add("refresh", "no catch-up", {"local.catch_up=false"}, {30});
  add("refresh", "no look-ahead", {"global.look_ahead=false"}, {30});
  add("refresh", "only at the stated rate", {"global.early_refresh=false"}, {30});
  return out;
}

ChartBody fem_body(const std::string& name, const std::string& material, const std::string& element) {
  return {name, {"object.model.type=fem", "object.model.material=" + material, "object.model.element=" + element}};
}

}  // namespace

ChartMatrix drag_matrix(const std::string& scene, bool full) {
  ChartMatrix out{"drag", "press and drag: methods against the full body in fine steps", scene, {}, {}, {}};
  out.bodies = {{"springs", {"object.model.type=msd"}}, fem_body("neo-Hookean elements", "neo_hookean", "tet4")};
  if (full) {
    for (const char* material : {"linear", "corotational", "stvk"})
      out.bodies.push_back(fem_body(text(material, " elements"), material, "tet4"));
    out.bodies.push_back(fem_body("neo-Hookean, 10 nodes", "neo_hookean", "tet10"));
  }
  out.methods = all_methods(full);
  return out;
}

ChartMatrix press_matrix(const std::string& scene, bool full) {
  ChartMatrix out{"press", "a pressed sphere: models and meshes against the continuum", scene, {}, {}, {}};
  const std::vector<double> edges = full ? std::vector{0.015, 0.010, 0.007, 0.005} : std::vector{0.015, 0.010, 0.007};
  const auto with_edge = [](ChartBody body, double edge) {
    body.name += text(", edges ", 1e3 * edge, " mm");
    body.set.push_back(text("object.tetrahedralize.max_edge=", edge));
    return body;
  };
  for (const double edge : edges) {
    out.bodies.push_back(with_edge({"springs", {"object.model.type=msd"}}, edge));
    out.bodies.push_back(with_edge(fem_body("4-node elements", "neo_hookean", "tet4"), edge));
    if (edge > edges.back())  // the finest takes minutes
      out.bodies.push_back(with_edge(fem_body("10-node elements", "neo_hookean", "tet10"), edge));
  }
  const auto cells = [](const char* name, const char* reducer, const char* refine, bool is_ours) {
    return ChartMethod{"mesh",
                       text(name, ", 20 Hz"),
                       {rate_setting(20), text("local.reducer=", reducer), text("local.refine=", refine)},
                       is_ours};
  };
  // A slow press hardly asks for inertia: condensed is exact at rest, and the same for every mesh.
  out.methods = {cells("refined under the tool", "condensed", "follow", true), cells("auto", "auto", "auto", true),
                 cells("as they are", "condensed", "off", false)};
  // 1.9 % above the continuum (0.0880 N): its cells are refined, as the first method says.
  out.truth = {with_edge(fem_body("10-node elements, refined", "neo_hookean", "tet10"), 0.0065)};
  return out;
}

ChartMatrix scene_matrix(const std::string& scene, bool full) {
  const std::string name = std::filesystem::path(scene).stem().string();
  return {name, "methods on " + name, scene, {{"the scene's body", {}}}, all_methods(full), {}};
}

}  // namespace kt
