// Relative error of the contact impedance for every reducer and frequency, the worst vertex of a patch (two rings
// around a vertex) against the whole linearized body: the table of docs/method.md#4-the-local-model-section-iii, on
// three bodies.
//   ./build/release/bench/impedance_table [--json FILE]
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iomanip>

#include "core/local/certificate.hpp"
#include "core/local/certified_rates.hpp"
#include "haptics/session/session.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

struct ImpedanceBody {
  std::string name;
  const DeformableModel* model;
};

int top_vertex(const Mesh& mesh, const Surface& surface) {
  const Bounds box = bounds(mesh);
  const Vec3 top(box.centre().x(), box.centre().y(), box.max.z());
  int best = surface.triangles.front()[0];
  for (const Triangle& t : surface.triangles)
    for (int i : t)
      if ((node(mesh.x, i) - top).norm() < (node(mesh.x, best) - top).norm() - 1e-9) best = i;
  return best;
}

/// All triangles around the vertex and around its neighbours: 19 vertices on a regular surface.
SurfacePatch two_rings(const Surface& surface, int vertex) {
  std::vector<char> near(surface.topology.first.size() - 1, 0), inside(surface.triangles.size(), 0);
  for (int t : surface.topology.triangles_of(vertex))
    for (int i : surface.triangles[t]) near[i] = 1;
  std::vector<int> local(near.size(), -1);
  for (std::size_t t = 0; t < inside.size(); ++t)
    for (int i : surface.triangles[t]) inside[t] |= near[i];
  SurfacePatch patch;
  for (int i = 0; i < static_cast<int>(near.size()); ++i)
    for (int t : surface.topology.triangles_of(i))
      if (inside[t] && local[i] < 0) {
        local[i] = patch.num_vertices();
        patch.global_node.push_back(i);
      }
  for (int t = 0; t < static_cast<int>(inside.size()); ++t) {
    if (!inside[t]) continue;
    const Triangle& g = surface.triangles[t];
    patch.triangles.push_back({local[g[0]], local[g[1]], local[g[2]]});
    patch.global_triangle.push_back(t);
    patch.on_rim.push_back(0);
  }
  patch.in_reach.assign(patch.global_node.size(), 1);
  patch.topology = make_topology(patch.triangles, patch.num_vertices());
  return patch;
}

struct Row {
  std::string reducer;
  int dof;
  std::vector<double> error;
};

struct Recipe {
  std::string label, reducer;
  ReduceOptions options;
  int refreshes = 1;
};

std::vector<Recipe> recipes() {
  return {{"wall, patch only", "wall", {.rings = 0}},
          {"wall, 1 ring in depth", "wall", {.rings = 1}},
          {"wall, 2 rings in depth", "wall", {.rings = 2}},
          {"wall, 3 rings in depth", "wall", {.rings = 3}},
          {"wall, 4 rings in depth", "wall", {.rings = 4}},
          {"condensed", "condensed", {}},
          {"modal 60", "modal", {.modes = 60}},
          {"krylov {0, 60}, whole body",
           "krylov",
           {.shifts_hz = {0, 60}, .slopes = false, .echoes = 0, .rank_tolerance = 1e-6, .grading = 0}},
          {"krylov, whole, no echoes", "krylov", {.echoes = 0, .rank_tolerance = 1e-6, .grading = 0}},
          {"krylov, whole, 4 echoes", "krylov", {.rank_tolerance = 1e-6, .grading = 0}},
          {"krylov, graded, none dropped", "krylov", {.rank_tolerance = 1e-6}},
          {"krylov {0, 200}", "krylov", {}},
          {"krylov, 10 refreshes later", "krylov", {}, 10},
          {"krylov, coarse", "krylov", {.rank_tolerance = 0.03}},
          {"krylov {0, 200}, no slopes", "krylov", {.slopes = false}},
          {"krylov {0, 30, 80, 250}, no slopes", "krylov", {.shifts_hz = {0, 30, 80, 250}, .slopes = false}},
          {"krylov {0, 60, 250}", "krylov", {.shifts_hz = {0, 60, 250}}},
          {"krylov {0, 20, 40, 80, 160, 400}", "krylov", {.shifts_hz = {0, 20, 40, 80, 160, 400}}}};
}

