// Spheres and points that are moved past a triangle, against the closed form: never missed, never late, and no earlier
// than 1e-9 of the step unless rounding cannot tell the gap by then. KT_SWEEPS=10000000 runs more of them.
#include <gtest/gtest.h>

#include <map>

#include "collision/impact/tool_impact.hpp"
#include "tests/support/environment.hpp"
#include "tests/support/random_sample.hpp"
#include "tests/support/translation_oracle.hpp"

namespace kt {
namespace {

constexpr double kBar = 1e-9;  // of the step
constexpr double kRounding =
    2 * 128 * 0x1p-53;                   // of the largest relative coordinate: the allowance of tool_impact.cpp, twice
constexpr double kResolution = 0x1p-42;  // of the step's motion

struct Sweep {
  CollisionQuery q;
  double radius = 0;
  std::vector<const char*> traits;  ///< what it was made to be, for the table

  double motion() const { return (q.triangle_t1[0] - q.triangle_t0[0] - q.tool_t1 + q.tool_t0).norm(); }
  double largest_coordinate() const {
    double out = radius;
    for (int i = 0; i < 3; ++i)
      out = std::max({out, (q.triangle_t0[i] - q.tool_t0).lpNorm<Eigen::Infinity>(),
                      (q.triangle_t1[i] - q.tool_t1).lpNorm<Eigen::Infinity>()});
    return out;
  }
  /// What separates tool and triangle at most where contact is reported: docs/collision.md.
  double allowed_gap() const { return kRounding * largest_coordinate() + kResolution * motion(); }
};

double power(Sample& s, double low, double high) { return std::pow(10, s.uniform(low, high)); }
Vec3 direction(Sample& s) { return s.cube().normalized(); }

/// Part of v across n (unit).
Vec3 across(const Vec3& v, const Vec3& n) { return (v - v.dot(n) * n).normalized(); }

/// A triangle of about the size given: of any shape, right-angled, or a sliver.
void make_triangle(Sample& s, double size, Sweep& out) {
  Vec3(&v)[3] = out.q.triangle_t0;
  for (Vec3& vertex : v) vertex = size * s.cube();
  const double shape = s.uniform(0, 1);
  if (shape < 0.2) {
    v[1] = v[0] + Vec3(size, 0, 0);
    v[2] = v[0] + Vec3(0, size, 0);
  } else if (shape < 0.5) {
    out.traits.push_back("slivers");
    v[2] = v[0] + s.uniform(0, 1) * (v[1] - v[0]) + size * power(s, -9, -1) * s.cube();
  } else if (shape < 0.6) {  // on one line, or two vertices in one place, but for rounding
    out.traits.push_back("hardly any area");
    v[2] = v[0] + (s.uniform(0, 1) < 0.5 ? 0 : s.uniform(0, 1)) * (v[1] - v[0]) + size * power(s, -18, -9) * s.cube();
  }
}

/// A place of the triangle and a direction in which a tool may touch it there: across the face, across an edge, any.
void choose_touch(Sample& s, const Vec3 (&v)[3], Vec3& place, Vec3& outward) {
  const auto feature = s.random() % 3;
  Vec3 bary(s.uniform(0, 1), feature == 2 ? 0 : s.uniform(0, 1), feature == 0 ? s.uniform(0, 1) : 0);
  bary /= bary.sum();
  std::rotate(bary.data(), bary.data() + s.random() % 3, bary.data() + 3);
  place = bary[0] * v[0] + bary[1] * v[1] + bary[2] * v[2];
  outward = direction(s);
  const Vec3 normal = (v[1] - v[0]).cross(v[2] - v[0]);
  if (feature == 0 && normal.norm() > 0) outward = (s.uniform(0, 1) < 0.8 ? 1 : -1) * normal.normalized();
  for (int i = 0; feature == 1 && i < 3; ++i)
    if (bary[i] == 0) outward = across(outward, (v[(i + 2) % 3] - v[(i + 1) % 3]).normalized());
}

/// Rounds to multiples of a power of two, so that sums of such numbers are exact.
Vec3 on_grid(const Vec3& v, double grid) {
  return {grid * std::round(v.x() / grid), grid * std::round(v.y() / grid), grid * std::round(v.z() / grid)};
}

Sweep random_sweep(Sample& s) {
  Sweep out;
  CollisionQuery& q = out.q;
  const double size = power(s, -6, 6);
  out.traits.push_back(size < 1e-3 ? "tiny" : size > 1e3 ? "large" : "middle size");
  make_triangle(s, size, out);
  const bool is_point = s.uniform(0, 1) < 0.3;
  out.traits.push_back(is_point ? "points" : "spheres");
  out.radius = is_point ? 0 : size * power(s, -4, 1);

  Vec3 place, outward;
  choose_touch(s, q.triangle_t0, place, outward);
  const double motion = power(s, -6, 3);
  out.traits.push_back(motion < 1e-3 ? "slow" : motion > 10 ? "fast" : "middle speed");
  Vec3 way = direction(s);
  Vec3 centre = place + out.radius * outward;
  const double kind = s.uniform(0, 1);
  if (kind < 0.4) {
    way = way.dot(outward) > 0 ? Vec3(-way) : way;
    out.traits.push_back("aimed");
  } else if (kind < 0.7) {
    way = across(way, outward) - power(s, -9, 0) * outward;
    out.traits.push_back("grazing");
  } else if (kind < 0.9) {  // passes, by less and less
    way = across(way, outward);
    centre += size * power(s, -14, 0) * outward;
    out.traits.push_back("passing");
  } else {
    centre = size * s.cube();
    out.traits.push_back("at random");
  }
  way *= size * motion / way.norm();
  const double when = s.uniform(0, 1);

  Vec3 offset = Vec3::Zero(), together = Vec3::Zero();
  if (s.uniform(0, 1) < 0.3) {
    offset = size * power(s, 0, 6) * s.cube();
    out.traits.push_back("far from the origin");
  }
  if (s.uniform(0, 1) < 0.5) {
    together = size * power(s, -3, 4) * s.cube();
    out.traits.push_back("moving together");
  }
  double largest = together.lpNorm<Eigen::Infinity>();
  for (Vec3& v : q.triangle_t0) largest = std::max(largest, (v += offset).lpNorm<Eigen::Infinity>());
  // Only a shift without rounding is a translation.
  const double grid = std::exp2(std::ceil(std::log2(largest)) - 50);
  together = on_grid(together, grid);
  for (int i = 0; i < 3; ++i) {
    q.triangle_t0[i] = on_grid(q.triangle_t0[i], grid);
    q.triangle_t1[i] = q.triangle_t0[i] + together;
  }
  q.tool_t0 = centre + offset - when * way;
  q.tool_t1 = q.tool_t0 + together + way;
  return out;
}

/// How the engine did; gaps in units of the allowance.
struct Row {
  long sweeps = 0, at_start = 0, must = 0, hits = 0, missed = 0, late = 0, over = 0, near = 0, behind = 0;
  double earliest = 0;  ///< of the step, of the well-conditioned ones
  double gap = 0;       ///< at the hit
  double closing = 0;   ///< of those over the bar: how much of the largest coordinate they close in on it in a step
  double gap_near = 0;  ///< of hits where nothing meets
};

class Table {
 public:
  void add(const char* name, const Row& one) {
    Row& to = rows_[name];
    for (auto field : {&Row::sweeps, &Row::at_start, &Row::must, &Row::hits, &Row::missed, &Row::late, &Row::over,
                       &Row::near, &Row::behind})
      to.*field += one.*field;
    for (auto field : {&Row::earliest, &Row::gap, &Row::closing, &Row::gap_near})
      to.*field = std::max(to.*field, one.*field);
  }
  const Row& operator[](const char* name) { return rows_[name]; }
  void print() const {
    std::printf("%-19s %8s %8s %8s | %8s %6s %5s | %8s %6s | %8s %8s | %6s %6s | %6s\n", "sweeps", "number", "at start",
                "must hit", "hits", "missed", "late", "earliest", "gap", "> 1e-9", "closing", "near", "gap", "behind");
    for (const auto& [name, r] : rows_)
      std::printf("%-19s %8ld %8ld %8ld | %8ld %6ld %5ld | %8.1e %6.2f | %8ld %8.1e | %6ld %6.2f | %6ld\n",
                  name.c_str(), r.sweeps, r.at_start, r.must, r.hits, r.missed, r.late, r.earliest, r.gap, r.over,
                  r.closing, r.near, r.gap_near, r.behind);
  }

