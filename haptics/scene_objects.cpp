// From a scene's words to a mesh and its clamped nodes.
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptics/session.hpp"
#include "io/mesh_io.hpp"
#include "io/mesh_repair.hpp"
#include "io/refine_surface.hpp"
#include "io/tetrahedralize.hpp"
#include "models/msd/springs.hpp"

namespace kt {
namespace {

void rescale(Mesh& mesh, const SceneObject& object) {
  if (object.scale) mesh.x *= *object.scale;
  if (!object.size) return;
  const double longest = bounds(mesh).size().maxCoeff();
  if (!(longest > 0)) throw InputError(text(object.mesh, ": all nodes lie on one point"));
  mesh.x *= *object.size / longest;
}

/// Beyond, squares and volumes leave the finite numbers; a body lies nowhere near.
void require_near(const Mesh& mesh, const SceneObject& object) {
  constexpr double kFarthest = 1e6;  // [m] as the tool's path
  const double farthest = mesh.x.size() > 0 ? mesh.x.lpNorm<Eigen::Infinity>() : 0;
  if (!(farthest <= kFarthest))
    throw InputError(text(object.mesh, ": reaches ", farthest, " m from the origin, must be within ", kFarthest,
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

}  // namespace

Mesh load_scene_mesh(const Scene& scene, std::vector<std::string>& notes) {
  const SceneObject& object = scene.object;
  if (object.mesh.empty()) throw InputError("object.mesh: no mesh is named");
  Mesh mesh = load_mesh(object.mesh, {}, &notes);
  if (mesh.triangles.empty()) throw InputError(text(object.mesh, ": the mesh has no triangles"));
  rescale(mesh, object);
  require_near(mesh, object);
  if (object.repair && mesh.tetrahedra.empty()) {
    RepairResult repaired = repair(mesh);
    for (const std::string& what : repaired.done) notes.push_back("object.repair: " + what);
    mesh = std::move(repaired.mesh);
  }
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
  return tetrahedralize(mesh, options);
}

std::vector<int> find_fixed_nodes(const Mesh& mesh, const SceneFixed& fixed) {
  std::vector<int> out;
  const Bounds box = bounds(mesh);
  std::string choice;
  if (fixed.nodes) {
    out = *fixed.nodes;
    choice = "object.fixed.nodes";
    for (int i : out)
      if (i < 0 || i >= mesh.num_nodes())
        throw InputError(text("object.fixed.nodes: node ", i, " is outside 0 .. ", mesh.num_nodes() - 1));
  } else if (fixed.box) {
    choice = "object.fixed.box";
    const Vec3 low = (*fixed.box)[0].cwiseMin((*fixed.box)[1]), high = (*fixed.box)[0].cwiseMax((*fixed.box)[1]);
    for (int i = 0; i < mesh.num_nodes(); ++i)
      if ((node(mesh.x, i).array() >= low.array()).all() && (node(mesh.x, i).array() <= high.array()).all())
        out.push_back(i);
  } else if (fixed.below) {
    choice = text("object.fixed.below {axis ", fixed.below->axis, ", fraction ", fixed.below->fraction, "}");
    const int axis = fixed.below->axis[0] - 'x';
    const double level = box.min[axis] + fixed.below->fraction * box.size()[axis];
    for (int i = 0; i < mesh.num_nodes(); ++i)
      if (mesh.x[3 * i + axis] <= level) out.push_back(i);
  } else {
    return out;
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  if (out.empty()) throw InputError(choice + ": holds no node of the mesh, so the body would float");
  if (static_cast<int>(out.size()) == mesh.num_nodes()) throw InputError(choice + ": clamps every node of the mesh");
  return out;
}

}  // namespace kt
