// From words to a mesh and its clamped nodes.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "core/body/cut_tetrahedron.hpp"
#include "core/body/embedded_surface.hpp"
#include "haptics/body/bending.hpp"
#include "haptics/body/body.hpp"
#include "haptics/body/check_mesh.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/solid/lattice.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "io/surface/mesh_repair.hpp"
#include "io/surface/refine_surface.hpp"
#include "models/msd/springs.hpp"

namespace kt {
namespace {

/// @returns the file's unit [m]
double rescale(Mesh& mesh, const SceneObject& object) {
  double unit = object.scale.value_or(1);
  if (object.size) {
    const double longest = bounds(mesh).size().maxCoeff();
    if (!(longest > 0)) throw InputError(text(object.mesh, ": all nodes lie on one point"));
    unit = *object.size / longest;
  }
  mesh.x *= unit;
  return unit;
}

/// Beyond, squares and volumes leave the finite numbers; a body lies nowhere near.
void require_near(const Mesh& mesh, const SceneObject& object) {
  constexpr double kFarthestNode = 1e6;  // [m] as the tool's path
  const double farthest = mesh.x.size() > 0 ? mesh.x.lpNorm<Eigen::Infinity>() : 0;
  if (!(farthest <= kFarthestNode))
    throw InputError(text(object.mesh, ": reaches ", farthest, " m from the origin, must be within ", kFarthestNode,
                          " m: set object.size or object.scale"));
}

Mesh split_long_edges(Mesh surface, double max_edge) {
  constexpr int kMostNodes = 200000;
  try {
    return refine_surface(std::move(surface), {.radius = std::numeric_limits<double>::infinity(), .edge = max_edge},
                          kMostNodes);
  } catch (const RunError& e) {
    throw InputError(text("object.tetrahedralize.max_edge: ", max_edge, " m: ", e.what()));
  }
}

/// A body that has its tetrahedra from elsewhere is not filled.
void note_unused(const SceneObject& object, bool has_tetrahedra, std::vector<std::string>& notes) {
  if (!object.tetrahedralize || !(has_tetrahedra || object.layers || object.body == "lattice")) return;
  notes.push_back(text("object.tetrahedralize does nothing: ", object.body == "lattice" ? "object.body is lattice"
                                                               : object.layers
                                                                   ? "object.layers makes the tetrahedra"
                                                                   : object.mesh + " has tetrahedra already"));
}

Mesh fill(Mesh mesh, const SceneObject& object, std::vector<std::string>* notes) {
  if (object.layers)
    return add_inner_layers(mesh, object.layers->count, object.layers->count * object.layers->thickness);
  if (!mesh.tetrahedra.empty()) return mesh;
  const SceneTetrahedralize wanted = object.tetrahedralize.value_or(SceneTetrahedralize{});
  if (wanted.max_edge) mesh = split_long_edges(std::move(mesh), *wanted.max_edge);
  TetrahedralizeOptions options;
  options.name = object.mesh;
  options.backend = wanted.backend;
  options.max_volume = wanted.max_volume.value_or(0);
  options.quality = wanted.quality;
  options.notes = notes;
  return tetrahedralize(mesh, options);
}

}  // namespace

Mesh load_body_mesh(const BodyOptions& options, std::vector<std::string>& notes, double* unit) {
  const SceneObject& object = options.object;
  if (object.mesh.empty()) throw InputError("object.mesh: no mesh is named");
  Mesh mesh = load_mesh(object.mesh, {.read_file = options.read_file}, &notes);
  if (mesh.triangles.empty()) throw InputError(text(object.mesh, ": the mesh has no triangles"));
  const double its_unit = rescale(mesh, object);
  if (unit) *unit = its_unit;
  require_near(mesh, object);
  note_unused(object, !mesh.tetrahedra.empty(), notes);
  if (object.repair && mesh.tetrahedra.empty()) {
    RepairResult repaired = repair(mesh);
    for (const std::string& what : repaired.done) notes.push_back("object.repair: " + what);
    mesh = std::move(repaired.mesh);
  }
  if (object.body == "lattice") return in_lattice(std::move(mesh), object, options.global.rate_hz, notes);
  return fill(std::move(mesh), object, &notes);
}

namespace {

/// Where nodes are clamped, and how a message names it.
struct ClampedPlace {
  Vec3 low = Vec3::Constant(-std::numeric_limits<double>::infinity()), high = -low;
  std::string choice;
  /// @param off  so far beside it counts [m]
  bool holds(const Vec3& p, double off = 0) const {
    return (p.array() >= low.array() - off).all() && (p.array() <= high.array() + off).all();
  }
};

ClampedPlace clamped_place(const Bounds& box, const SceneFixed& fixed) {
  ClampedPlace out;
  if (fixed.box) {
    out.choice = "object.fixed.box";
    out.low = (*fixed.box)[0].cwiseMin((*fixed.box)[1]);
    out.high = (*fixed.box)[0].cwiseMax((*fixed.box)[1]);
    return out;
  }
  out.choice = text("object.fixed.below {axis ", fixed.below->axis, ", fraction ", fixed.below->fraction, "}");
  const int axis = fixed.below->axis[0] - 'x';
  out.high[axis] = box.min[axis] + fixed.below->fraction * box.size()[axis];
  return out;
}

}  // namespace

Mesh in_lattice(Mesh mesh, const SceneObject& object, double rate_hz, std::vector<std::string>& notes) {
  constexpr double kNodesAtOneHz = 18000;         // a refresh takes some 30 us a node
  constexpr double kFewest = 200, kEnough = 600;  // refined cells have the contact: a slower rate is to be easier
  if (object.body != "lattice" || mesh.embedded) return mesh;
  const bool is_auto = object.model.element == "auto";
  const SceneLattice wanted = object.lattice.value_or(SceneLattice{});
  LatticeOptions options;
  options.name = object.mesh;
  options.edge = wanted.edge.value_or(0);
  if (object.fixed.box || object.fixed.below)
    options.clamped = [&](const Bounds& body) {
      const ClampedPlace place = clamped_place(body, object.fixed);
      return Bounds{place.low, place.high};
    };
  options.is_quadratic =
      object.model.type == "fem" && (object.model.element == "tet10" || (is_auto && auto_has_ten_nodes(object)));
  options.nodes = wanted.nodes.value_or(static_cast<int>(std::clamp(kNodesAtOneHz / rate_hz, kFewest, kEnough)));
  LatticeReport report;
  Mesh out = make_lattice(mesh, options, &report);
  for (std::string& line : report.lines()) notes.push_back(std::move(line));
  if (!is_auto || object.model.type != "fem") return out;
  const double poisson = object.model.poisson;
  if (options.is_quadratic)
    notes.push_back(
        text("object.model.element auto: cells of ten nodes, since those of four lock at object.model.poisson ",
             short_number(poisson), ": as many nodes, in larger cubes, and a refresh takes up to twice as long"));
  else if (lattice_element(out, poisson) == "hex8")
    notes.push_back(
        text("object.model.element auto: the cubes of the lattice (hex8), since tetrahedra of four nodes would bend ",
             short_number(tet4_stiffening(cells_across(out), 0.5 - poisson)), " times too little"));
  return out;
}

std::string given_mesh_name(const SceneObject& object) {
  return object.mesh.empty() || object.mesh == kGivenMesh ? "the given mesh" : object.mesh;
}

Mesh filled(Mesh mesh, const SceneObject& object) {
  SceneObject named = object;
  named.mesh = given_mesh_name(object);
  check_and_orient(mesh, named.mesh);
  require_near(mesh, named);
  return fill(std::move(mesh), named, nullptr);
}

namespace {

/// Nodes of a lattice that lie in the place and in material, or in a cell with a clamped vertex of the surface; all of
/// these cells' where none does: cells are larger than the place.
std::vector<int> clamped_cells(const Mesh& mesh, const ClampedPlace& place) {
  constexpr double kRounding = 1e-6;  // of an edge: the lattice has nodes where the place ends
  const EmbeddedSurface& surface = *mesh.embedded;
  std::vector<char> has_clamped(mesh.tetrahedra.size(), 0);
  for (int v = 0; v < surface.num_vertices(); ++v)
    if (place.holds(node(mesh.x, surface.first + v)))
      has_clamped[static_cast<std::size_t>(surface.cell[static_cast<std::size_t>(v)])] = 1;
  std::vector<int> there, around;
  std::vector<char> is_there(static_cast<std::size_t>(mesh.num_own_nodes()), 0);
  const double rounding = kRounding * surface.edge;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
    for (const int i : mesh.tetrahedra[t]) {
      if (has_clamped[t]) around.push_back(i);
      const Vec3 at = node(mesh.x, i);
      char& its = is_there[static_cast<std::size_t>(i)];
      if (its || !place.holds(at, rounding)) continue;
      its = has_clamped[t] || surface.material->depth(static_cast<int>(t), at, rounding) > 0;
      if (its) there.push_back(i);
    }
  return there.empty() ? around : there;
}

/// With the nodes between clamped ones.
std::vector<int> with_middles(const Mesh& mesh, std::vector<int> corners) {
  std::vector<char> is_clamped(static_cast<std::size_t>(mesh.num_own_nodes()), 0);
  for (const int i : corners) is_clamped[static_cast<std::size_t>(i)] = 1;
  for (std::size_t t = 0; t < mesh.embedded->middles.size(); ++t)
    for (std::size_t e = 0; e < 6; ++e) {
      const auto clamped = [&](int end) {
        return is_clamped[static_cast<std::size_t>(mesh.tetrahedra[t][static_cast<std::size_t>(kCellEdges[e][end])])] !=
               0;
      };
      if (clamped(0) && clamped(1)) corners.push_back(mesh.embedded->middles[t][e]);
    }
  return corners;
}

}  // namespace

std::vector<int> find_fixed_nodes(const Mesh& mesh, const SceneFixed& fixed) {
  std::vector<int> out;
  std::string choice = "object.fixed.nodes";
  if (fixed.nodes) {
    out = *fixed.nodes;
    for (int i : out)
      if (i < 0 || i >= mesh.num_nodes())
        throw InputError(text("object.fixed.nodes: node ", i, " is outside 0 .. ", mesh.num_nodes() - 1));
  } else if (fixed.box || fixed.below) {
    const ClampedPlace place = clamped_place(bounds(mesh), fixed);
    choice = place.choice;
    if (mesh.embedded)
      out = with_middles(mesh, clamped_cells(mesh, place));
    else
      for (int i = 0; i < mesh.num_nodes(); ++i)
        if (place.holds(node(mesh.x, i))) out.push_back(i);
  } else {
    return out;
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  if (out.empty()) throw InputError(choice + ": holds no node of the mesh, so the body would float");
  if (static_cast<int>(out.size()) == mesh.num_own_nodes())
    throw InputError(choice + ": clamps every node of the mesh");
  return out;
}

}  // namespace kt
