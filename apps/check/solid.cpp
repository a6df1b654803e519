// From a surface to a body: decimated where it is over the budget, filled with tetrahedra, else wrapped, else a shell.
#include "apps/check/mesh_work.hpp"
#include "core/error.hpp"
#include "io/decimate_surface.hpp"
#include "io/mesh_repair.hpp"
#include "io/surface_distance.hpp"
#include "io/tetrahedra_quality.hpp"
#include "io/tetrahedralize.hpp"
#include "models/msd/springs.hpp"

namespace kt {
namespace {

constexpr double kSpacing = kBodySize / 200;  // of samples, for distances
constexpr double kFarOff = 0.02;              // of the size: a coarser surface that is further off is not the same
constexpr double kFlat = 0.5;                 // [degrees] tetrahedra below this: others may do better
constexpr double kNeedle = 0.1;               // [degrees] bodies that are hard to step

std::string percent_of_size(double distance) { return text(100 * distance / kBodySize, " % of its size"); }

bool is_fillable(const MeshReport& r) {
  return r.closed() && r.manifold() && r.degenerate.empty() && r.duplicates.empty() && r.one_sided.empty() &&
         r.flipped.empty() && r.inside_out.empty() && r.nested.empty() && r.self_intersections.empty();
}

/// Coarser by as much as leaves the surface free of new intersections.
Mesh coarser(const Mesh& surface, const MeshWork& work, bool is_clean, StageResult& out) {
  std::string why;
  for (const double more : {1.0, 1.6, 2.5}) try {
      const auto target = static_cast<std::size_t>(more * work.options.budget);
      if (target >= surface.triangles.size()) break;
      Mesh coarse = decimate_surface(surface, static_cast<int>(target),
                                     {.timeout = work.options.backend_seconds, .stop = work.options.stop});
      if (is_clean && !is_fillable(examine(coarse))) {
        why = text(coarse.triangles.size(), " triangles would cross one another");
        continue;
      }
      const double off = hausdorff_distance(surface, coarse, kSpacing);
      const std::string said =
          text("over the budget of ", work.options.budget, " triangles: ", surface.triangles.size(), " decimated to ",
               coarse.triangles.size(), ", off by up to ", percent_of_size(off));
      out.figures["decimated"] = {{"triangles", coarse.triangles.size()}, {"distance", off / work.scale}};
      out.lower(off > kFarOff * kBodySize ? Verdict::degraded : Verdict::pass, said);
      return coarse;
    } catch (const std::runtime_error& e) {
      why = e.what();
    }
  throw RunError(text("not decimated: ", why));
}

/// By the first that can; where its tetrahedra are flat, by one whose are less so and no needles, and that leaves no
/// more triangles. Failures of the others lower the verdict.
std::optional<Mesh> filled(const Mesh& surface, const MeshWork& work, StageResult& out) {
  std::vector<std::string> failures;
  std::optional<Mesh> best;
  std::string by, others;
  double angle = 0;  // smallest of the best [deg]
  for (const BackendInfo& b : tetrahedralizers()) {
    if (!b.available) continue;
    try {
      Mesh solid = tetrahedralize(
          surface,
          {.name = "surface", .backend = b.name, .timeout = work.options.backend_seconds, .stop = work.options.stop});
      const double its = tetrahedra_quality(solid).dihedral_min;
      if (best && (its < std::max(angle, kNeedle) || solid.triangles.size() > surface.triangles.size())) continue;
      if (best) others += text(others.empty() ? "" : ", ", by, " ", angle);
      best = std::move(solid);
      by = b.name;
      angle = its;
      if (angle > kFlat || static_cast<int>(surface.triangles.size()) > work.options.budget) break;  // good, or slow
    } catch (const InputError& e) {
      failures.emplace_back(e.what());
      break;  // of the surface: the others would refuse it too
    } catch (const RunError& e) {
      if (!best) failures.emplace_back(e.what());
    }
  }
  if (best) {
    out.figures["tetrahedralizer"] = by;
    if (!failures.empty()) out.lower(Verdict::degraded, text(join(failures), "; filled by ", by));
    if (!others.empty())
      out.lower(Verdict::pass, text("filled by ", by, ", whose smallest angle is ", angle, " degrees (", others, ")"));
    if (angle < kNeedle) out.lower(Verdict::degraded, text("tetrahedra as flat as ", angle, " degrees"));
    return best;
  }
  if (failures.empty()) failures.emplace_back("no tetrahedralizer is in this build");
  out.lower(Verdict::degraded, join(failures));
  return {};
}

std::optional<Mesh> wrapped(const Mesh& surface, const MeshWork& work, StageResult& out) {
  try {
    WrapResult w = wrap(surface, {.timeout = work.options.backend_seconds, .stop = work.options.stop});
    const double off = std::max(w.distance_to_wrap, w.distance_to_input);
    out.figures["wrap"] = {{"distance", off / work.scale}, {"volume", w.volume_after / w.volume_before}};
    out.lower(Verdict::degraded, text("wrapped, which changes the shape by up to ", percent_of_size(off)));
    if (static_cast<int>(w.mesh.triangles.size()) > work.options.budget) w.mesh = coarser(w.mesh, work, true, out);
    return filled(w.mesh, work, out);
  } catch (const std::runtime_error& e) {
    out.lower(Verdict::degraded, text("not wrapped: ", e.what()));
    return {};
  }
}

/// A shell below an open surface, as thick as folds nowhere; nothing where it folds at any thickness.
std::optional<Mesh> shell(const Mesh& surface, double& thickness, StageResult& out) {
  for (thickness = 0.02 * kBodySize; thickness > 1e-4 * kBodySize; thickness /= 2) try {
      Mesh body = add_inner_layers(surface, 1, thickness);
      out.lower(Verdict::degraded, text("a shell of ", percent_of_size(thickness)));
      out.figures["shell"] = thickness;
      return body;
    } catch (const InputError&) {
    }
  thickness = 0;
  out.lower(Verdict::degraded, "a shell would fold at any thickness");
  return {};
}

/// The body of a surface that is not a solid yet.
Mesh body_of(MeshWork& work, StageResult& out) {
  Mesh surface{work.surface.x, work.surface.triangles, {}};
  const auto is_large = [&] { return static_cast<int>(surface.triangles.size()) > work.options.budget; };
  const bool fillable = is_fillable(work.repaired);
  try {
    if (is_large()) surface = coarser(surface, work, fillable, out);
  } catch (const RunError& e) {
    out.lower(Verdict::degraded, e.what());
  }
  std::optional<Mesh> body;
  if (work.repaired.closed()) {
    // One that stays over the budget is full of slivers, as a rule: better a little off than not to be stepped.
    if (fillable && !(is_large() && work.options.wrap)) body = filled(surface, work, out);
    if (!fillable) out.lower(Verdict::degraded, "not a surface that tetrahedra fit into");
  } else {
    out.lower(Verdict::degraded, "the surface is open", work.in_file(work.repaired.open_edges.front().at));
    if (!is_large()) body = shell(surface, work.shell, out);
  }
  if (!body && work.options.wrap) body = wrapped(work.surface, work, out);
  if (!body && fillable && is_large()) body = filled(surface, work, out);
  if (body) return std::move(*body);
  if (work.repaired.closed())
    if (auto hollow = shell(surface, work.shell, out)) return std::move(*hollow);
  work.shell = 0.01 * kBodySize;
  out.lower(Verdict::degraded, "a sheet of springs");
  return surface;
}

}  // namespace

void check_solid(MeshWork& work, StageResult& out) {
  if (work.solid.tetrahedra.empty()) work.solid = body_of(work, out);
  const TetrahedraQuality q = tetrahedra_quality(work.solid);
  out.figures.update({{"nodes", work.solid.num_nodes()},
                      {"tetrahedra", work.solid.tetrahedra.size()},
                      {"triangles", work.solid.triangles.size()},
                      {"dihedral_min_deg", q.dihedral_min},
                      {"radius_edge_max", q.radius_edge_max}});
}

}  // namespace kt
