// From a surface to a body: a lattice, or filled: decimated where it is over the budget, filled with tetrahedra, else
// wrapped, else a shell.
#include "core/base/error.hpp"
#include "io/solid/lattice.hpp"
#include "io/solid/tetrahedra_quality.hpp"
#include "io/surface/mesh_repair.hpp"
#include "lab/check/stages/fill.hpp"
#include "models/msd/springs.hpp"

namespace kt {
namespace {

std::optional<Mesh> wrapped(const Mesh& surface, const MeshWork& work, StageResult& out) {
  try {
    const WrapResult w = wrap(surface, {.timeout = work.options.backend_seconds, .stop = work.options.stop});
    const double off = std::max(w.distance_to_wrap, w.distance_to_input);
    out.figures["wrap"] = {{"distance", off / work.scale}, {"volume", w.volume_after / w.volume_before}};
    out.lower(Verdict::degraded, text("wrapped, which changes the shape by up to ", percent_of_size(off)));
    Mesh coarse = w.mesh;
    if (is_over_budget(coarse, work)) coarse = decimated(w.mesh, work, true, out);
    return filled(coarse, w.mesh, work, out);
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
  const Mesh fine{work.surface.x, work.surface.triangles, {}};
  const bool is_closed = work.repaired.closed(), fillable = is_fillable(work.repaired);
  Mesh surface = fine;
  bool is_small = !is_over_budget(fine, work);
  if (!is_small) try {
      surface = decimated(fine, work, fillable, out);
      const int most = (is_closed ? kMostBudgets : 1) * work.options.budget;
      is_small = static_cast<int>(surface.triangles.size()) <= most;
    } catch (const RunError& e) {
      out.lower(Verdict::degraded, e.what());
    }
  std::optional<Mesh> body;
  if (is_closed) {
    // One that cannot be decimated is full of slivers, as a rule: better a little off than not to be stepped.
    if (fillable && (is_small || !work.options.wrap)) body = filled(surface, fine, work, out);
    if (!fillable) out.lower(Verdict::degraded, "not a surface that tetrahedra fit into");
  } else {
    out.lower(Verdict::degraded, "the surface is open", work.in_file(work.repaired.open_edges.front().at));
    if (is_small) body = shell(surface, work.shell, out);
  }
  if (!body && work.options.wrap) body = wrapped(work.surface, work, out);
  if (!body && fillable && !is_small) body = filled(surface, fine, work, out);
  if (body) return std::move(*body);
  if (is_closed)
    if (auto hollow = shell(surface, work.shell, out)) return std::move(*hollow);
  work.shell = 0.01 * kBodySize;
  out.lower(Verdict::degraded, "a sheet of springs");
  return surface;
}

/// As `kilotouch run` takes surfaces; nothing where it holds no material.
std::optional<Mesh> lattice(const MeshWork& work, StageResult& out) {
  constexpr double kUnsure = 0.05;  // of the volume near the surface
  LatticeReport report;
  try {
    Mesh body = make_lattice(work.surface, {.nodes = work.options.nodes, .name = "the surface"}, &report);
    for (const std::string& line : report.lines())
      out.lower(report.unsure > kUnsure ? Verdict::degraded : Verdict::pass, line);
    out.figures["lattice"] = {{"edge", report.edge / work.scale},
                              {"open_edges", report.open_edges},
                              {"turned", report.turned},
                              {"unsure", report.unsure}};
    return body;
  } catch (const InputError& e) {
    out.lower(Verdict::degraded, e.what());
    return {};
  }
}

}  // namespace

void check_solid(MeshWork& work, StageResult& out) {
  std::optional<Mesh> body;
  if (work.solid.tetrahedra.empty() && work.options.body == "lattice") body = lattice(work, out);
  if (body)
    work.solid = std::move(*body);
  else if (work.solid.tetrahedra.empty())
    work.solid = body_of(work, out);
  const TetrahedraQuality q = tetrahedra_quality(work.solid);
  out.figures.update({{"nodes", work.solid.num_own_nodes()},
                      {"tetrahedra", work.solid.tetrahedra.size()},
                      {"triangles", work.solid.triangles.size()},
                      {"dihedral_min_deg", q.dihedral_min},
                      {"radius_edge_max", q.radius_edge_max}});
}

}  // namespace kt
