// Tetrahedral finite elements of a hyperelastic material:  f = -sum over points V P(F) grad N - damping + M g.
// Total Lagrangian: F = sum x_a grad N_a with rest gradients; Bonet and Wood, "Nonlinear Continuum Mechanics", 2008.
#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/body/refinable.hpp"
#include "models/embedded_model.hpp"
#include "models/fem/batches.hpp"
#include "models/fem/material.hpp"
#include "models/fem/viscosity.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

template <int N>
class FemModel final : public DeformableModel, public Refinable {
 public:
  /// @param factors  of the elements' stiffness and damping; empty: 1. Every material is proportional to young.
  FemModel(const ElementTable<N>& elements, const std::vector<double>& factors, std::vector<int> fixed,
           const ModelOptions& options)
      : mesh_(elements.mesh),
        nodes_(elements.nodes),
        options_(options),
        material_(make_material(options.material, lame(options.young, options.poisson))),
        viscosity_(lame(options.young, options.poisson), options.damping_stiffness,
                   !options.rayleigh && material_->is_frame_indifferent()),
        pattern_(mesh_.num_nodes(), elements.nodes),
        batches_(elements, pattern_, factors),
        stiffened_(num_stiffened(factors)) {
    options_.fixed_nodes = std::move(fixed);
    make_mass(elements);
  }

  const Mesh& mesh() const override { return mesh_; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return options_.fixed_nodes; }

  void force(const State& state, VectorX& out) const override {
    out = weight_;
    if (options_.damping_mass > 0) out.noalias() -= options_.damping_mass * (mass_ * state.v);
    batches_.for_each([&](const Batch<N>& batch, std::span<const Point> points) {
      std::array<LaneVec3, N> f;
      find_forces(*this, state, batch, points, f);
      for (int lane = 0; lane < batch.count; ++lane)
        for (int a = 0; a < N; ++a) node(out, batch.nodes[lane][a]) += get_lane(f[a], lane);
    });
  }

  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    const bool definite = kind == TangentKind::definite;
    // The turning of the viscous stress, which is not symmetric, is left out when definite.
    const bool turns = !definite && !viscosity_.is_symmetric(), symmetric = !turns || kind == TangentKind::symmetric;
    pattern_.start(out.dfdx, symmetric);
    if (viscosity_.is_active())
      pattern_.start(out.dfdv, true);
    else
      set_zero(out.dfdv, is_damped() ? pattern_.zero() : undamped_);
    batches_.for_each([&](const Batch<N>& batch, std::span<const Point> points) {
      add_batch(*this, {state, definite, turns, symmetric, batch, points, out});
    });
    pattern_.finish(out.dfdx, symmetric);
    if (viscosity_.is_active()) pattern_.finish(out.dfdv, true);
    if (options_.damping_mass > 0) {
      double* values = out.dfdv.valuePtr();
      for (std::size_t i = 0; i < mass_slots_.size(); ++i)
        values[mass_slots_[i]] -= options_.damping_mass * mass_.valuePtr()[i];
    }
  }

  std::span<const int> cell_nodes(int cell) const override { return nodes_[cell]; }
  Moduli moduli(TangentKind kind, const Mat3& F, const Mat3& rate) const override {
    if (kind == TangentKind::definite) return material_->definite_tangent(F);
    return material_->tangent(F) + viscosity_.shape_tangent(F, rate);
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
             {"nodes_per_element", N},
             {"elements", static_cast<double>(mesh_.tetrahedra.size())},
             {"stiffened_elements", stiffened_}}};
  }

 private:
  using Point = typename Batch<N>::Point;
  using Edges = std::array<LaneVec3, N - 1>;  // from node 0 to the others
  using Blocks = std::array<LaneMat3, num_pairs(N)>;

  KT_LANES static void find_forces(const FemModel& model, const State& state, const Batch<N>& batch,
                                   std::span<const Point> points, std::array<LaneVec3, N>& f) {
    const Viscosity& viscosity = model.viscosity_;
    const Edges x = edges(state.x, batch);
    Edges v;
    if (viscosity.is_active()) v = edges(state.v, batch);
    f.fill(LaneVec3::Zero());
    for (const Point& point : points) {
      const LaneMat3 F = gradient(x, point);
      LaneMat3 P = model.material_->lane_stress(F);
      if (viscosity.is_active()) P += viscosity.stress(F, gradient(v, point));
      P *= -point.volume;
      for (int a = 1; a < N; ++a) f[a] += P * point.g[a];
    }
    for (int a = 1; a < N; ++a) f[0] -= f[a];
  }

  struct BatchTangent {
    const State& state;
    bool definite, turns, symmetric;
    const Batch<N>& batch;
    std::span<const Point> points;
    Tangent& out;
  };
  KT_LANES static void add_batch(const FemModel& model, const BatchTangent& b) {
    const Viscosity& viscosity = model.viscosity_;
    prefetch(b.out.dfdx, b.batch);
    const Edges x = edges(b.state.x, b.batch);
    Blocks k;
    k.fill(LaneMat3::Zero());
    for (const Point& point : b.points)
      model.material_->add_lane_stiffness(gradient(x, point), b.definite, point.g, -point.volume, k);
    Blocks transposed;
    if (b.turns) transposed = k;
    if (viscosity.is_active()) {
      Blocks d;
      d.fill(LaneMat3::Zero());
      const Edges v = edges(b.state.v, b.batch);
      for (const Point& point : b.points) {
        const LaneMat3 F = gradient(x, point);
        viscosity.add_rate_blocks(F, point.g, -point.volume, d);
        if (b.turns) viscosity.add_shape_blocks(F, gradient(v, point), point.g, -point.volume, k, transposed);
      }
      add_above(b.out.dfdv, b.batch, d);
    }
    if (b.turns && b.symmetric)
      for (std::size_t pair = 0; pair < k.size(); ++pair) k[pair] = (k[pair] + transposed[pair]) * Lanes(0.5);
    add_above(b.out.dfdx, b.batch, k);
    if (!b.symmetric) model.add_below(b.out.dfdx, b.batch, transposed);
  }

  bool is_damped() const { return options_.damping_mass > 0 || viscosity_.is_active(); }

  static Edges edges(const VectorX& stacked, const Batch<N>& batch) {
    Edges out;
    for (int lane = 0; lane < Lanes::kCount; ++lane) {
      const Vec3 first = node(stacked, batch.nodes[lane][0]);
      for (int a = 1; a < N; ++a) set_lane(out[a - 1], lane, Vec3(node(stacked, batch.nodes[lane][a]) - first));
    }
    return out;
  }

  /// sum x_a grad N_a, with the gradients' sum zero.
  static LaneMat3 gradient(const Edges& edges, const Point& point) {
    LaneMat3 out = edges[0] * point.g[1].transpose();
    for (int a = 2; a < N; ++a) out += edges[a - 1] * point.g[a].transpose();
    return out;
  }

  /// Where the blocks will be added comes from far while they are computed.
  static void prefetch(SparseMatrix& sum, const Batch<N>& batch) {
    for (const auto& blocks : batch.blocks)
      for (int block : blocks) {
        const double* at = BlockPattern::values_of(sum, block);
        __builtin_prefetch(at, 1);
        __builtin_prefetch(at + 8, 1);
      }
  }
  /// Adds the blocks of pairs (a, b), above the diagonal.
  static void add_above(SparseMatrix& sum, const Batch<N>& batch, const Blocks& blocks) {
    std::array<double, 9> nowhere{};
    for (std::size_t pair = 0; pair < blocks.size(); ++pair) {
      std::array<double*, Lanes::kCount> to;
      for (int lane = 0; lane < Lanes::kCount; ++lane)
        to[lane] = lane < batch.count ? BlockPattern::values_of(sum, batch.blocks[lane][pair]) : nowhere.data();
      add_to(to, blocks[pair]);
    }
  }
  /// Adds the blocks of pairs (b, a), given transposed, below it.
  void add_below(SparseMatrix& sum, const Batch<N>& batch, const Blocks& transposed) const {
    for (std::size_t pair = 0; pair < transposed.size(); ++pair)
      for (int lane = 0; lane < batch.count; ++lane)
        Eigen::Map<Mat3>(BlockPattern::values_of(sum, pattern_.mirrored(batch.blocks[lane][pair]))) +=
            get_lane(transposed[pair], lane).transpose();
  }

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
  std::unique_ptr<Material> material_;
  Viscosity viscosity_;
  BlockPattern pattern_;
  Batches<N> batches_;
  int stiffened_ = 0;  // elements in inclusions
  SparseMatrix mass_, undamped_{pattern_.zero().rows(), pattern_.zero().cols()};
  std::vector<int> mass_slots_;  // of its entries in the pattern
  VectorX weight_;               // [N]
};

