#include "apps/outputs/mesh_report.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numbers.hpp"
#include "io/surface/border_loops.hpp"

namespace kt {
namespace {

using nlohmann::json;

json to_json(const Vec3& p) { return {p[0], p[1], p[2]}; }

std::string row(const std::string& name, const std::string& value) {
  constexpr std::size_t kColumn = 36;
  return "  " + name + std::string(kColumn - std::min(kColumn - 1, name.size()), ' ') + value + "\n";
}

std::vector<BorderLoop> holes(const Mesh& mesh) {
#if KT_WITH_OPENMESH
  return find_border_loops(mesh);
#else
  (void)mesh;
  return {};
#endif
}

}  // namespace

std::string report_text(const Mesh& mesh, const MeshReport& r, int shown) {
  std::string out;
  out += row("nodes, triangles, tetrahedra", text(r.nodes, ", ", r.triangles, ", ", r.tetrahedra));
  out += row("size", told(r.box.size().x(), " x ", r.box.size().y(), " x ", r.box.size().z()));
  out += row("likely unit", r.likely_unit);
  out += row("edge shortest, mean, longest", told(r.edge_min, ", ", r.edge_mean, ", ", r.edge_max));
  out += row("area", told(r.area));
  out += row("volume", !r.closed()               ? "none: the surface is open"
                       : std::isfinite(r.volume) ? told(r.volume)
                                                 : "unknown");
  if (r.tetrahedra > 0) out += row("volume of the tetrahedra", told(r.tetrahedra_volume));
  out += row("pieces", text(r.components));
  out += row("Euler characteristic", text(r.euler, r.genus ? text(" (genus ", *r.genus, ")") : ""));
  out += row("closed", r.closed() ? "yes" : "no");
  out += row("manifold", r.manifold() ? "yes" : "no");
  std::vector<std::string> absent;
  for (const DefectList& d : defects(r)) {
    const bool intersections = d.key == "self_intersections";
    if (intersections && !r.self_intersections_checked) continue;
    if (d.places->empty()) {
      absent.push_back(d.title);
      continue;
    }
    const bool stopped = intersections && !r.self_intersections_complete;
    out += row(d.title, text(stopped ? "at least " : "", d.places->size()));
    for (std::size_t i = 0; i < std::min<std::size_t>(static_cast<std::size_t>(shown), d.places->size()); ++i)
      out += "    " + describe((*d.places)[i]) + "\n";
    if (!d.cure.empty()) out += "    parts that hang together nowhere else are apart; to join them: " + d.cure + "\n";
    if (d.places->size() > static_cast<std::size_t>(shown)) out += "    ... (--places N shows more, --json FILE all)\n";
  }
  if (!r.open_edges.empty()) {
    const std::vector<BorderLoop> loops = holes(mesh);
    if (!loops.empty()) out += row("holes", text(loops.size()));
    for (std::size_t i = 0; i < std::min<std::size_t>(static_cast<std::size_t>(shown), loops.size()); ++i)
      out += told("    around (", loops[i].centre[0], ", ", loops[i].centre[1], ", ", loops[i].centre[2], "), ",
                  loops[i].nodes.size(), " edges, length ", loops[i].length, "\n");
  }
  if (!r.self_intersections_checked) out += row("pairs of triangles that intersect", "not looked for");
  if (!absent.empty()) out += "  none found: " + join(absent) + "\n";
  return out;
}

json report_json(const Mesh& mesh, const MeshReport& r) {
  json out = {{"nodes", r.nodes},
              {"triangles", r.triangles},
              {"tetrahedra", r.tetrahedra},
              {"edges", r.edges},
              {"components", r.components},
              {"euler", r.euler},
              {"genus", r.genus ? json(*r.genus) : json(nullptr)},
              {"closed", r.closed()},
              {"manifold", r.manifold()},
              {"clean", r.clean()},
              {"box", {{"min", to_json(r.box.min)}, {"max", to_json(r.box.max)}, {"size", to_json(r.box.size())}}},
              {"likely_unit", r.likely_unit},
              {"area", r.area},
              {"volume", r.volume},
              {"tetrahedra_volume", r.tetrahedra_volume},
              {"edge_length", {{"min", r.edge_min}, {"mean", r.edge_mean}, {"max", r.edge_max}}},
              {"self_intersections_checked", r.self_intersections_checked},
              {"self_intersections_complete", r.self_intersections_complete}};
  json& all = out["defects"] = json::object();
  for (const DefectList& d : defects(r)) {
    json& list = all[d.key] = json::array();
    for (const MeshPlace& p : *d.places) {
      json place = {{"at", to_json(p.at)}};
      if (!p.nodes.empty()) place["nodes"] = p.nodes;
      if (!p.triangles.empty()) place["triangles"] = p.triangles;
      if (!p.tetrahedra.empty()) place["tetrahedra"] = p.tetrahedra;
      list.push_back(place);
    }
  }
  json& loops = out["holes"] = json::array();
  if (!r.open_edges.empty())
    for (const BorderLoop& l : holes(mesh))
      loops.push_back({{"nodes", l.nodes}, {"length", l.length}, {"centre", to_json(l.centre)}});
  return out;
}

json wrap_json(const WrapResult& w) {
  return {{"alpha", w.alpha},
          {"offset", w.offset},
          {"volume_before", w.volume_before},
          {"volume_after", w.volume_after},
          {"distance_to_wrap", w.distance_to_wrap},
          {"distance_to_input", w.distance_to_input}};
}

}  // namespace kt
