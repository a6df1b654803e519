#include "haptics/cost/force_factor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/fine/fine_size.hpp"

namespace kt {
namespace {

/// factor = limit + c ratio^p. Measured: tet4 1.28, 2.02, 4.17 at ratios 0.72, 1.44, 2.89; tet10 1.10, 1.42, 1.87 at
/// 1.15, 1.92, 2.89; springs 0.82, 1.26, 2.70 at 0.72, 1.44, 2.89; hex8 1.46, 1.98, 2.48 at 1.25, 2, 3.
/// Springs have no continuum to converge to: under a small tool they give way by turning.
struct Law {
  double limit, c, p;
};

std::optional<Law> law_of(const std::string& element) {
  if (element == "msd") return Law{0.7, 0.25, 1.95};
  if (element == "tet4") return Law{1, 0.51, 1.72};
  if (element == "hex8") return Law{1, 0.35, 1.4};
  if (element == "tet10") return Law{1, 0.085, 2.2};
  return {};
}

/// A parameter that a model tells; else the value given.
double told_or(const ModelInfo& model, const char* name, double otherwise) {
  const auto found = model.parameters.find(name);
  return found == model.parameters.end() ? otherwise : found->second;
}

}  // namespace

std::string fitted_element(const ModelInfo& model) {
  if (model.type == "fem") {
    const double nodes = told_or(model, "nodes_per_element", 4);
    return nodes == 10 ? "tet10" : nodes == 8 ? "hex8" : "tet4";
  }
  return model.parameters.contains("calibration_residual") ? model.type : "";  // other springs mean no material
}

double coarse_force_factor(const std::string& element, double ratio, bool is_smooth) {
  constexpr double kSmooth = 0.18;
  const auto law = law_of(element);
  if (!law) return std::numeric_limits<double>::quiet_NaN();
  return (law->limit + law->c * std::pow(ratio, law->p)) * (is_smooth ? 1 + kSmooth * ratio : 1);
}

double ratio_of_factor(const std::string& element, double factor) {
  const auto law = law_of(element);
  return law ? std::pow(std::max(0.0, factor - law->limit) / law->c, 1 / law->p)
             : std::numeric_limits<double>::quiet_NaN();
}

double refined_force_factor(const ModelInfo& model, double fineness, bool is_lattice) {
  constexpr double kSprings = 0.79, kLinear = 0.0032, kLattice = 0.0055, kQuadratic = 0.0008, kUsual = 0.3;
  const std::string element = fitted_element(model);
  if (element == "msd") return kSprings;
  // What nearly incompressible cells cannot do grows with the bulk modulus over the shear modulus.
  const auto stiffness = [](double poisson) { return 1 / (1 - 2 * poisson); };
  const double poisson = std::clamp(told_or(model, "poisson", kUsual), kUsual, 0.499);
  const double locks = (element != "tet4" ? kQuadratic
                        : is_lattice      ? kLattice
                                          : kLinear) *
                       (stiffness(poisson) - stiffness(kUsual));
  return 1.05 + 0.01 * std::max(kLeastFineness, fineness) + locks;
}

}  // namespace kt
