#include "io/solid/tetrahedralize.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.hpp"
#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/solid/tetrahedralize_backends.hpp"
#include "io/surface/mesh_doctor.hpp"

namespace kt {
namespace {

using Backend = Mesh (*)(const Mesh&, const TetrahedralizeOptions&);

// The name of a missing backend must not be linked: the macro's 0 or 1 picks the right entry.
#define KT_ENTRY_0(name) nullptr
#define KT_ENTRY_1(name) tetrahedralize_##name
#define KT_ENTRY_(available, name) KT_ENTRY_##available(name)
#define KT_ENTRY(available, name) KT_ENTRY_(available, name)

bool keeps_surface(const std::string& backend) { return backend != "cgal"; }

Backend find_backend(const std::string& name) {
#define TETRAHEDRALIZER(known, available, option, what) \
  if (name == #known) return KT_ENTRY(available, known);
#include "io/solid/tetrahedralizer.def"
  return nullptr;
}

/// That may fill a surface: the named one, or all of this build that keep the surface.
std::vector<std::string> candidates(const std::string& wanted) {
  if (!wanted.empty()) {
    require_backend("tetrahedralizer", wanted, tetrahedralizers());
    return {wanted};
  }
  std::vector<std::string> keeping, all;
  for (const BackendInfo& b : tetrahedralizers()) {
    if (!b.available) continue;
    all.emplace_back(b.name);
    if (keeps_surface(b.name)) keeping.emplace_back(b.name);
  }
  if (all.empty())
    throw InputError(
        "no tetrahedralizer is in this build: configure with -DKT_WITH_TETGEN=ON (or KT_WITH_NETGEN, KT_WITH_CGAL)");
  return keeping.empty() ? all : keeping;
}

std::string not_among(const std::vector<std::string>& tried) {
  std::vector<std::string> out;
  for (const BackendInfo& b : tetrahedralizers())
    if (b.available && std::ranges::find(tried, b.name) == tried.end()) out.emplace_back(b.name);
  return join(out);
}

void check_options(const TetrahedralizeOptions& o) {
  if (!(o.max_volume >= 0) || !std::isfinite(o.max_volume))
    throw InputError(text("tetrahedralize: max_volume is ", o.max_volume, " m^3; must be >= 0 (0: automatic)"));
  if (!(o.quality >= 1.1 && o.quality <= 10))
    throw InputError(text("tetrahedralize: quality is ", o.quality, "; must be in 1.1 .. 10"));
  if (!(o.timeout > 0) || !std::isfinite(o.timeout))
    throw InputError(text("tetrahedralize: timeout is ", o.timeout, " s; must be > 0"));
  if (!(o.memory_gb > 0 && o.memory_gb <= 1024))
    throw InputError(text("tetrahedralize: memory_gb is ", o.memory_gb, "; must be in (0, 1024]"));
}

/// Says what is wrong with the surface and where, before a backend stumbles over it.
void check_surface(const Mesh& surface, const std::string& name) {
  if (!surface.tetrahedra.empty()) throw InputError(name + ": the mesh already has tetrahedra");
  if (surface.triangles.empty()) throw InputError(name + ": the mesh has no triangles");
  MeshReport report = examine(surface, {.self_intersections = false});
  const auto refuse = [&](const char* what, const std::vector<MeshPlace>& places, const char* advice) {
    if (places.empty()) return;
    throw InputError(text(name, ": the surface ", what, " in ", places.size(),
                          places.size() == 1 ? " place" : " places", ": ", places.size() == 1 ? "" : "first ",
                          describe(places[0]), "; ", advice));
  };
  constexpr const char* kRepair = "try mesh repair";
  constexpr const char* kWrap = "try mesh repair, or mesh repair --wrap";
  refuse("has NaN or infinite coordinates", report.non_finite, kRepair);
  refuse("has triangles without area", report.degenerate, kWrap);
  refuse("has triangles that occur twice", report.duplicates, kRepair);
  refuse("has edges of three or more triangles", report.nonmanifold_edges, kWrap);  // these leave open edges, too
  refuse("is open", report.open_edges, "try mesh repair, mesh repair --fill-holes N or mesh repair --wrap");
  refuse("has nodes where several fans of triangles touch", report.nonmanifold_nodes, kRepair);
  refuse("cannot be oriented", report.one_sided, "try mesh repair --wrap");
  refuse("has triangles turned the wrong way", report.flipped, kRepair);
  refuse("is inside out", report.inside_out, kRepair);
  refuse("has one piece inside another, both outward,", report.nested,
         "remove one, or turn the inner one to make a cavity");
#if KT_WITH_CGAL
  constexpr std::size_t kEnough = 1000;  // more places tell the user nothing more
  report = examine(surface, {.self_intersections = true, .max_intersections = kEnough});
  refuse("crosses itself", report.self_intersections, "try mesh repair --wrap");
#endif
}

/// The same triangle whatever corner it starts with, with its orientation.
Triangle rotated(const Triangle& t) {
  const auto smallest = std::min_element(t.begin(), t.end()) - t.begin();
  return {t[smallest], t[(smallest + 1) % 3], t[(smallest + 2) % 3]};
}

bool same_triangles(const std::vector<Triangle>& a, const std::vector<Triangle>& b) {
  if (a.size() != b.size()) return false;
  std::set<Triangle> set;
  for (const Triangle& t : a) set.insert(rotated(t));
  return std::all_of(b.begin(), b.end(), [&](const Triangle& t) { return set.count(rotated(t)) > 0; });
}

/// The surface's nodes come first, up to the decimals a text format may lose: puts back the exact coordinates.
void restore_surface(const std::string& backend, const Mesh& surface, Mesh& solid) {
  constexpr double kTextRoundoff = 1e-12;  // TetGen writes 16 digits
  const double size = bounds(surface).size().norm();
  const Eigen::Index n = surface.x.size();
  if (solid.x.size() < n || !solid.x.allFinite() ||
      (solid.x.head(n) - surface.x).lpNorm<Eigen::Infinity>() > kTextRoundoff * size)
    throw RunError(text(backend, " moved or dropped nodes of the surface"));
  solid.x.head(n) = surface.x;
  if (!same_triangles(solid.triangles, surface.triangles))
    throw RunError(text(backend, " did not keep the surface: it has ", surface.triangles.size(),
                        " triangles, the result ", solid.triangles.size()));
  solid.triangles = surface.triangles;  // the caller's order
}

void check_result(const std::string& backend, const Mesh& surface, const Mesh& solid, double tolerance) {
  if (solid.tetrahedra.empty()) throw RunError(text(backend, " made no tetrahedra"));
  double total = 0;
  for (std::size_t i = 0; i < solid.tetrahedra.size(); ++i) {
    const double volume = tetrahedron_volume(solid.x, solid.tetrahedra[i]);
    if (!(volume > 0)) throw RunError(text(backend, " made a tetrahedron of volume ", volume, " m^3 (number ", i, ")"));
    total += volume;
  }
  const double expected = enclosed_volume(surface);
  if (!(std::abs(total - expected) <= tolerance * expected))
    throw RunError(text(backend, ": the tetrahedra fill ", total, " m^3, the surface encloses ", expected, " m^3"));
}

}  // namespace

std::vector<BackendInfo> tetrahedralizers() {
  return {
#define TETRAHEDRALIZER(name, available, option, what) {#name, what, available, option},
#include "io/solid/tetrahedralizer.def"
  };
}

ChildLimits child_limits(const TetrahedralizeOptions& options) {
  constexpr double kGigabyte = 1073741824.0;
  return {.seconds = options.timeout,
          .memory_bytes = static_cast<std::size_t>(options.memory_gb * kGigabyte),
          .stop = options.stop};
}

Mesh fill_in_child(const std::string& backend, const Mesh& surface, const TetrahedralizeOptions& options,
                   Mesh (*fill)(const Mesh&, const TetrahedralizeOptions&)) {
  const PrivateFolder folder;
  const std::string file = folder / "out.vtu";
  const ChildLimits limits = child_limits(options);
  const ChildResult run = run_forked([&] { save_mesh(file, fill(surface, options)); }, folder, limits);
  require_good(run, backend, limits);
  try {
    return load_mesh(file);
  } catch (const InputError& e) {
    throw RunError(text(backend, " left no usable result: ", e.what()));
  }
}

double automatic_max_volume(const Mesh& surface) {
  double sum_sq = 0;
  for (const Triangle& t : surface.triangles)
    for (int k = 0; k < 3; ++k) sum_sq += (node(surface.x, t[k]) - node(surface.x, t[(k + 1) % 3])).squaredNorm();
  const double edge =
      std::sqrt(sum_sq / (3.0 * static_cast<double>(std::max<std::size_t>(1, surface.triangles.size()))));
  return 1.5 * edge * edge * edge / (6.0 * std::sqrt(2.0));
}

namespace {

/// More tetrahedra than the mesher's memory can hold are refused before it runs out of it, after minutes.
void require_room(const Mesh& surface, const TetrahedralizeOptions& o) {
  constexpr double kLeast = 100;  // bytes of a tetrahedron in any mesher
  const double volume = enclosed_volume(surface), most = static_cast<double>(child_limits(o).memory_bytes) / kLeast;
  if (volume > most * o.max_volume)
    throw InputError(text(o.name, ": max_volume is ", o.max_volume, " m^3, which makes ",
                          short_number(volume / o.max_volume), " tetrahedra of the ", short_number(volume),
                          " m^3 inside; must be at least ", short_number(volume / most),
                          " m^3 (usual: ", short_number(automatic_max_volume(surface)), ")"));
}

/// @throws RunError naming it
Mesh fill_by(const std::string& backend, const Mesh& surface, const TetrahedralizeOptions& options) {
  Mesh solid = find_backend(backend)(surface, options);
  const bool keeps = keeps_surface(backend);
  if (keeps && !solid.tetrahedra.empty()) restore_surface(backend, surface, solid);
  constexpr double kExact = 1e-9, kRemeshed = 0.1;  // [-] of the volume
  check_result(backend, surface, solid, keeps ? kExact : kRemeshed);
  return solid;
}

}  // namespace

Mesh tetrahedralize(const Mesh& surface, const TetrahedralizeOptions& options) {
  check_options(options);
  const std::vector<std::string> backends = candidates(options.backend);
  check_surface(surface, options.name);
  Mesh input{surface.x, surface.triangles, {}};
  drop_unused_nodes(input);
  TetrahedralizeOptions settings = options;
  if (settings.max_volume == 0) settings.max_volume = automatic_max_volume(input);
  require_room(input, settings);
  std::string failures;
  for (const std::string& backend : backends) try {
      Mesh solid = fill_by(backend, input, settings);
      if (!failures.empty() && options.notes) options.notes->push_back(text(failures, "; filled by ", backend));
      return solid;
    } catch (const ChildStopped&) {
      throw;
    } catch (const RunError& e) {
      failures += text(failures.empty() ? "" : "; ", e.what());
    }
  const std::string others = not_among(backends);
  throw RunError(others.empty() ? failures : text(failures, "; another tetrahedralizer may fill it: ", others));
}

}  // namespace kt
