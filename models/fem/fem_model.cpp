// Tetrahedral finite elements of a hyperelastic material:  f = -sum over points V P(F) grad N - damping + M g.
// Total Lagrangian: F = sum x_a grad N_a with rest gradients; Bonet and Wood, "Nonlinear Continuum Mechanics", 2008.
#include <algorithm>
#include <optional>

#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/body/refinable.hpp"
#include "models/embedded_model.hpp"
#include "models/fem/elements.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

/// Cubes of one gradient each, and what multiplies their stiffness; empty: 1.
struct Cubes {
  ElementTable<8> table;
  std::vector<double> factors;
  double share = 0;  ///< of the stiffness of the tetrahedra in them, which these keep (Puso and Solberg 2006)
};

/// With 0.13 plates of a cube bend as they should. With none, a cube would move in twelve ways without resisting. Thick
/// bodies bend well with more, and do not turn inside out as soon (bench/lattice_shapes_table, docs/lattice.md).
double share_of_tetrahedra(const EmbeddedSurface& surface) {
  constexpr double kThin = 0.13, kMost = 0.4, kMeanEdge = 1.26;  // of a cube's tetrahedra over its own
  return std::clamp(kThin * surface.thickness / (kMeanEdge * surface.edge), kThin, kMost);
}

/// They resist a change of volume no more than at Poisson's ratio 0.3: nearer to 1/2 they would lock.
Lame of_tetrahedra_in_cubes(const Lame& all) { return {std::min(all.lambda, 1.5 * all.mu), all.mu}; }

/// All but what the tetrahedra have: energies are linear in Lame's constants.
Lame of_cubes(const Lame& all, double share) {
  return {(all.lambda - share * of_tetrahedra_in_cubes(all).lambda) / (1 - share), all.mu};
}

/// @param factors  empty: 1
std::vector<double> times(double share, std::vector<double> factors, std::size_t count) {
  if (factors.empty()) factors.assign(count, 1.0);
  for (double& factor : factors) factor *= share;
  return factors;
}

template <int N>
class FemModel final : public DeformableModel, public Refinable {
 public:
  /// @param factors  of the elements' stiffness and damping; empty: 1. Every material is proportional to young.
  /// @param cubes    that the elements are in, where these have one gradient each
  FemModel(const ElementTable<N>& table, const std::vector<double>& factors, const std::optional<Cubes>& cubes,
           std::vector<int> fixed, const ModelOptions& options)
      : mesh_(table.mesh),
        nodes_(table.nodes),
        options_(options),
        continuum_(continuum_of(options, own_lame())),
        pattern_(cubes ? BlockPattern(mesh_.num_nodes(), cubes->table.nodes)
                       : BlockPattern(mesh_.num_nodes(), table.nodes)),
        elements_(continuum_of(options, cubes ? of_tetrahedra_in_cubes(own_lame()) : own_lame()), table, pattern_,
                  cubes ? times(cubes->share, factors, table.nodes.size()) : factors),
        num_elements_(cubes ? cubes->table.nodes.size() : table.nodes.size()),
        stiffened_(num_stiffened(factors)) {
    if (cubes)
      cubes_.emplace(continuum_of(options, of_cubes(own_lame(), cubes->share)), cubes->table, pattern_,
                     times(1 - cubes->share, cubes->factors, cubes->table.nodes.size()));
    options_.fixed_nodes = std::move(fixed);
    make_mass(table);
  }

  const Mesh& mesh() const override { return mesh_; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return options_.fixed_nodes; }

