#include "tests/support/shooting.hpp"

#include "collision/held/first_contact.hpp"
#include "tests/support/crossing_oracle.hpp"

namespace kt {
namespace {

/// Where a shot stands: what the engine has reported and where its centre went through, in ticks.
struct Progress {
  int hit_tick = -1, through_tick = -1;
  double toi = 0;
  quad::Real through = 0;
  bool is_over() const { return hit_tick >= 0 && through_tick >= 0; }
};

/// The gap that rounding allows where contact is reported: docs/collision.md.
double allowed_gap(const CollisionQuery& q, double radius) {
  double largest = radius, speed = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 at_t0 = q.triangle_t0[i] - q.tool_t0, at_t1 = q.triangle_t1[i] - q.tool_t1;
    largest = std::max({largest, at_t0.lpNorm<Eigen::Infinity>(), at_t1.lpNorm<Eigen::Infinity>()});
    speed = std::max(speed, (at_t1 - at_t0).norm());
  }
  return 2 * 128 * 0x1p-53 * largest + 0x1p-42 * speed;
}

void judge_hit(const Contact& hit, const CollisionQuery& q, double radius, ShotResult& out) {
  out.count.hits = 1;
  if (hit.gap < 0 && hit.toi == 0) {
    out.count.inside = radius == 0;
    return;  // the centre is inside, or the sphere overlaps at its start
  }
  out.count.gap = (exact_distance(q, hit.toi) - radius) / allowed_gap(q, radius);
  out.count.apart = out.count.gap > 1;
  if (out.count.apart) out.query = q;
}

void judge_times(const Progress& p, ShotResult& out) {
  out.count.through = p.through_tick >= 0;
  if (p.through_tick < 0) return;
  out.count.leaks = p.hit_tick < 0 || p.hit_tick > p.through_tick;
  out.count.late = p.hit_tick == p.through_tick && p.toi > p.through;
}

}  // namespace

void ShotCount::add(const ShotCount& other) {
  for (auto field : {&ShotCount::shots, &ShotCount::through, &ShotCount::hits, &ShotCount::leaks, &ShotCount::late,
                     &ShotCount::behind, &ShotCount::inside, &ShotCount::apart})
    this->*field += other.*field;
  gap = std::max(gap, other.gap);
}

std::vector<ShotResult> shoot(const SurfaceTicks& surface, std::span<const Shot> shots, TriangleIndex& index) {
  TriangleIndex* const only[] = {&index};
  return shoot(surface, shots, only)[0];
}

std::vector<std::vector<ShotResult>> shoot(const SurfaceTicks& surface, std::span<const Shot> shots,
                                           std::span<TriangleIndex* const> indexes) {
  CrossingOracle oracle(surface.triangles);
  std::vector<int> scratch(surface.triangles.size());
  std::vector<std::vector<ShotResult>> out(indexes.size(), std::vector<ShotResult>(shots.size()));
  std::vector<std::vector<Progress>> progress(indexes.size(), std::vector<Progress>(shots.size()));
  for (int tick = 0; tick < SurfaceTicks::kTicks; ++tick) {
    const MovingTriangles now = surface.during(tick);
    oracle.refit(now.x_t0, now.x_t1);
    for (TriangleIndex* index : indexes) index->refit(now.x_t0, now.x_t1);
    for (std::size_t i = 0; i < shots.size(); ++i) {
      const ToolSweep sweep = shots[i].sweep(tick);
      std::optional<Crossings> crossings;
      int triangle = -1;
      for (std::size_t k = 0; k < indexes.size(); ++k) {
        Progress& p = progress[k][i];
        ShotResult& result = out[k][i];
        if (p.is_over()) continue;
        double reported = 1;
        if (p.hit_tick < 0) {
          if (const auto hit = find_first_contact(*indexes[k], now, shots[i].tool, sweep, {}, scratch)) {
            p.hit_tick = tick;
            p.toi = reported = hit->toi;
            judge_hit(*hit, oracle.query(sweep, hit->triangle), shots[i].tool.radius, result);
          }
        }
        if (p.through_tick >= 0) continue;
        if (!crossings) crossings = oracle.find(sweep, triangle);
        if (crossings->from_behind && *crossings->from_behind < reported && (p.hit_tick < 0 || p.hit_tick == tick))
          result.count.behind = 1;
        if (!crossings->from_front) continue;
        p.through_tick = tick;
        p.through = *crossings->from_front;
        judge_times(p, result);
        if (result.count.leaks || result.count.late) result.query = oracle.query(sweep, triangle);
      }
    }
  }
  for (std::size_t k = 0; k < indexes.size(); ++k)
    for (std::size_t i = 0; i < shots.size(); ++i) {
      out[k][i].count.shots = 1;
      judge_times(progress[k][i], out[k][i]);
    }
  return out;
}

std::string to_text(const CollisionQuery& q) {
  std::string out;
  for (const Vec3& v : {q.tool_t0, q.tool_t1, q.triangle_t0[0], q.triangle_t0[1], q.triangle_t0[2], q.triangle_t1[0],
                        q.triangle_t1[1], q.triangle_t1[2]}) {
    char text[128];
    std::snprintf(text, sizeof text, "%s{%.17g, %.17g, %.17g}", out.empty() ? "" : ", ", v.x(), v.y(), v.z());
    out += text;
  }
  return out;
}

}  // namespace kt
