#include "lab/check/stages/queries.hpp"

#include "collision/held/first_contact.hpp"
#include "lab/check/mesh_work.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

constexpr double kSamePoint = 1e-9;  // of the size
constexpr double kSameRay = 1e-6;    // of the ray: a graze is early by rounding over its slope
constexpr double kSlope = 1e-3;      // a ray that meets a face flatter than this is a graze
constexpr double kInside = 1e-9;     // weight: nearer to an edge the two need not agree on the triangle

/// Boxes of candidates grow until the nearest place is within the margin.
NearestPlace nearest_by(const TriangleIndex& index, std::span<const Triangle> triangles, const VectorX& x,
                        const Vec3& p, double size, std::span<int> scratch) {
  for (double margin = 0.01 * size; margin < 1e3 * size; margin *= 4) {
    const int found = index.candidates({p, p}, margin, scratch);
    const NearestPlace out = nearest_place(triangles, x, scratch.first(static_cast<std::size_t>(found)), p);
    if (out.triangle >= 0 && out.at.distance_sq <= margin * margin) return out;
  }
  return {};
}

/// The first crossing from the front of all triangles; `sure`: no other crossing, edge or graze is near it or before.
std::optional<double> first_crossing(std::span<const Triangle> triangles, const VectorX& x, const Vec3& a,
                                     const Vec3& b, bool& sure) {
  std::optional<double> first;
  sure = true;
  for (const Triangle& t : triangles) {
    const Vec3 corners[3] = {node(x, t[0]), node(x, t[1]), node(x, t[2])};
    double margin = 1;  // stays so where the segment is parallel to the triangle
    const auto hit = crossing_of(a, b, corners, &margin);
    if (std::abs(margin) < kInside) sure = false;
    if (!hit || !hit->from_front) continue;
    const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    if (!(std::abs(normal.dot((b - a).normalized())) > kSlope)) sure = false;
    if (!first || hit->share < *first) first = hit->share;
  }
  return first;
}

std::pair<Vec3, Vec3> bounds_of(std::span<const Triangle> triangles, const VectorX& x) {
  Vec3 low = node(x, triangles[0][0]), high = low;
  for (const Triangle& t : triangles)
    for (const int i : t) {
      low = low.cwiseMin(Vec3(node(x, i)));
      high = high.cwiseMax(Vec3(node(x, i)));
    }
  return {low, high};
}

}  // namespace

void QueryCount::add(const QueryCount& other) {
  for (const auto field :
       {&QueryCount::points, &QueryCount::rays, &QueryCount::hits, &QueryCount::wrong_points, &QueryCount::wrong_rays})
    this->*field += other.*field;
  worst_point = std::max(worst_point, other.worst_point);
  worst_ray = std::max(worst_ray, other.worst_ray);
  if (!where) where = other.where;
}

std::vector<QueryTruth> true_queries(std::span<const Triangle> triangles, const VectorX& x, int count, unsigned seed) {
  Sample sample{std::mt19937_64(seed)};
  const auto [low, high] = bounds_of(triangles, x);
  const double size = (high - low).norm();
  const auto anywhere = [&, middle = Vec3(0.5 * (low + high))] { return Vec3(middle + 0.7 * size * sample.cube()); };
  const auto on_surface = [&] {
    const Triangle& t = triangles[sample.random() % triangles.size()];
    const double u = sample.uniform(0, 1), v = sample.uniform(0, 1 - u);
    return Vec3((1 - u - v) * node(x, t[0]) + u * node(x, t[1]) + v * node(x, t[2]));
  };
  std::vector<QueryTruth> out;
  for (int i = 0; i < count; ++i) {
    QueryTruth one;
    one.point = i % 2 ? anywhere() : Vec3(on_surface() + 0.02 * size * sample.cube());
    one.distance = std::sqrt(nearest_place(triangles, x, one.point).at.distance_sq);
    one.from = anywhere();
    one.to = one.from + 1.3 * (on_surface() - one.from);
    one.crossing = first_crossing(triangles, x, one.from, one.to, one.sure);
    out.push_back(one);
  }
  return out;
}

QueryCount judge_queries(std::span<const Triangle> triangles, const VectorX& x, const TriangleIndex& index,
                         std::span<const QueryTruth> truths) {
  std::vector<int> scratch(triangles.size());
  const auto [low, high] = bounds_of(triangles, x);
  const double size = (high - low).norm();
  QueryCount out;
  for (const QueryTruth& truth : truths) {
    const NearestPlace found = nearest_by(index, triangles, x, truth.point, size, scratch);
    ++out.points;
    const double more = found.triangle < 0 ? size : std::sqrt(found.at.distance_sq) - truth.distance;
    out.worst_point = std::max(out.worst_point, more / size);
    if (more > kSamePoint * size) {
      ++out.wrong_points;
      if (!out.where) out.where = truth.point;
    }

    ++out.rays;
    if (!truth.sure) continue;  // no verdict: the engine may take either triangle at an edge, and err early at a graze
    const MovingTriangles still{triangles, x, x};
    const auto hit = find_first_contact(index, still, {ToolShape::Kind::point, 0}, {truth.from, truth.to}, {}, scratch);
    out.hits += truth.crossing.has_value();
    const double off = truth.crossing && hit                           ? std::abs(hit->toi - *truth.crossing)
                       : truth.crossing.has_value() != hit.has_value() ? 1
                                                                       : 0;
    if (off > kSameRay) {
      ++out.wrong_rays;
      if (!out.where) out.where = truth.from + (truth.crossing ? *truth.crossing : hit->toi) * (truth.to - truth.from);
    } else {
      out.worst_ray = std::max(out.worst_ray, off);
    }
  }
  return out;
}

void check_queries(MeshWork& work, StageResult& out) {
  // Looking at every triangle of a million is slow: fewer queries there, as many triangles in all.
  const auto triangles = static_cast<double>(work.surface.triangles.size());
  const bool quick = work.options.quick;
  const int count = std::clamp(static_cast<int>((quick ? 1e6 : 4e6) / triangles), quick ? 5 : 20, quick ? 40 : 200);
  const auto truths = true_queries(work.surface.triangles, work.surface.x, count, 1);
  QueryCount all;
  for (const BackendInfo& backend : triangle_index_backends()) {
    if (!backend.available) continue;
    const auto index = make_triangle_index(backend.name);
    index->build(work.surface.triangles, work.surface.x);
    index->refit(work.surface.x, work.surface.x);
    const QueryCount one = judge_queries(work.surface.triangles, work.surface.x, *index, truths);
    all.add(one);
    out.figures["backends"].push_back(backend.name);
    if (one.wrong_points + one.wrong_rays > 0)
      out.lower(Verdict::fail,
                text(backend.name, ": ", one.wrong_points, " of ", one.points, " closest points and ", one.wrong_rays,
                     " of ", one.rays, " rays differ from looking at every triangle"),
                work.in_file(*one.where));
  }
  out.figures.update({{"points", all.points},
                      {"rays", all.rays},
                      {"rays_that_hit", all.hits},
                      {"wrong_points", all.wrong_points},
                      {"wrong_rays", all.wrong_rays},
                      {"worst_point", all.worst_point},
                      {"worst_ray", all.worst_ray}});
}

}  // namespace kt
