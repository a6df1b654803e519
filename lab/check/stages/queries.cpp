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

}  // namespace

void QueryCount::add(const QueryCount& other) {
  for (const auto field :
       {&QueryCount::points, &QueryCount::rays, &QueryCount::hits, &QueryCount::wrong_points, &QueryCount::wrong_rays})
    this->*field += other.*field;
  worst_point = std::max(worst_point, other.worst_point);
  worst_ray = std::max(worst_ray, other.worst_ray);
  if (!where) where = other.where;
}

QueryCount judge_queries(std::span<const Triangle> triangles, const VectorX& x, const TriangleIndex& index, int count,
                         unsigned seed) {
  Sample sample{std::mt19937_64(seed)};
  std::vector<int> scratch(triangles.size());
  Vec3 low = node(x, triangles[0][0]), high = low;
  for (const Triangle& t : triangles)
    for (const int i : t) {
      low = low.cwiseMin(Vec3(node(x, i)));
      high = high.cwiseMax(Vec3(node(x, i)));
    }
  const double size = (high - low).norm();
  const auto anywhere = [&] { return Vec3(0.5 * (low + high) + 0.7 * size * sample.cube()); };
  const auto on_surface = [&] {
    const Triangle& t = triangles[sample.random() % triangles.size()];
    const double u = sample.uniform(0, 1), v = sample.uniform(0, 1 - u);
    return Vec3((1 - u - v) * node(x, t[0]) + u * node(x, t[1]) + v * node(x, t[2]));
  };
  QueryCount out;
  for (int i = 0; i < count; ++i) {
    const Vec3 p = i % 2 ? anywhere() : Vec3(on_surface() + 0.02 * size * sample.cube());
    const NearestPlace all = nearest_place(triangles, x, p), found = nearest_by(index, triangles, x, p, size, scratch);
    ++out.points;
    const double more = found.triangle < 0 ? size : std::sqrt(found.at.distance_sq) - std::sqrt(all.at.distance_sq);
    out.worst_point = std::max(out.worst_point, more / size);
    if (more > kSamePoint * size) {
      ++out.wrong_points;
      if (!out.where) out.where = p;
    }

    const Vec3 a = anywhere(), target = on_surface(), b = a + 1.3 * (target - a);
    bool sure = true;
    const auto truth = first_crossing(triangles, x, a, b, sure);
    const MovingTriangles still{triangles, x, x};
    const auto hit = find_first_contact(index, still, {ToolShape::Kind::point, 0}, {a, b}, {}, scratch);
    ++out.rays;
    if (!sure) continue;  // no verdict: the engine may take either triangle at an edge, and err early at a graze
    out.hits += truth.has_value();
    const double off = truth && hit ? std::abs(hit->toi - *truth) : truth.has_value() != hit.has_value() ? 1 : 0;
    if (off > kSameRay) {
      ++out.wrong_rays;
      if (!out.where) out.where = a + (truth ? *truth : hit->toi) * (b - a);
    } else {
      out.worst_ray = std::max(out.worst_ray, off);
    }
  }
  return out;
}

void check_queries(MeshWork& work, StageResult& out) {
  // Looking at every triangle of a million is slow: fewer queries there, as many triangles in all.
  const auto triangles = static_cast<double>(work.surface.triangles.size());
  const int count = std::clamp(static_cast<int>(4e6 / triangles), 20, work.options.quick ? 40 : 200);
  QueryCount all;
  for (const BackendInfo& backend : triangle_index_backends()) {
    if (!backend.available) continue;
    const auto index = make_triangle_index(backend.name);
    index->build(work.surface.triangles, work.surface.x);
    index->refit(work.surface.x, work.surface.x);
    const QueryCount one = judge_queries(work.surface.triangles, work.surface.x, *index, count, 1);
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
