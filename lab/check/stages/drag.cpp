// A sphere dragged over the surface along three ways: is contact kept, is the force smooth?
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "haptics/session/real_time.hpp"
#include "lab/check/hand_paths.hpp"
#include "lab/check/mesh_work.hpp"
#include "lab/check/runs.hpp"

namespace kt {
namespace {

constexpr double kSpeed = 0.04, kDuration = 0.6, kLongest = 0.015;  // [m/s], [s], [m]
constexpr int kHeadings = 6;
constexpr double kShortest = 0.003;  // of a way that says anything [m]
constexpr double kAlways = std::numeric_limits<double>::infinity();
constexpr double kBuzz = 0.10, kJump = 1.0;  // of the mean force

struct Drag {
  ContactSpot spot;
  std::vector<Vec3> walk;
};

/// The longest ways, from different places.
std::vector<Drag> choose_drags(const MeshWork& work, std::size_t count) {
  const SurfaceQuery surface(work.solid.triangles, work.solid.x);
  const HeldTriangles held(work.solid, work.still);
  std::vector<Drag> out;
  for (const ContactSpot& spot : work.spots) {
    Drag best{spot, {}};
    for (int k = 0; k < kHeadings; ++k) {
      auto walk = surface_walk(surface, held, spot, 2 * std::numbers::pi * k / kHeadings, kLongest);
      if (walk.size() > best.walk.size()) best.walk = std::move(walk);
    }
    if (best.walk.size() > 1) out.push_back(std::move(best));
  }
  std::ranges::stable_sort(out, std::greater<>(), [](const Drag& d) { return d.walk.size(); });
  if (out.size() > count) out.resize(count);
  return out;
}

/// Where contact was lost first.
Vec3 first_loss(const SessionResult& run, const Vec3& otherwise) {
  for (std::size_t i = 1; i < run.tools[0].frames.size(); ++i)
    if (run.tools[0].frames[i].mode == ContactMode::free && run.tools[0].frames[i - 1].mode != ContactMode::free)
      return run.tools[0].frames[i].pose.x;
  return otherwise;
}

}  // namespace

void check_drag(MeshWork& work, StageResult& out) {
  const std::vector<Drag> drags = choose_drags(work, work.options.quick ? 1 : 3);
  out.figures["ways"] = drags.size();
  double way = 0;
  for (const Drag& d : drags) way += length_of(d.walk);
  out.figures["length"] = way;
  if (drags.empty() || length_of(drags[0].walk) < kShortest)
    out.lower(Verdict::degraded,
              told("no way over the surface is longer than ", 1e3 * kShortest, " mm before it bends"),
              work.in_file(work.spots[0].place));
  for (CheckBody& body : work.bodies) {
    RunExtremes all;
    RealTime slowest;
    double buzz = 0, crossing = 0, refresh = 0;
    int lost = 0;
    for (std::size_t i = 0; i < drags.size(); ++i) {
      const std::string name = text(body.model, ", way ", i + 1);
      const Vec3 where = work.in_file(drags[i].spot.place);
      const SessionResult run =
          run_along(body, drag_path(drags[i].spot, drags[i].walk, kSpeed, kDuration), work.options.stop);
      judge_run(run, name, where, all, out);
      const RealTime pace = judge_real_time(body.session->scene(), run);
      if (i == 0 || pace.refresh_ms > slowest.refresh_ms) slowest = pace;
      const ForceMetrics m = measure_forces(run.tools[0].frames, kDragPressTime, 1e-3);
      lost += m.lost_contacts;
      buzz = std::max(buzz, m.buzz);
      crossing = std::max(crossing, m.crossing_jump);
      refresh = std::max(refresh, m.refresh_jump);
      if (m.lost_contacts > 0) {
        const Loss loss = longest_loss(body, run, kDragPressTime, kAlways, work.options.stop);
        if (loss.ticks > 0)  // else it bounced on the way down, before the drag
          out.lower(judge_loss(loss),
                    text(name, ": contact lost ", m.lost_contacts, m.lost_contacts == 1 ? " time" : " times", ", ",
                         loss.told()),
                    work.in_file(first_loss(run, drags[i].spot.place)));
      }
      if (m.buzz > kBuzz)
        out.lower(Verdict::degraded, told(name, ": buzz above 100 Hz of ", in_percent(m.buzz), " of the force"), where);
      if (std::max(m.crossing_jump, m.refresh_jump) > kJump)
        out.lower(
            Verdict::degraded,
            told(name, ": the force jumps by ", in_percent(std::max(m.crossing_jump, m.refresh_jump)), " in a tick"),
            where);
    }
    report_runs(all, body.model, out);
    if (!drags.empty())
      out.times[body.model]["real_time"] = {{"keeps", name_of(slowest.keeps)}, {"told", slowest.told()}};
    out.figures[body.model].update(
        {{"lost", lost}, {"buzz", buzz}, {"crossing_jump", crossing}, {"refresh_jump", refresh}});
  }
}

}  // namespace kt
