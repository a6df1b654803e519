#include "models/inclusions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr double kMostStiffer = 1e6;  // beyond, the systems of a step are no longer solved to their digits

std::string shown(const Vec3& v) { return text("(", v.x(), ", ", v.y(), ", ", v.z(), ")"); }

template <class Cell>
std::vector<Vec3> centroids(const VectorX& x, const std::vector<Cell>& cells) {
  std::vector<Vec3> out;
  out.reserve(cells.size());
  for (const Cell& cell : cells) {
    Vec3 sum = Vec3::Zero();
    for (int i : cell) sum += node(x, i);
    out.push_back(sum / static_cast<double>(cell.size()));
  }
  return out;
}

void check(const Inclusion& in, const std::string& key) {
  if (!in.center.allFinite())
    throw InputError(text(key, ".center = ", shown(in.center), ": must be three finite numbers [m]"));
  if (!(in.radius > 0) || !std::isfinite(in.radius))
    throw InputError(text(key, ".radius = ", in.radius, ": must be a finite number > 0 [m]"));
  if (!(in.stiffer > 0) || !(in.stiffer <= kMostStiffer))
    throw InputError(text(key, ".stiffer = ", in.stiffer, ": must be a number > 0, at most ", kMostStiffer));
}

[[noreturn]] void refuse_empty(const Mesh& mesh, const Inclusion& in, const std::string& key, double nearest) {
  const Bounds box = bounds(mesh);
  throw InputError(text(key, ": the ball around ", shown(in.center), " of radius ", in.radius,
                        " m holds the middle of no element: the nearest is ", nearest,
                        " m from its center, the mesh is ", shown(box.min), " to ", shown(box.max),
                        " m; move or enlarge it, or refine the mesh"));
}

}  // namespace

std::vector<double> stiffness_factors(const Mesh& mesh, const std::vector<Inclusion>& inclusions) {
  if (inclusions.empty()) return {};
  const std::vector<Vec3> middle =
      mesh.tetrahedra.empty() ? centroids(mesh.x, mesh.triangles) : centroids(mesh.x, mesh.tetrahedra);
  std::vector<double> out(middle.size(), 1);
  for (std::size_t i = 0; i < inclusions.size(); ++i) {
    const Inclusion& in = inclusions[i];
    const std::string key = text("object.model.inclusions[", i, "]");
    check(in, key);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t e = 0; e < middle.size(); ++e) {
      const double distance = (middle[e] - in.center).norm();
      nearest = std::min(nearest, distance);
      if (distance <= in.radius) out[e] = in.stiffer;
    }
    if (nearest > in.radius) refuse_empty(mesh, in, key, nearest);
  }
  return out;
}

int num_stiffened(const std::vector<double>& factors) {
  return static_cast<int>(std::count_if(factors.begin(), factors.end(), [](double f) { return f != 1; }));
}

}  // namespace kt
