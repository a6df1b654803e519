#include "haptics/predict/predict_elements.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/body/embedded_surface.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {

double cells_across(const Mesh& mesh) {
  if (mesh.tetrahedra.empty()) return 0;
  double length = 0;
  long edges = 0;
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (int i = 0; i < 4; ++i)
      for (int k = i + 1; k < 4; ++k, ++edges) length += (node(mesh.x, t[i]) - node(mesh.x, t[k])).norm();
  // Cubes of a lattice reach beyond the body.
  const auto body = mesh.x.tail(mesh.x.size() - (mesh.embedded ? 3 * mesh.embedded->first : 0))
                        .reshaped(3, mesh.embedded ? mesh.embedded->num_vertices() : mesh.num_nodes());
  const Vec3 size = body.rowwise().maxCoeff() - body.rowwise().minCoeff();
  const double thinnest = mesh.embedded ? std::min(size.minCoeff(), mesh.embedded->thickness) : size.minCoeff();
  return thinnest * static_cast<double>(edges) / length;
}

double tet4_stiffening(double cells, double distance) { return 1 + (2.0 + 0.19 / distance) / (cells * cells); }

double spring_stiffening(double cells, double distance) {
  return (0.47 + 0.11 / distance) * (1 + 0.7 / (cells * cells));
}

double tet4_distance(double cells, double factor) {
  const double left = (factor - 1) * cells * cells - 2.0;
  return left > 0 ? 0.19 / left : std::numeric_limits<double>::quiet_NaN();
}

std::optional<Prediction> predict_locking(const DeformableModel& model, const std::string& element, double poisson) {
  constexpr double kMost = 1.5;
  const ModelInfo info = model.info();
  const double cells = cells_across(model.mesh());
  if (!(cells > 0)) return {};
  if (info.type == "fem" && element == "tet4") {
    const double factor = tet4_stiffening(cells, 0.5 - poisson);
    if (factor < kMost) return {};
    if (model.mesh().embedded)
      return Prediction{"poisson", Finding{told("object.body lattice at object.model.poisson ", poisson, " with ",
                                                cells, " cells across the body bends at least ", factor,
                                                " times too little (limit ", kMost, ")"),
                                           {set_to("object.model.element", "tet10", "as many nodes, in larger cubes"),
                                            advise("set object.lattice.nodes higher")}}
                                       .at("object.body", factor, kMost)};
    return Prediction{
        "poisson",
        Finding{told("object.model.element tet4 at object.model.poisson ", poisson, " with ", cells,
                     " elements across the body bends about ", factor, " times too little (limit ", kMost, ")"),
                {set_to("object.model.element", "tet10", "about eight times the nodes"), advise("refine the mesh")}}
            .at("object.model.element", factor, kMost)};
  }
  if (!info.parameters.contains("calibration_residual")) return {};  // its springs mean no material
  const double factor = spring_stiffening(cells, 0.5 - poisson);
  if (factor < kMost) return {};
  const bool locks = tet4_stiffening(cells, 0.5 - poisson) >= kMost;  // elements of four nodes, on the same mesh
  return Prediction{"poisson", Finding{told("object.model.type msd at object.model.poisson ", poisson, " with ", cells,
                                            " springs across the body is about ", factor, " times too stiff (limit ",
                                            kMost, "): springs have a Poisson ratio of their own, near 1/4"),
                                       {set_to("object.model.poisson", "0.3"),
                                        locks ? advise("set object.model.type to fem and object.model.element to tet10")
                                              : set_to("object.model.type", "fem")}}
                                   .at("object.model.type", factor, kMost)};
}

std::optional<Prediction> predict_collapse(const std::string& model, double stretch) {
  // Measured (map inversion, steps up to 30 ms): from here down some elements flip, and stay so. Springs with their
  // default least_volume: all of a body would have to be its mirror image, nearly.
  const double least = model == "stvk" ? 0.19 : model == "msd" ? -0.71 : -std::numeric_limits<double>::infinity();
  if (!(stretch < least)) return {};
  return Prediction{
      "inversion",
      Finding{told(model == "msd" ? "object.model.type " : "object.model.material ", model, " crushed to ", stretch,
                   " of its height: below ", least, " elements turn inside out and stay so"),
              {advise("press less deep"), advise("take object.model.type fem with object.model.material neo_hookean")}}
          .at(model == "msd" ? "object.model.type" : "object.model.material", stretch, least)};
}

/// A solid that is loaded by a tool bends and bulges: what locks in bending locks there.
void predict_poisson(const BuiltScene& built, std::vector<Prediction>& out) {
  const SceneObject& o = built.scene().object;
  if (auto p = predict_locking(built.model(), element_of(o), o.model.poisson)) out.push_back(std::move(*p));
}

}  // namespace kt