  void force(const State& state, VectorX& out) const override {
    out = weight_;
    if (options_.damping_mass > 0) out.noalias() -= options_.damping_mass * (mass_ * state.v);
    elements_.add_force(state, out);
    if (cubes_) cubes_->add_force(state, out);
  }

  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    const bool symmetric = continuum_.is_symmetric(kind), is_viscous = continuum_.viscosity.is_active();
    pattern_.start(out.dfdx, symmetric);
    if (is_viscous)
      pattern_.start(out.dfdv, true);
    else
      set_zero(out.dfdv, is_damped() ? pattern_.zero() : undamped_);
    elements_.add_tangent(pattern_, state, kind, out);
    if (cubes_) cubes_->add_tangent(pattern_, state, kind, out);
    pattern_.finish(out.dfdx, symmetric);
    if (is_viscous) pattern_.finish(out.dfdv, true);
    if (options_.damping_mass > 0) {
      double* values = out.dfdv.valuePtr();
      for (std::size_t i = 0; i < mass_slots_.size(); ++i)
        values[mass_slots_[i]] -= options_.damping_mass * mass_.valuePtr()[i];
    }
  }

  std::span<const int> cell_nodes(int cell) const override { return nodes_[cell]; }
  Moduli moduli(TangentKind kind, const Mat3& F, const Mat3& rate) const override {
    if (kind == TangentKind::definite) return continuum_.material->definite_tangent(F);
    return continuum_.material->tangent(F) + continuum_.viscosity.shape_tangent(F, rate);
  }
  double stiffness_factor(const Vec3& place) const override { return stiffness_in(options_.inclusions, place); }
  double retardation() const override { return options_.damping_stiffness; }

  ModelInfo info() const override {
    return {"fem",
            options_.material,
            {{"young", options_.young},
             {"poisson", options_.poisson},
             {"density", options_.density},
             {"damping_mass", options_.damping_mass},
             {"damping_stiffness", options_.damping_stiffness},
             {"nodes_per_element", cubes_ ? 8 : N},
             {"elements", static_cast<double>(num_elements_)},
             {"stiffened_elements", stiffened_}}};
  }

 private:
  Lame own_lame() const { return lame(options_.young, options_.poisson); }
  static Continuum continuum_of(const ModelOptions& options, const Lame& constants) {
    auto material = make_material(options.material, constants);
    const bool turns = !options.rayleigh && material->is_frame_indifferent();
    return {std::move(material), Viscosity(constants, options.damping_stiffness, turns)};
  }

  bool is_damped() const { return options_.damping_mass > 0 || continuum_.viscosity.is_active(); }

  void make_mass(const ElementTable<N>& table) {
    const Eigen::Matrix<double, N, N> shares = mass_shares<N>(!options_.consistent_mass);
    const auto points = static_cast<std::size_t>(table.points_per_element);
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t e = 0; e < table.nodes.size(); ++e) {
      double volume = 0;
      for (std::size_t q = 0; q < points; ++q) volume += table.points[points * e + q].volume;
      const auto add = [&](int a, int b, double share) {
        for (int i = 0; i < 3 && share != 0; ++i)
          entries.emplace_back(3 * table.nodes[e][a] + i, 3 * table.nodes[e][b] + i, options_.density * volume * share);
      };
      const bool has_own = !options_.consistent_mass && !table.lumped.empty();
      for (int a = 0; a < N; ++a)
        for (int b = 0; b < N; ++b)
          if (!has_own) add(a, b, shares(a, b));
      for (int a = 0; a < N && has_own; ++a) add(a, a, table.lumped[e][a]);
    }
    mass_.resize(3 * mesh_.num_nodes(), 3 * mesh_.num_nodes());
    mass_.setFromTriplets(entries.begin(), entries.end());
    const VectorX diagonal = mass_.diagonal();
    for (int i = 0; i < mesh_.num_nodes(); ++i)
      if (!(diagonal[3 * i] > 0))
        throw InputError(text("fem: node ", i, " belongs to no element and would have no mass"));
    for (int c = 0; c < mass_.outerSize(); ++c)
      for (SparseMatrix::InnerIterator it(mass_, c); it; ++it)
        mass_slots_.push_back(pattern_.slot(static_cast<int>(it.row()), c));
    weight_ = mass_ * options_.gravity.replicate(mesh_.num_nodes(), 1);
  }

  Mesh mesh_;
  std::vector<std::array<int, N>> nodes_;  // of the elements
  ModelOptions options_;
  Continuum continuum_;  // of a cell as a whole
  BlockPattern pattern_;
  Elements<N> elements_;
  std::optional<Elements<8>> cubes_;
  std::size_t num_elements_ = 0;  // cubes, or tetrahedra
  int stiffened_ = 0;             // tetrahedra in inclusions
  SparseMatrix mass_, undamped_{pattern_.zero().rows(), pattern_.zero().cols()};
  std::vector<int> mass_slots_;  // of its entries in the pattern
  VectorX weight_;               // [N]
};

/// Cells that are only partly material have their share of stiffness, damping and mass.
std::unique_ptr<DeformableModel> make_cells(const Mesh& mesh, std::vector<int> clamped, const ModelOptions& options) {
  const EmbeddedSurface& surface = *mesh.embedded;
  const std::vector<double> factors = stiffness_factors(mesh, options.inclusions);
  if (surface.is_quadratic())
    return std::make_unique<FemModel<10>>(make_embedded_quadratic_elements(without_embedded(mesh), surface), factors,
                                          std::nullopt, std::move(clamped), options);
  const ElementTable<4> table = make_embedded_linear_elements(without_embedded(mesh), surface);
  std::optional<Cubes> cubes;
  if (options.element == "hex8")
    cubes = Cubes{make_cubes(table, surface.cube), mean_of_cubes(factors, table, surface.cube),
                  share_of_tetrahedra(surface)};
  return std::make_unique<FemModel<4>>(table, factors, cubes, std::move(clamped), options);
}

std::unique_ptr<DeformableModel> make_embedded_fem(Mesh mesh, const ModelOptions& options) {
  const bool is_quadratic = mesh.embedded->is_quadratic();
  if ((options.element == "tet10") != is_quadratic)
    throw InputError(text("object.model.element \"", options.element, "\": the cells of the lattice have ",
                          is_quadratic ? "ten nodes: set it to tet10" : "no nodes between corners: set it to hex8"));
  auto cells = make_cells(mesh, own_fixed_nodes(mesh, options.fixed_nodes), options);
  return embed_surface(std::move(mesh), std::move(cells));
}

}  // namespace

std::unique_ptr<DeformableModel> make_fem_model(Mesh mesh, const ModelOptions& options) {
  if (mesh.tetrahedra.empty())
    throw InputError("object.model.type \"fem\" needs tetrahedra: give a solid mesh, or object.tetrahedralize");
  if (options.element != "tet4" && options.element != "tet10" && options.element != "hex8")
    throw_unknown("object.model.element", options.element, {"tet4", "tet10", "hex8"});
  if (mesh.embedded) return make_embedded_fem(std::move(mesh), options);
  if (options.element == "hex8")
    throw InputError(
        "object.model.element hex8: eight-node cubes are cells of object.body lattice, and this body is of "
        "tetrahedra: set object.model.element to tet4 or tet10, or object.body to lattice");
  const std::vector<double> factors = stiffness_factors(mesh, options.inclusions);
  if (options.element == "tet10") {
    ElementTable<10> elements = make_quadratic_elements(mesh);
    std::vector<int> fixed = fixed_with_edges(elements, options.fixed_nodes);
    return std::make_unique<FemModel<10>>(elements, factors, std::nullopt, std::move(fixed), options);
  }
  return std::make_unique<FemModel<4>>(make_linear_elements(std::move(mesh)), factors, std::nullopt,
                                       options.fixed_nodes, options);
}

}  // namespace kt
