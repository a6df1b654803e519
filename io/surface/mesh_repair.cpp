#include "io/surface/mesh_repair.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <set>

#include "core/base/error.hpp"
#include "io/files/child_process.hpp"
#include "io/mesh/edge_table.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/mesh/weld.hpp"
#include "io/surface/mesh_doctor.hpp"
#include "io/surface/repair_cgal.hpp"

namespace kt {
namespace {

using Done = std::vector<std::string>;

void drop_non_finite(Mesh& mesh, Done& done) {
  const std::size_t dropped = std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return !std::all_of(t.begin(), t.end(), [&](int i) { return node(mesh.x, i).allFinite(); });
  });
  if (dropped > 0) done.push_back(text(dropped, " triangles at NaN or infinite nodes dropped"));
}

void weld(Mesh& mesh, const RepairOptions& options, Done& done) {
  const int joined = join_nodes(mesh, options.weld_tolerance);
  if (joined == 0) return;
  done.push_back(options.weld_tolerance > 0
                     ? text(joined, " nodes joined with another at most ", options.weld_tolerance, " away")
                     : text(joined, " nodes joined with another at the same position"));
}

/// Only triangles with a repeated node: dropping one with three different nodes in a line would open a gap.
void drop_degenerate(Mesh& mesh, Done& done) {
  const std::size_t dropped = std::erase_if(mesh.triangles, repeats_node);
  if (dropped > 0) done.push_back(text(dropped, " triangles with two equal corners dropped"));
}

void drop_duplicates(Mesh& mesh, Done& done) {
  std::map<Triangle, int> known;
  const std::size_t dropped = std::erase_if(mesh.triangles, [&](Triangle t) {
    std::sort(t.begin(), t.end());
    return !known.try_emplace(t, 0).second;
  });
  if (dropped > 0) done.push_back(text(dropped, " second copies of triangles dropped"));
}

void split_nonmanifold(Mesh& mesh, Done& done) {
  const EdgeTable table = make_edge_table(mesh.triangles);
  const Fans fans = find_fans(mesh.triangles, table, mesh.num_nodes());
  std::vector<double> x(mesh.x.begin(), mesh.x.end());
  std::map<std::array<int, 2>, int> copies;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      int& i = mesh.triangles[t][k];
      if (table.edge_of[t][k] < 0 || fans.fan_of[t][k] == 0) continue;  // the first fan keeps the node
      const auto [it, fresh] = copies.try_emplace({i, fans.fan_of[t][k]}, static_cast<int>(x.size() / 3));
      if (fresh)
        for (int c = 0; c < 3; ++c) x.push_back(mesh.x[3 * i + c]);
      i = it->second;
    }
  if (copies.empty()) return;
  mesh.x = Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
  done.push_back(text(copies.size(), " nodes added where several fans of triangles touched in one node"));
}

void flip(Triangle& t) { std::swap(t[1], t[2]); }

/// Each piece follows its majority; then closed pieces are turned as a whole.
void orient(Mesh& mesh, Done& done) {
  const EdgeTable table = make_edge_table(mesh.triangles);
  const Pieces pieces = find_pieces(mesh.triangles, table, false);
  std::vector<std::array<int, 2>> votes(static_cast<std::size_t>(pieces.count), {0, 0});
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (pieces.piece[t] >= 0) ++votes[pieces.piece[t]][pieces.reversed[t]];
  int turned = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const int p = pieces.piece[t];
    if (p < 0 || pieces.one_sided[p] || pieces.reversed[t] == (votes[p][1] > votes[p][0])) continue;
    flip(mesh.triangles[t]);
    ++turned;
  }
  if (turned > 0) done.push_back(text(turned, " triangles turned to agree with their neighbours"));

  const MeshReport report = examine(mesh, {.self_intersections = false});
  std::vector<bool> is_inside_out(static_cast<std::size_t>(pieces.count), false);
  for (const MeshPlace& place : report.inside_out) is_inside_out[pieces.piece[place.triangles[0]]] = true;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (pieces.piece[t] >= 0 && is_inside_out[pieces.piece[t]]) flip(mesh.triangles[t]);
  if (!report.inside_out.empty()) done.push_back(text(report.inside_out.size(), " closed pieces turned outward"));
}

[[noreturn, maybe_unused]] void needs_cgal(const char* what) {
  throw InputError(text(what,
                        " needs CGAL: configure with -DKT_WITH_CGAL=ON, or touch the surface as it is, with "
                        "object.body lattice"));
}

#if KT_WITH_CGAL
/// Runs `work` in a child and reads back the mesh it leaves: CGAL loops for ever on a few inputs.
template <class Options>
Mesh guarded(const std::string& what, const Options& options, const std::function<Mesh()>& work,
             std::string* output = nullptr) {
  const PrivateFolder folder;
  const std::string file = folder / "out.obj";
  const ChildLimits limits{.seconds = options.timeout, .memory_bytes = std::size_t{8} << 30, .stop = options.stop};
  const ChildResult run = run_forked([&] { save_mesh(file, work()); }, folder, limits);
  require_good(run, what, limits);
  if (output) *output = run.output;
  return load_mesh(file);
}
#endif

void fill_holes(Mesh& mesh, const RepairOptions& options, Done& done) {
#if KT_WITH_CGAL
  std::string filled;
  mesh = guarded(
      "filling holes", options,
      [&] {
        Mesh copy = mesh;
        std::printf("%d", fill_holes_cgal(copy, options.fill_holes));
        return copy;
      },
      &filled);
  if (filled != "0") done.push_back(text(filled, " holes of at most ", options.fill_holes, " edges closed"));
#else
  (void)mesh, (void)options, (void)done;
  needs_cgal("filling holes");
#endif
}

