#pragma once
// What the fine patches of one body are made of, found once.
#include <map>
#include <memory>

#include "core/body/cut_tetrahedron.hpp"
#include "core/body/refinable.hpp"
#include "core/body/surface.hpp"
#include "core/fine/known_depths.hpp"

namespace kt {

struct FineBody {
  const Mesh* mesh = nullptr;
  const Refinable* material = nullptr;
  std::vector<char> is_fixed;                   ///< nodes
  std::vector<std::array<int, 4>> across;       ///< of each cell: the cell across face f, opposite corner f; -1: none
  std::map<std::array<int, 2>, int> edge_node;  ///< of quadratic cells: the node between two corners (ascending)
  std::map<Triangle, int> triangle;             ///< of the surface, by its nodes (ascending); of an embedded one none
  std::unique_ptr<KnownDepths> depths;          ///< of cells that a surface cuts; null: it is embedded in none
  bool is_quadratic() const { return !edge_node.empty(); }
};

/// Borrows both.
FineBody make_fine_body(const DeformableModel& model, const Refinable& material);

/// A body whose material tells itself or is taken as isotropic.
struct RefinableBody {
  std::unique_ptr<Refinable> isotropic;  ///< of a model that tells nothing but "young" and "poisson"
  FineBody fine;
};
/// Borrows both. Throws InputError where the model tells no material.
RefinableBody make_refinable_body(const DeformableModel& model, const Surface& surface);

/// Corners of a cell's face as seen from outside, counter-clockwise; opposite corner 0, 1, 2, 3.
inline constexpr int kFaceCorners[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

inline Triangle face_of(const Tetrahedron& t, int f) {
  return {t[kFaceCorners[f][0]], t[kFaceCorners[f][1]], t[kFaceCorners[f][2]]};
}
inline Triangle ascending(Triangle t) {
  std::ranges::sort(t);
  return t;
}

}  // namespace kt
