#include "lab/check/stages/fill.hpp"

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "io/solid/tetrahedra_quality.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "io/surface/decimate_surface.hpp"
#include "io/surface/surface_distance.hpp"

namespace kt {
namespace {

constexpr double kSpacing = kBodySize / 200;  // of samples, for distances
constexpr double kFarOff = 0.02;              // of the size: a coarser surface that is further off is not the same
constexpr double kFlat = 0.5;    // [degrees] tetrahedra below this: another surface or others may do better
constexpr double kNeedle = 0.1;  // [degrees] bodies that are hard to step
constexpr double kWorth = 2;     // times the angle, at least: an even surface is further off

struct Coarse {
  Mesh surface;
  double off = 0;  ///< from what it was [m]
};

/// @throws RunError where it is to be clean and would cross itself
Coarse coarser(const Mesh& surface, std::size_t triangles, bool evenly, bool is_clean, const MeshWork& work) {
  Mesh coarse =
      decimate_surface(surface, static_cast<int>(triangles),
                       {.evenly = evenly, .timeout = work.options.backend_seconds, .stop = work.options.stop});
  if (is_clean && !is_fillable(examine(coarse)))
    throw RunError(text(coarse.triangles.size(), " triangles would cross one another"));
  const double off = hausdorff_distance(surface, coarse, kSpacing);
  return {std::move(coarse), off};
}

nlohmann::ordered_json figures_of(const Coarse& c, const MeshWork& work) {
  return {{"triangles", c.surface.triangles.size()}, {"distance", c.off / work.scale}};
}

struct Filling {
  Mesh solid;
  std::string by;
  double angle = 0;  ///< smallest between two faces [deg]
};

Filling fill(const Mesh& surface, const std::string& backend, const MeshWork& work) {
  Mesh solid = tetrahedralize(
      surface,
      {.name = "surface", .backend = backend, .timeout = work.options.backend_seconds, .stop = work.options.stop});
  const double angle = tetrahedra_quality(solid).dihedral_min;
  return {std::move(solid), backend, angle};
}

/// A decimated surface once more from what it was, with edges alike: better tetrahedra, further off.
/// @return whether it has taken the place of the first
bool fill_evenly(Filling& best, const Mesh& fine, std::size_t triangles, const MeshWork& work, StageResult& out) {
  try {
    const Coarse even = coarser(fine, triangles, true, true, work);
    Filling its = fill(even.surface, best.by, work);
    if (even.off > kFarOff * kBodySize || its.angle < kWorth * best.angle) return false;
    out.figures["decimated"] = figures_of(even, work);
    out.figures["decimated"]["evenly"] = true;
    out.lower(Verdict::pass, text("again, with edges alike, off by up to ", percent_of_size(even.off),
                                  ": the smallest angle of tetrahedra is ", its.angle, " degrees, not ", best.angle));
    best = std::move(its);
    return true;
  } catch (const std::runtime_error&) {
    return false;  // the first will do
  }
}

}  // namespace

std::string percent_of_size(double distance) { return in_percent(distance / kBodySize) + " of its size"; }

bool is_over_budget(const Mesh& surface, const MeshWork& work) {
  return static_cast<int>(surface.triangles.size()) > work.options.budget;
}

bool is_fillable(const MeshReport& r) {
  return r.closed() && r.manifold() && r.degenerate.empty() && r.duplicates.empty() && r.one_sided.empty() &&
         r.flipped.empty() && r.inside_out.empty() && r.nested.empty() && r.self_intersections.empty();
}

Mesh decimated(const Mesh& surface, const MeshWork& work, bool is_clean, StageResult& out) {
  std::string why;
  for (const double more : {1.0, 1.6, 2.5, 1.0 * kMostBudgets}) try {
      const auto target = static_cast<std::size_t>(more * work.options.budget);
      if (target >= surface.triangles.size()) break;
      Coarse coarse = coarser(surface, target, false, is_clean, work);
      out.figures["decimated"] = figures_of(coarse, work);
      out.lower(
          coarse.off > kFarOff * kBodySize ? Verdict::degraded : Verdict::pass,
          text("over the budget of ", work.options.budget, " triangles: ", surface.triangles.size(), " decimated to ",
               coarse.surface.triangles.size(), ", off by up to ", percent_of_size(coarse.off)));
      return std::move(coarse.surface);
    } catch (const std::runtime_error& e) {
      why = e.what();
    }
  throw RunError(text("not decimated: ", why));
}

std::optional<Mesh> filled(const Mesh& surface, const Mesh& fine, const MeshWork& work, StageResult& out) {
  std::vector<std::string> failures;
  std::optional<Filling> best;
  std::string others;
  for (const BackendInfo& b : tetrahedralizers()) {
    if (!b.available) continue;
    try {
      Filling its = fill(surface, b.name, work);
      if (best && (its.angle < std::max(best->angle, kNeedle) || its.solid.triangles.size() > surface.triangles.size()))
        continue;
      if (best) others += told(others.empty() ? "" : ", ", best->by, " ", best->angle);
      best = std::move(its);
      if (best->angle > kFlat) break;
      if (surface.triangles.size() < fine.triangles.size() &&
          fill_evenly(*best, fine, surface.triangles.size(), work, out))
        break;
      if (is_over_budget(surface, work)) break;  // others would be slow
    } catch (const InputError& e) {
      failures.emplace_back(e.what());
      break;  // of the surface: the others would refuse it too
    } catch (const RunError& e) {
      if (!best) failures.emplace_back(e.what());
    }
  }
  if (best) {
    out.figures["tetrahedralizer"] = best->by;
    if (!failures.empty()) out.lower(Verdict::degraded, text(join(failures), "; filled by ", best->by));
    if (!others.empty())
      out.lower(Verdict::pass,
                told("filled by ", best->by, ", whose smallest angle is ", best->angle, " degrees (", others, ")"));
    if (best->angle < kNeedle) out.lower(Verdict::degraded, told("tetrahedra as flat as ", best->angle, " degrees"));
    return std::move(best->solid);
  }
  if (failures.empty()) failures.emplace_back("no tetrahedralizer is in this build");
  out.lower(Verdict::degraded, join(failures));
  return {};
}

}  // namespace kt