void check_positive(const char* name, double value, bool zero_allowed) {
  if (!std::isfinite(value) || value < 0 || (value == 0 && !zero_allowed))
    throw InputError(text(name, " is ", value, "; must be ", zero_allowed ? ">= 0 (0: automatic)" : "> 0"));
}

void check_tolerance(const Mesh& mesh, double tolerance) {
  if (tolerance == 0) return;
  const double least = rounding_of(mesh), longest = bounds(mesh).size().maxCoeff();
  if (!(tolerance >= least) || tolerance >= longest)
    throw InputError(text("--weld is ", tolerance, "; must be 0, or from ", least,
                          ", the rounding of the coordinates, to below ", longest,
                          ", the longest side of the mesh, in its own unit"));
}

/// Nodes in one place are joined, tetrahedra that this flattens and second copies dropped; the surface is the boundary.
RepairResult repair_solid(const Mesh& solid, const RepairOptions& options) {
  if (options.fill_holes > 0) throw InputError("filling holes works on surfaces; the mesh has tetrahedra");
  RepairResult r{solid, {}};
  if (options.weld) weld(r.mesh, options, r.done);
  std::set<Tetrahedron> known;
  std::size_t flat = 0, copies = 0;
  std::erase_if(r.mesh.tetrahedra, [&](Tetrahedron t) {
    std::sort(t.begin(), t.end());
    const bool is_flat = options.drop_degenerate && std::adjacent_find(t.begin(), t.end()) != t.end();
    const bool is_copy = !is_flat && options.drop_duplicates && !known.insert(t).second;
    flat += is_flat;
    copies += is_copy;
    return is_flat || is_copy;
  });
  if (flat > 0) r.done.push_back(text(flat, " tetrahedra with two equal corners dropped"));
  if (copies > 0) r.done.push_back(text(copies, " second copies of tetrahedra dropped"));
  if (r.mesh.tetrahedra.empty()) throw InputError("nothing is left of the solid: all its tetrahedra are degenerate");
  r.mesh.triangles = boundary_triangles(r.mesh.tetrahedra);
  if (options.drop_isolated)
    if (const int dropped = drop_unused_nodes(r.mesh); dropped > 0)
      r.done.push_back(text(dropped, " unused nodes dropped"));
  return r;
}

}  // namespace

RepairResult repair(const Mesh& surface, const RepairOptions& options) {
  if (options.fill_holes < 0) throw InputError(text("fill_holes is ", options.fill_holes, "; must be >= 0"));
  check_positive("timeout", options.timeout, false);
  check_tolerance(surface, options.weld_tolerance);
  if (!surface.tetrahedra.empty()) return repair_solid(surface, options);
  RepairResult r{surface, {}};
  drop_non_finite(r.mesh, r.done);
  if (options.weld) weld(r.mesh, options, r.done);
  if (options.drop_degenerate) drop_degenerate(r.mesh, r.done);
  if (options.drop_duplicates) drop_duplicates(r.mesh, r.done);
  if (options.split_nonmanifold) split_nonmanifold(r.mesh, r.done);
  if (options.orient) orient(r.mesh, r.done);
  if (options.fill_holes > 0) {
    fill_holes(r.mesh, options, r.done);
    if (options.orient) orient(r.mesh, r.done);  // a piece that is closed now has an outside
  }
  if (options.drop_isolated)
    if (const int dropped = drop_unused_nodes(r.mesh); dropped > 0)
      r.done.push_back(text(dropped, " unused nodes dropped"));
  if (r.mesh.triangles.empty()) throw InputError("nothing is left of the surface: all its triangles are degenerate");
  return r;
}

WrapResult wrap(const Mesh& surface, const WrapOptions& options) {
  check_positive("alpha", options.alpha, true);
  check_positive("offset", options.offset, true);
  check_positive("timeout", options.timeout, false);
#if KT_WITH_CGAL
  if (!surface.tetrahedra.empty()) throw InputError("wrap works on surfaces; the mesh has tetrahedra");
  Mesh input = surface;
  Done ignored;
  drop_non_finite(input, ignored);
  drop_unused_nodes(input);
  if (input.triangles.empty()) throw InputError("wrap: the mesh has no triangles");
  WrapResult r;
  const double diagonal = bounds(input).size().norm();
  constexpr double kBalls = 40,
                   kOffsets = 30;  // as coarse as keeps an organ's shape; CGAL's own examples use 20 and 30
  r.alpha = options.alpha > 0 ? options.alpha : diagonal / kBalls;
  r.offset = options.offset > 0 ? options.offset : r.alpha / kOffsets;
  if (r.alpha < diagonal * 1e-3)
    throw InputError(text("alpha is ", r.alpha, "; must be at least 1/1000 of the box diagonal, ", diagonal * 1e-3));
  r.mesh = guarded("wrapping", options, [&] { return alpha_wrap_cgal(input, r.alpha, r.offset); });
  r.volume_before = enclosed_volume(input);
  r.volume_after = enclosed_volume(r.mesh);
  r.distance_to_wrap = sampled_distance_cgal(input, r.mesh, r.alpha / 4);
  r.distance_to_input = sampled_distance_cgal(r.mesh, input, r.alpha / 4);
  return r;
#else
  (void)surface;
  needs_cgal("wrapping");
#endif
}

}  // namespace kt