std::vector<Row> measure(const ImpedanceBody& body) {
  const TangentModel tangent = linearize(*body.model, rest_state(*body.model));
  const Surface surface = make_surface(body.model->mesh());
  const int vertex = top_vertex(body.model->mesh(), surface);
  const SurfacePatch patch = two_rings(surface, vertex);
  const ContactSite site{node(tangent.state.x, vertex), surface.topology.triangles_of(vertex)[0], 0};
  const FreeBody whole(tangent);
  std::vector<std::vector<ComplexMat3>> truth;
  for (double hz : kCertifiedHz) truth.push_back(BodyCompliance(whole, hz).at(patch.global_node));
  std::vector<Row> rows;
  std::printf("\n%s: %d nodes, patch of %d vertices\n%-30s %5s", body.name.c_str(), body.model->mesh().num_nodes(),
              patch.num_vertices(), "error of the impedance, %", "dof");
  for (double hz : kCertifiedHz) std::printf(" %5g Hz", hz);
  for (const Recipe& recipe : recipes()) {
    GradedBody graded({.slope = recipe.options.grading});
    ReduceOptions options = recipe.options;
    if (recipe.refreshes > 1) options.graded = &graded;
    LocalModel m;
    for (int k = 0; k < recipe.refreshes; ++k) m = find_reducer(recipe.reducer)(tangent, patch, site, options);
    Row row{recipe.label, m.dof(), {}};
    for (std::size_t f = 0; f < kCertifiedHz.size(); ++f) {
      double worst = 0;
      for (int v = 0; v < patch.num_vertices(); ++v)
        worst =
            std::max(worst, impedance_error(compliance(m, v, kCertifiedHz[f]), truth[f][static_cast<std::size_t>(v)]));
      row.error.push_back(worst);
    }
    std::printf("\n%-30s %5d", row.reducer.c_str(), row.dof);
    for (double e : row.error) std::printf(" %8.2f", 100 * e);
    std::fflush(stdout);
    rows.push_back(row);
  }
  std::printf("\n");
  return rows;
}

void write_json(std::ostream& out, const std::vector<std::pair<std::string, std::vector<Row>>>& tables) {
  out << std::setprecision(6) << "{\n  \"hz\": [0, 10, 30, 50, 100, 200, 500],\n  \"bodies\": [";
  for (std::size_t b = 0; b < tables.size(); ++b) {
    out << (b ? "," : "") << "\n    { \"body\": \"" << tables[b].first << "\", \"rows\": [";
    for (std::size_t r = 0; r < tables[b].second.size(); ++r) {
      const Row& row = tables[b].second[r];
      out << (r ? "," : "") << "\n      { \"reducer\": \"" << row.reducer << "\", \"dof\": " << row.dof
          << ", \"error\": [";
      for (std::size_t f = 0; f < row.error.size(); ++f) out << (f ? ", " : "") << row.error[f];
      out << "] }";
    }
    out << " ] }";
  }
  out << "\n  ]\n}\n";
}

int run(const std::string& json) {
  Mesh block = kuhn_block(20, 20, 6, 0.005);
  std::vector<int> base;
  for (int i = 0; i < 21 * 21; ++i) base.push_back(i);
  const auto fem =
      make_model("fem", block, {.young = 1e4, .poisson = 0.4, .damping_stiffness = 2e-3, .fixed_nodes = base});
  const Session slab(load_scene(KT_SOURCE_DIR "/scenes/slab_drag.json"));
  const Session organ(load_scene(KT_SOURCE_DIR "/scenes/organ_drag.json"));
  std::vector<std::pair<std::string, std::vector<Row>>> tables;
  for (const ImpedanceBody& body : {ImpedanceBody{"FEM block (method.md)", fem.get()},
                                    ImpedanceBody{"MSD slab (scenes/slab_drag.json)", &slab.model()},
                                    ImpedanceBody{"MSD organ (scenes/organ_drag.json)", &organ.model()}})
    tables.emplace_back(body.name, measure(body));
  if (json.empty()) return 0;
  std::ofstream out(json);
  write_json(out, tables);
  return out ? 0 : 1;
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  std::string json;
  CLI::App app;
  app.add_option("--json", json);
  CLI11_PARSE(app, argc, argv);
  return kt::run(json);
}
