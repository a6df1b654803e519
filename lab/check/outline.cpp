#include "lab/check/outline.hpp"

#include <map>
#include <set>

namespace kt {
namespace {

struct Clustered {
  std::vector<Vec3> nodes;
  std::set<Triangle> triangles;
};

/// Each cell's nodes become their mean.
Clustered clustered(const Mesh& mesh, const Vec3& low, double size, int cells) {
  std::map<std::array<int, 3>, int> cell_of;
  std::vector<Vec3> sum;
  std::vector<int> count, cluster(static_cast<std::size_t>(mesh.num_nodes()), -1);
  Clustered out;
  for (const Triangle& t : mesh.triangles) {
    Triangle merged{};
    for (std::size_t k = 0; k < 3; ++k) {
      int& c = cluster[static_cast<std::size_t>(t[k])];
      if (c < 0) {
        const Vec3 p = (Vec3(node(mesh.x, t[k])) - low) / size;
        const auto at = [&](int axis) { return std::clamp(static_cast<int>(p[axis] * cells), 0, cells - 1); };
        const auto [cell, fresh] = cell_of.try_emplace({at(0), at(1), at(2)}, static_cast<int>(sum.size()));
        c = cell->second;
        if (fresh) {
          sum.push_back(Vec3::Zero());
          count.push_back(0);
        }
        sum[static_cast<std::size_t>(c)] += p;
        ++count[static_cast<std::size_t>(c)];
      }
      merged[k] = c;
    }
    if (merged[0] == merged[1] || merged[1] == merged[2] || merged[2] == merged[0]) continue;
    std::rotate(merged.begin(), std::min_element(merged.begin(), merged.end()), merged.end());
    out.triangles.insert(merged);
  }
  for (std::size_t i = 0; i < sum.size(); ++i) out.nodes.push_back(sum[i] / count[i]);
  return out;
}

}  // namespace

nlohmann::ordered_json outline(const Mesh& mesh) {
  constexpr std::size_t kMost = 500;
  const Bounds box = bounds(mesh);
  const double size = box.size().maxCoeff();
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  if (mesh.triangles.empty() || !(size > 0) || !std::isfinite(size)) return out;
  Clustered c;
  for (int cells = 24; cells >= 3; cells = cells * 3 / 4) {
    c = clustered(mesh, box.min, size, cells);
    if (c.triangles.size() <= kMost) break;
  }
  out = {{"min", {box.min[0], box.min[1], box.min[2]}},
         {"size", size},
         {"x", nlohmann::ordered_json::array()},
         {"t", nlohmann::ordered_json::array()}};
  for (const Vec3& p : c.nodes)
    for (int k = 0; k < 3; ++k) out["x"].push_back(static_cast<int>(std::lround(255 * std::clamp(p[k], 0.0, 1.0))));
  for (const Triangle& t : c.triangles)
    for (const int i : t) out["t"].push_back(i);
  return out;
}

}  // namespace kt
