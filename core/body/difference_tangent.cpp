#include "core/body/difference_tangent.hpp"

#include <cmath>
#include <limits>

#include "core/linear/sparse_solver.hpp"

namespace kt {
namespace {

constexpr double kStep = 6e-6;       // of a node's shortest edge: the cube root of the rounding of a double
constexpr double kSpeedStep = 1e-3;  // edges a second
constexpr double kNearlyDefinite = 1e-8;

using Neighbours = std::vector<std::vector<int>>;

/// Of every node: those that it shares an element with, itself among them, ascending.
Neighbours find_neighbours(const Mesh& mesh) {
  Neighbours out(static_cast<std::size_t>(mesh.num_nodes()));
  const auto connect = [&](const auto& element) {
    for (int i : element) out[i].insert(out[i].end(), element.begin(), element.end());
  };
  for (int i = 0; i < mesh.num_nodes(); ++i) out[i].push_back(i);
  for (const Tetrahedron& t : mesh.tetrahedra) connect(t);
  if (mesh.tetrahedra.empty())
    for (const Triangle& t : mesh.triangles) connect(t);
  for (std::vector<int>& list : out) {
    std::ranges::sort(list);
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return out;
}

/// Nodes by colour: no two of one colour have a neighbour in common.
std::vector<std::vector<int>> colour(const Neighbours& neighbours) {
  std::vector<std::vector<int>> out;
  std::vector<int> colour_of(neighbours.size(), -1), taken_by;
  for (int i = 0; i < static_cast<int>(neighbours.size()); ++i) {
    for (int near : neighbours[i])
      for (int other : neighbours[near])
        if (colour_of[other] >= 0) taken_by[colour_of[other]] = i;
    std::size_t c = 0;
    while (c < out.size() && taken_by[c] == i) ++c;
    if (c == out.size()) {
      out.emplace_back();
      taken_by.push_back(-1);
    }
    out[c].push_back(i);
    colour_of[i] = static_cast<int>(c);
  }
  return out;
}

/// A matrix with a 3 x 3 block of zeros for each pair of neighbours.
SparseMatrix pattern_of(const Neighbours& neighbours) {
  SparseMatrix out(3 * static_cast<Eigen::Index>(neighbours.size()), 3 * static_cast<Eigen::Index>(neighbours.size()));
  VectorX entries(out.cols());
  for (Eigen::Index column = 0; column < out.cols(); ++column)
    entries[column] = 3 * static_cast<double>(neighbours[static_cast<std::size_t>(column / 3)].size());
  out.reserve(entries.cast<int>());
  for (int column = 0; column < static_cast<int>(out.cols()); ++column)
    for (int near : neighbours[column / 3])
      for (int c = 0; c < 3; ++c) out.insert(3 * near + c, column) = 0;
  out.makeCompressed();
  return out;
}

/// Differences of the force for steps of one field of the state, x or v.
void differentiate(const DeformableModel& model, State state, VectorX State::*field, const VectorX& steps,
                   const Neighbours& neighbours, const std::vector<std::vector<int>>& colours, SparseMatrix& out) {
  VectorX& moved = state.*field;
  const VectorX start = moved;
  VectorX ahead, behind;
  for (const std::vector<int>& nodes : colours)
    for (int c = 0; c < 3; ++c) {
      for (int i : nodes) moved[3 * i + c] = start[3 * i + c] + steps[i];
      model.force(state, ahead);
      for (int i : nodes) moved[3 * i + c] = start[3 * i + c] - steps[i];
      model.force(state, behind);
      for (int i : nodes) {
        moved[3 * i + c] = start[3 * i + c];
        double* entry = out.valuePtr() + out.outerIndexPtr()[3 * i + c];
        for (int near : neighbours[i])
          for (int row = 3 * near; row < 3 * near + 3; ++row) *entry++ = (ahead[row] - behind[row]) / (2 * steps[i]);
      }
    }
}

void make_symmetric(SparseMatrix& matrix) {
  const SparseMatrix transposed = matrix.transpose();
  matrix = 0.5 * (matrix + transposed);
}

/// Takes as much of the identity off the symmetric matrix as makes its negative positive definite.
void make_negative_definite(SparseMatrix& matrix) {
  const double largest = VectorX(matrix.diagonal()).cwiseAbs().maxCoeff();
  if (!(largest > 0) || !std::isfinite(largest)) return;  // without resistance anywhere: nothing to measure it by
  const auto solver = make_sparse_solver();
  SparseMatrix identity(matrix.rows(), matrix.cols());
  identity.setIdentity();
  for (double shift = kNearlyDefinite * largest; shift < 1e3 * largest; shift *= 4) {
    const SparseMatrix shifted = shift * identity - matrix;
    if (!solver->factor(shifted)) continue;
    if (shift > kNearlyDefinite * largest) matrix -= shift * identity;
    return;
  }
}

}  // namespace

VectorX shortest_edges(const Mesh& mesh) {
  const Neighbours neighbours = find_neighbours(mesh);
  const double size = std::max(bounds(mesh).size().norm(), std::numeric_limits<double>::min());
  VectorX out = VectorX::Constant(mesh.num_nodes(), size);
  for (int i = 0; i < mesh.num_nodes(); ++i)
    for (int other : neighbours[i]) {
      const double length = (node(mesh.x, i) - node(mesh.x, other)).norm();
      if (length > 1e-9 * size) out[i] = std::min(out[i], length);
    }
  return out;
}

void difference_tangent(const DeformableModel& model, const State& state, TangentKind kind, Tangent& out) {
  const Neighbours neighbours = find_neighbours(model.mesh());
  const std::vector<std::vector<int>> colours = colour(neighbours);
  const VectorX edges = shortest_edges(model.mesh());
  out.dfdx = out.dfdv = pattern_of(neighbours);
  differentiate(model, state, &State::x, kStep * edges, neighbours, colours, out.dfdx);
  differentiate(model, state, &State::v, kSpeedStep * edges, neighbours, colours, out.dfdv);
  if (kind == TangentKind::exact) return;
  for (SparseMatrix* matrix : {&out.dfdx, &out.dfdv}) {
    make_symmetric(*matrix);
    if (kind == TangentKind::definite) make_negative_definite(*matrix);
  }
}

}  // namespace kt
