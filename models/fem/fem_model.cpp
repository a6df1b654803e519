// Tetrahedral finite elements of a hyperelastic material:  f = -sum over points V P(F) grad N - damping + M g.
// Total Lagrangian: F = sum x_a grad N_a with rest gradients; Bonet and Wood, "Nonlinear Continuum Mechanics", 2008.
#include <span>

#include "core/error.hpp"
#include "models/fem/block_pattern.hpp"
#include "models/fem/element.hpp"
#include "models/fem/material.hpp"
#include "models/fem/slabs.hpp"
#include "models/fem/viscosity.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

template <int N>
class FemModel final : public DeformableModel {
 public:
  FemModel(ElementTable<N> elements, std::vector<int> fixed, const ModelOptions& options)
      : elements_(std::move(elements)),
        options_(options),
        material_(make_material(options.material, lame(options.young, options.poisson))),
        viscosity_(lame(options.young, options.poisson), options.damping_stiffness,
                   !options.rayleigh && material_->is_frame_indifferent()),
        slabs_(make_slabs<N>(elements_.mesh.num_nodes(), elements_.nodes)),
        pattern_(elements_.mesh.num_nodes(), elements_.nodes) {
    options_.fixed_nodes = std::move(fixed);
    make_mass();
  }

  const Mesh& mesh() const override { return elements_.mesh; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return options_.fixed_nodes; }

  void force(const State& state, VectorX& out) const override {
    out = weight_;
    if (options_.damping_mass > 0) out.noalias() -= options_.damping_mass * (mass_ * state.v);
    for_each_element(slabs_, [&](std::size_t e) {
      const Corners x = corners(state.x, e);
      Corners f = Corners::Zero();
      for (const auto& point : points_of(e)) {
        const Mat3 F = x * point.gradient.transpose();
        Mat3 P = material_->stress(F);
        if (viscosity_.is_active()) P += viscosity_.stress(F, corners(state.v, e) * point.gradient.transpose());
        f.noalias() -= (point.volume * P) * point.gradient;
      }
      for (int a = 0; a < N; ++a) node(out, elements_.nodes[e][a]) += f.col(a);
    });
  }

  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    set_zero(out.dfdx, pattern_.zero());
    set_zero(out.dfdv, is_damped() ? pattern_.zero() : undamped_);
    const bool definite = kind == TangentKind::definite;
    for_each_element(slabs_, [&](std::size_t e) {
      const Corners x = corners(state.x, e);
      Blocks k = Blocks::Zero(), d = Blocks::Zero();
      for (const auto& point : points_of(e)) {
        const Mat3 F = x * point.gradient.transpose();
        material_->add_stiffness(F, definite, point.gradient, -point.volume, k);
        if (!viscosity_.is_active()) continue;
        add_contracted(viscosity_.tangent_of_rate(F), point.gradient, -point.volume, d);
        if (definite) continue;  // the stress that turns with the element is not symmetric: left out
        const Mat3 rate = corners(state.v, e) * point.gradient.transpose();
        add_contracted(viscosity_.tangent_of_shape(F, rate), point.gradient, -point.volume, k);
      }
      pattern_.add(out.dfdx, e, k);
      if (viscosity_.is_active()) pattern_.add(out.dfdv, e, d);
    });
    if (options_.damping_mass > 0) {
      double* values = out.dfdv.valuePtr();
      for (std::size_t i = 0; i < mass_slots_.size(); ++i)
        values[mass_slots_[i]] -= options_.damping_mass * mass_.valuePtr()[i];
    }
  }

  ModelInfo info() const override {
    return {"fem",
            options_.material,
            {{"young", options_.young},
             {"poisson", options_.poisson},
             {"density", options_.density},
             {"damping_mass", options_.damping_mass},
             {"damping_stiffness", options_.damping_stiffness},
             {"nodes_per_element", N},
             {"elements", static_cast<double>(elements_.nodes.size())}}};
  }

 private:
  using Corners = Eigen::Matrix<double, 3, N>;
  using Blocks = Eigen::Matrix<double, 3 * N, 3 * N>;
  using Point = typename ElementTable<N>::Point;

  bool is_damped() const { return options_.damping_mass > 0 || viscosity_.is_active(); }

  std::span<const Point> points_of(std::size_t e) const {
    const auto n = static_cast<std::size_t>(elements_.points_per_element);
    return {elements_.points.data() + e * n, n};
  }

  Corners corners(const VectorX& stacked, std::size_t e) const {
    Corners out;
    for (int a = 0; a < N; ++a) out.col(a) = node(stacked, elements_.nodes[e][a]);
    return out;
  }

  void make_mass() {
    const Eigen::Matrix<double, N, N> shares = mass_shares<N>(!options_.consistent_mass);
    mass_ = pattern_.zero();
    for (std::size_t e = 0; e < elements_.nodes.size(); ++e) {
      double volume = 0;
      for (const Point& point : points_of(e)) volume += point.volume;
      Blocks m = Blocks::Zero();
      for (int a = 0; a < N; ++a)
        for (int b = 0; b < N; ++b)
          m.template block<3, 3>(3 * a, 3 * b).diagonal().setConstant(options_.density * volume * shares(a, b));
      pattern_.add(mass_, e, m);
    }
    const auto is_mass = [](int row, int column, double value) { return row == column || value != 0; };
    for (int c = 0; c < mass_.outerSize(); ++c)
      for (int k = mass_.outerIndexPtr()[c]; k < mass_.outerIndexPtr()[c + 1]; ++k)
        if (is_mass(mass_.innerIndexPtr()[k], c, mass_.valuePtr()[k])) mass_slots_.push_back(k);
    mass_.prune(is_mass);
    const VectorX diagonal = mass_.diagonal();
    for (int i = 0; i < elements_.mesh.num_nodes(); ++i)
      if (!(diagonal[3 * i] > 0))
        throw InputError(text("fem: node ", i, " belongs to no element and would have no mass"));
    weight_ = mass_ * options_.gravity.replicate(elements_.mesh.num_nodes(), 1);
  }

  ElementTable<N> elements_;
  ModelOptions options_;
  std::unique_ptr<Material> material_;
  Viscosity viscosity_;
  Slabs slabs_;
  BlockPattern<N> pattern_;
  SparseMatrix mass_, undamped_{pattern_.zero().rows(), pattern_.zero().cols()};
  std::vector<int> mass_slots_;  // of its entries in the pattern
  VectorX weight_;               // [N]
};

}  // namespace

std::unique_ptr<DeformableModel> make_fem_model(Mesh mesh, const ModelOptions& options) {
  if (mesh.tetrahedra.empty())
    throw InputError("object.model.type \"fem\" needs tetrahedra: give a solid mesh, or object.tetrahedralize");
  if (options.element == "tet10") {
    ElementTable<10> elements = make_quadratic_elements(mesh);
    std::vector<int> fixed = fixed_with_edges(elements, options.fixed_nodes);
    return std::make_unique<FemModel<10>>(std::move(elements), std::move(fixed), options);
  }
  if (options.element != "tet4") throw_unknown("object.model.element", options.element, {"tet4", "tet10"});
  return std::make_unique<FemModel<4>>(make_linear_elements(std::move(mesh)), options.fixed_nodes, options);
}

}  // namespace kt
