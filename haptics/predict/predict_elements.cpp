#include "haptics/predict/predict_elements.hpp"

#include <limits>

#include "haptics/body/bending.hpp"
#include "haptics/cost/force_factor.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {

namespace {

/// Of a lattice.
std::optional<Prediction> predict_bending(const std::string& element, double cells, double poisson) {
  if (element == "tet10") return {};
  const bool are_cubes = element == "hex8";
  const double factor = are_cubes ? hex8_stiffening(cells) : tet4_stiffening(cells, 0.5 - poisson);
  if (factor < kMostStiffening) return {};
  Finding found{told("object.body lattice at object.model.poisson ", poisson, " with ", cells,
                     " cells across the body bends at least ", factor, " times too little (limit ", kMostStiffening,
                     ")")};
  if (!are_cubes) found.cures.push_back(set_to("object.model.element", "hex8", "as many nodes"));
  if (are_cubes || hex8_stiffening(cells) >= kMostStiffening)
    found.cures.push_back(advise("set object.lattice.nodes higher"));
  return Prediction{"poisson", std::move(found).at("object.body", factor, kMostStiffening)};
}

}  // namespace

std::optional<Prediction> predict_locking(const DeformableModel& model, const std::string& element, double poisson) {
  const ModelInfo info = model.info();
  const double cells = cells_across(model.mesh());
  if (!(cells > 0)) return {};
  if (info.type == "fem" && model.mesh().embedded) return predict_bending(element, cells, poisson);
  if (info.type == "fem" && element == "tet4") {
    const double factor = tet4_stiffening(cells, 0.5 - poisson);
    if (factor < kMostStiffening) return {};
    return Prediction{"poisson", Finding{told("object.model.element tet4 at object.model.poisson ", poisson, " with ",
                                              cells, " elements across the body bends about ", factor,
                                              " times too little (limit ", kMostStiffening, ")"),
                                         {set_to("object.model.element", "tet10", "about eight times the nodes"),
                                          advise("refine the mesh")}}
                                     .at("object.model.element", factor, kMostStiffening)};
  }
  if (!info.parameters.contains("calibration_residual")) return {};  // its springs mean no material
  const double factor = spring_stiffening(cells, 0.5 - poisson);
  if (factor < kMostStiffening) return {};
  // Elements of four nodes, on the same mesh. In a lattice auto takes cubes then.
  const bool locks = !model.mesh().embedded && tet4_stiffening(cells, 0.5 - poisson) >= kMostStiffening;
  return Prediction{"poisson", Finding{told("object.model.type msd at object.model.poisson ", poisson, " with ", cells,
                                            " springs across the body is about ", factor, " times too stiff (limit ",
                                            kMostStiffening, "): springs have a Poisson ratio of their own, near 1/4"),
                                       {set_to("object.model.poisson", "0.3"),
                                        locks ? advise("set object.model.type to fem and object.model.element to tet10")
                                              : set_to("object.model.type", "fem")}}
                                   .at("object.model.type", factor, kMostStiffening)};
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
  const std::string element = fitted_element(built.model().info());
  if (auto p = predict_locking(built.model(), element, built.scene().object.model.poisson))
    out.push_back(std::move(*p));
}

}  // namespace kt
