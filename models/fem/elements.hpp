#pragma once
// The forces and the stiffness of all elements of N nodes, of one material.
#include <array>
#include <memory>
#include <span>

#include "core/body/deformable_model.hpp"
#include "core/body/state.hpp"
#include "models/fem/batches.hpp"
#include "models/fem/material.hpp"
#include "models/fem/viscosity.hpp"

namespace kt {

/// What elements are made of.
struct Continuum {
  std::unique_ptr<Material> material;
  Viscosity viscosity;

  /// The turning of the viscous stress, which is not symmetric, is left out when definite.
  bool turns(TangentKind kind) const { return kind != TangentKind::definite && !viscosity.is_symmetric(); }
  bool is_symmetric(TangentKind kind) const { return !turns(kind) || kind == TangentKind::symmetric; }
};

template <int N>
class Elements {
 public:
  /// @param factors  of the elements' stress and damping; empty: 1
  Elements(Continuum continuum, const ElementTable<N>& table, const BlockPattern& pattern,
           const std::vector<double>& factors)
      : continuum_(std::move(continuum)), batches_(table, pattern, factors) {}

  const Continuum& continuum() const { return continuum_; }

  void add_force(const State& state, VectorX& out) const {
    batches_.for_each([&](const Batch<N>& batch, std::span<const Point> points) {
      std::array<LaneVec3, N> f;
      find_forces(continuum_, state, batch, points, f);
      for (int lane = 0; lane < batch.count; ++lane)
        for (int a = 0; a < N; ++a) node(out, batch.nodes[lane][a]) += get_lane(f[a], lane);
    });
  }

  /// Between BlockPattern's start() and finish(): of dfdv above the diagonal, of dfdx where it is symmetric.
  void add_tangent(const BlockPattern& pattern, const State& state, TangentKind kind, Tangent& out) const {
    const Wanted wanted{continuum_,
                        pattern,
                        state,
                        kind == TangentKind::definite,
                        continuum_.turns(kind),
                        continuum_.is_symmetric(kind)};
    batches_.for_each(
        [&](const Batch<N>& batch, std::span<const Point> points) { add_batch(wanted, batch, points, out); });
  }

 private:
  using Point = typename Batch<N>::Point;
  using Edges = std::array<LaneVec3, N - 1>;  // from node 0 to the others
  using Blocks = std::array<LaneMat3, num_pairs(N)>;

  struct Wanted {
    const Continuum& continuum;
    const BlockPattern& pattern;
    const State& state;
    bool definite, turns, symmetric;
  };

  KT_LANES static void find_forces(const Continuum& continuum, const State& state, const Batch<N>& batch,
                                   std::span<const Point> points, std::array<LaneVec3, N>& f) {
    const Viscosity& viscosity = continuum.viscosity;
    const Edges x = edges(state.x, batch);
    Edges v;
    if (viscosity.is_active()) v = edges(state.v, batch);
    f.fill(LaneVec3::Zero());
    for (const Point& point : points) {
      const LaneMat3 F = gradient(x, point);
      LaneMat3 P = continuum.material->lane_stress(F);
      if (viscosity.is_active()) P += viscosity.stress(F, gradient(v, point));
      P *= -point.volume;
      for (int a = 1; a < N; ++a) f[a] += P * point.g[a];
    }
    for (int a = 1; a < N; ++a) f[0] -= f[a];
  }

  KT_LANES static void add_batch(const Wanted& wanted, const Batch<N>& batch, std::span<const Point> points,
                                 Tangent& out) {
    const Continuum& continuum = wanted.continuum;
    const Viscosity& viscosity = continuum.viscosity;
    prefetch(out.dfdx, batch);
    const Edges x = edges(wanted.state.x, batch);
    Blocks k;
    k.fill(LaneMat3::Zero());
    for (const Point& point : points)
      continuum.material->add_lane_stiffness(gradient(x, point), wanted.definite, point.g, -point.volume, k);
    Blocks transposed;
    if (wanted.turns) transposed = k;
    if (viscosity.is_active()) {
      Blocks d;
      d.fill(LaneMat3::Zero());
      const Edges v = edges(wanted.state.v, batch);
      for (const Point& point : points) {
        const LaneMat3 F = gradient(x, point);
        viscosity.add_rate_blocks(F, point.g, -point.volume, d);
        if (wanted.turns) viscosity.add_shape_blocks(F, gradient(v, point), point.g, -point.volume, k, transposed);
      }
      add_above(out.dfdv, batch, d);
    }
    if (wanted.turns && wanted.symmetric)
      for (std::size_t pair = 0; pair < k.size(); ++pair) k[pair] = (k[pair] + transposed[pair]) * Lanes(0.5);
    add_above(out.dfdx, batch, k);
    if (!wanted.symmetric) add_below(out.dfdx, batch, wanted.pattern, transposed);
  }

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
  static void add_below(SparseMatrix& sum, const Batch<N>& batch, const BlockPattern& pattern,
                        const Blocks& transposed) {
    for (std::size_t pair = 0; pair < transposed.size(); ++pair)
      for (int lane = 0; lane < batch.count; ++lane)
        Eigen::Map<Mat3>(BlockPattern::values_of(sum, pattern.mirrored(batch.blocks[lane][pair]))) +=
            get_lane(transposed[pair], lane).transpose();
  }

  Continuum continuum_;
  Batches<N> batches_;
};

}  // namespace kt