 private:
  std::map<std::string, Row> rows_;
};

/// A point that starts this little behind the face counts as on it: docs/collision.md.
bool starts_a_little_inside(const Contact& hit) { return hit.toi == 0 && hit.gap < 0; }

/// A touch that one-sidedness lets pass: of the face from behind, and whatever a point meets from there.
bool is_from_within(const TranslationTouch& truth, double radius) {
  return truth.from_behind && (truth.feature == TranslationTouch::Feature::face || radius == 0);
}

Row judge(const Sweep& sweep, const std::optional<TranslationTouch>& truth, const std::optional<Contact>& hit) {
  Row out;
  out.sweeps = 1;
  out.hits = hit.has_value();
  if ((truth && truth->touches_t0) || (hit && starts_a_little_inside(*hit))) {
    out.at_start = 1;
    return out;
  }
  const auto gap_at = [&](quad::Real t) { return translation_gap(sweep.q, sweep.radius, t) / sweep.allowed_gap(); };
  const double gap = hit ? gap_at(hit->toi) : 0;
  if (!truth || is_from_within(*truth, sweep.radius)) {
    out.near = hit && !truth;
    out.behind = hit && truth;
    out.gap_near = gap;
    return out;
  }
  out.must = 1;
  out.missed = !hit;
  if (!hit) return out;
  out.gap = gap;
  out.late = hit->toi > truth->toi;
  const auto early = static_cast<double>(truth->toi - hit->toi);
  // Above the bar only where rounding leaves no choice: so much of the step before the touch they are that near.
  out.over = early > kBar && gap_at(truth->toi - kBar) <= 1;
  if (out.over)
    out.closing = truth->closing * sweep.motion() / sweep.largest_coordinate();
  else
    out.earliest = early;
  return out;
}

TEST(SphereTriangleToi, OfATranslationIsThatOfTheClosedForm) {
  Sample s{std::mt19937_64(21)};
  const long sweeps = number_from_environment("KT_SWEEPS", 100000);
  Table table;
  for (long i = 0; i < sweeps; ++i) {
    const Sweep sweep = random_sweep(s);
    ASSERT_TRUE(is_translation(sweep.q)) << i;
    const auto truth = first_translation_touch(sweep.q, sweep.radius);
    const ToolShape tool{sweep.radius > 0 ? ToolShape::Kind::sphere : ToolShape::Kind::point, sweep.radius};
    const auto hit =
        find_triangle_impact(tool, {sweep.q.tool_t0, sweep.q.tool_t1}, sweep.q.triangle_t0, sweep.q.triangle_t1);
    const Row one = judge(sweep, truth, hit);
    constexpr const char* kTouched[] = {"touch a face", "touch an edge", "touch a vertex"};
    table.add("all", one);
    table.add(truth ? kTouched[static_cast<int>(truth->feature)] : "touch nothing", one);
    for (const char* trait : sweep.traits) table.add(trait, one);
    EXPECT_FALSE(one.missed || one.late || one.earliest > kBar || one.gap > 1 || one.gap_near > 1) << i;
    if (HasFailure()) break;
  }
  table.print();
  EXPECT_GT(table["all"].must, sweeps / 3);
}

}  // namespace
}  // namespace kt
