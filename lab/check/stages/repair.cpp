// Repairs that are safe, what they did, and how far the surface moved by them.
#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "io/surface/mesh_repair.hpp"
#include "io/surface/surface_distance.hpp"
#include "lab/check/mesh_work.hpp"

namespace kt {
namespace {

constexpr double kSame = 1e-9;  // of the longest side: the shape has not changed

void take_metres(const Mesh& repaired, MeshWork& work) {
  const Bounds box = bounds(repaired);
  work.origin = box.centre();
  work.scale = kBodySize / box.size().maxCoeff();
  work.surface = repaired;
  for (int i = 0; i < repaired.num_nodes(); ++i)
    node(work.surface.x, i) = work.scale * (node(repaired.x, i) - work.origin);
}

}  // namespace

void check_repair(MeshWork& work, StageResult& out) {
  if (!work.input.tetrahedra.empty()) {
    out.why = "a solid: its surface is that of its tetrahedra";
    out.figures["distance"] = 0;
    take_metres(work.input, work);
    work.solid = work.surface;
    work.repaired = examine(Mesh{work.surface.x, work.surface.triangles, {}}, {.self_intersections = false});
    return;
  }
  RepairOptions options{.fill_holes = work.options.fill_holes, .timeout = work.options.backend_seconds};
  options.stop = work.options.stop;
  RepairResult repaired{work.input, {}};
  try {
    repaired = repair(work.input, options);
  } catch (const RunError& e) {  // of hole filling alone
    options.fill_holes = 0;
    repaired = repair(work.input, options);
    out.lower(Verdict::degraded, e.what());
  } catch (const InputError& e) {
    return out.lower(Verdict::fail, e.what(), work.report.box.centre());
  }
  for (const std::string& what : repaired.done) out.why += (out.why.empty() ? "" : "; ") + what;
  take_metres(repaired.mesh, work);
  work.repaired = examine(work.surface);

  const double moved =
      repaired.done.empty() ? 0 : hausdorff_distance(work.input, repaired.mesh, work.report.box.size().norm() / 100);
  const double longest = work.report.box.size().maxCoeff();
  out.figures = {{"done", repaired.done}, {"distance", moved}, {"triangles", work.surface.triangles.size()}};
  if (moved > kSame * longest)
    out.lower(Verdict::degraded,
              told("the shape changed, by up to ", moved, " (", in_percent(moved / longest), " of its size)"));
  for (const DefectList& d : defects(work.repaired)) {
    out.figures["left"][d.key] = d.places->size();
    if (!d.places->empty())
      out.lower(Verdict::degraded, text(d.places->size(), " ", d.title, " left"), work.in_file(d.places->front().at));
  }
}

}  // namespace kt
