#include "core/local/fine_patch.hpp"

#include <algorithm>
#include <limits>

#include "core/body/node_weights.hpp"

namespace kt {

Mat3 triangle_frame(const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 along = (b - a).normalized(), normal = (b - a).cross(c - a).normalized();
  Mat3 out;
  out << along, normal.cross(along), normal;
  return out;
}
namespace {

/// Adds to the weight of a node that is there already; what finds no room is left out.
void add_once(NodeWeights& out, int node, double weight) noexcept {
  int* const end = out.node.data() + out.count;
  if (int* const known = std::find(out.node.data(), end, node); known != end)
    out.weight[static_cast<std::size_t>(known - out.node.data())] += weight;
  else if (out.count < NodeWeights::kMost)
    out.add(node, weight);
}

NodeWeights combine(const Triangle& facet, const Vec3& bary, const std::vector<int>& first,
                    const std::vector<int>& node, const std::vector<double>& weight) noexcept {
  NodeWeights out;
  for (int c = 0; c < 3; ++c)
    for (int k = first[facet[c]]; k < first[facet[c] + 1]; ++k) add_once(out, node[k], bary[c] * weight[k]);
  return out;
}

}  // namespace

std::pair<int, Vec3> FinePatch::find(const SurfacePlace& place) const noexcept {
  const auto [begin, end] = std::equal_range(triangle.begin(), triangle.end(), place.triangle);
  double best = -std::numeric_limits<double>::infinity();
  std::pair<int, Vec3> out{-1, Vec3::Zero()};
  for (auto f = begin; f != end; ++f) {
    const auto i = static_cast<int>(f - triangle.begin());
    const Vec3 bary = to_facet[i] * place.weights;
    const double least = bary.minCoeff();
    if (!(least > best)) continue;
    best = least;
    out = {i, bary};
    if (least >= 0) break;
  }
  return out;
}

NodeWeights FinePatch::moved_by(int facet, const Vec3& bary) const noexcept {
  return combine(facets[facet], bary, first, node, weight);
}

NodeWeights FinePatch::yields_with(int facet, const Vec3& bary) const noexcept {
  return combine(facets[facet], bary, first_from, from, share);
}

void carry_yield(const FinePatch* old, const VectorX& z, const FinePatch& now, VectorX& out) noexcept {
  for (int i = 0; i < now.num_yielding(); ++i) {
    const auto [facet, bary] = old ? old->find(now.yielding[i]) : std::pair{-1, Vec3(Vec3::Zero())};
    kt::node(out, i) = facet < 0 ? Vec3(Vec3::Zero()) : old->yields_with(facet, bary).of(z);
  }
}

}  // namespace kt