/// Cells that are only partly material have their share of stiffness, damping and mass.
std::unique_ptr<DeformableModel> make_embedded_fem(Mesh mesh, const ModelOptions& options) {
  const EmbeddedSurface& surface = *mesh.embedded;
  if ((options.element == "tet10") != surface.is_quadratic())
    throw InputError(text("object.model.element \"", options.element, "\": the cells of the lattice have ",
                          surface.is_quadratic() ? "ten nodes: set it to tet10" : "four nodes: set it to tet4"));
  const std::vector<double> factors = stiffness_factors(mesh, options.inclusions);
  std::vector<int> clamped = own_fixed_nodes(mesh, options.fixed_nodes);
  std::unique_ptr<DeformableModel> cells;
  if (surface.is_quadratic())
    cells = std::make_unique<FemModel<10>>(make_embedded_quadratic_elements(without_embedded(mesh), surface), factors,
                                           std::move(clamped), options);
  else
    cells = std::make_unique<FemModel<4>>(make_embedded_linear_elements(without_embedded(mesh), surface), factors,
                                          std::move(clamped), options);
  return embed_surface(std::move(mesh), std::move(cells));
}

}  // namespace

std::unique_ptr<DeformableModel> make_fem_model(Mesh mesh, const ModelOptions& options) {
  if (mesh.tetrahedra.empty())
    throw InputError("object.model.type \"fem\" needs tetrahedra: give a solid mesh, or object.tetrahedralize");
  if (options.element != "tet4" && options.element != "tet10")
    throw_unknown("object.model.element", options.element, {"tet4", "tet10"});
  if (mesh.embedded) return make_embedded_fem(std::move(mesh), options);
  const std::vector<double> factors = stiffness_factors(mesh, options.inclusions);
  if (options.element == "tet10") {
    ElementTable<10> elements = make_quadratic_elements(mesh);
    std::vector<int> fixed = fixed_with_edges(elements, options.fixed_nodes);
    return std::make_unique<FemModel<10>>(elements, factors, std::move(fixed), options);
  }
  return std::make_unique<FemModel<4>>(make_linear_elements(std::move(mesh)), factors, options.fixed_nodes, options);
}

}  // namespace kt
