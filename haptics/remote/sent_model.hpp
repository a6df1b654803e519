#pragma once
// What the hand's computer needs of a local model, and no more: the basis in whole numbers with a scale a column,
// diagonals as vectors, and where the motion stands instead of the maps that gave it. A plain value; what can be built
// from the body's surface there (topology, contact surface, apron) does not travel.
#include <cstdint>
#include <string>
#include <vector>

#include "core/fine/make_fine_patch.hpp"
#include "haptics/tick/prepared_local_model.hpp"

namespace kt {

/// Symmetric, (r x r).
struct SentMatrix {
  bool is_diagonal = true;
  std::vector<double> values;   ///< the diagonal, or the lower half by columns: all of it, or where `row` says
  std::vector<int> first, row;  ///< sparse: entries of column c are first[c] <= k < first[c+1]; dense: empty
  bool is_sparse() const { return !first.empty(); }
};

/// Entry = value * scale of its column.
struct SentBasis {
  int rows = 0, bits = 16;      ///< 8: values are within -127 .. 127, 16: within -32767 .. 32767
  std::vector<float> scale;     ///< (r)
  bool is_dense = true;         ///< all entries by columns; else those of `row` alone
  std::vector<int> first, row;  ///< sparse: entries of column c are first[c] <= k < first[c+1]
  std::vector<std::int16_t> value;
};

/// A contact that is held at the start, and the impulse that it gave in the tick before.
struct SentAnchor {
  Contact contact{};
  Vec3 impulse = Vec3::Zero();  ///< [N s]
};

/// Node positions in whole steps of their box.
struct SentPositions {
  Vec3 low = Vec3::Zero(), step = Vec3::Zero();  ///< [m]
  std::vector<std::uint16_t> at;                 ///< (3n)
};

struct SentModel {
  int frame = 0, linearized_tick = 0;
  double t = 0;                         ///< of the linearization [s]
  std::vector<int> triangles;           ///< of the patch, in the body's surface, ascending
  std::vector<int> more_nodes;          ///< recovered nodes besides the patch's
  VectorX x0;                           ///< (3 recovered) [m]
  std::vector<float> v0;                ///< (3 recovered) [m/s]
  SentBasis basis;                      ///< (3 recovered x r)
  SentMatrix mass, damping, stiffness;  ///< (r x r)
  VectorX f0, q_rate0;                  ///< (r)
  bool definite_tangent = false;
  std::string reducer;
  double certified_error = 0;  ///< NaN: not certified
  LocalScheme scheme = LocalScheme::exact;
  ContactSite site;
  std::array<Vec3, kMaxTools> places{};  ///< of the tools then [m]
  std::array<int, kMaxTools> way_out{};
  VectorX q, q_rate, du;  ///< where the motion stands; (r), (r), (3 patch)
  std::vector<SentAnchor> anchors;
  std::array<bool, kMaxTools> sliding{};
  std::array<Overlap, kMaxTools> overlap{};
  SentPositions body;                                 ///< the whole body's own nodes
  std::vector<float> unloaded;                        ///< PreparedLocalModel::unloaded
  std::optional<Friction> friction;                   ///< outside of regions; none: as at the start
  std::array<double, kMaxTools> tool_radius{-1, -1};  ///< [m]; below 0: as at the start
  std::optional<LiveMaterial> material;               ///< PreparedLocalModel::material
  std::shared_ptr<const FineOrigin> fine;  ///< the hand's computer makes the refined cells itself; null: there are none
  int dof() const { return static_cast<int>(f0.size()); }
};

/// @param basis_bits  8 or 16
SentModel pack_model(const PreparedLocalModel& model, int basis_bits);

}  // namespace kt
