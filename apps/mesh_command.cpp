#include "apps/mesh_command.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <optional>

#include "apps/console/commands.hpp"
#include "apps/console/words.hpp"
#include "apps/outputs/mesh_report.hpp"
#include "core/base/error.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/mesh/weld.hpp"
#include "io/solid/tetrahedra_quality.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "io/surface/mesh_repair.hpp"

namespace kt {
namespace {

using nlohmann::json;

struct MeshArguments {
  std::string mesh, out, json_file;
  int places = 3;
  bool no_intersections = false;
  RepairOptions repair;
  bool use_wrap = false;
  WrapOptions wrap;
  TetrahedralizeOptions tet;
  double timeout = 120;
};

/// Outputs that cannot be written must fail before the work, not after it.
void check_outputs(const MeshArguments& a) {
  const std::vector<std::string> known = writable_mesh_extensions();
  if (!a.out.empty() && std::find(known.begin(), known.end(), mesh_extension(a.out)) == known.end())
    throw InputError(text(a.out, ": file extension cannot be written; known: ", join(known)));
  claim_output(a.out, "-o");
}

Mesh load(const MeshArguments& a, bool lenient, json& out) {
  std::vector<std::string> notes;
  Mesh mesh = load_mesh(a.mesh, {.lenient = lenient}, &notes);
  for (const std::string& note : notes) std::cout << "  note: " << note << "\n";
  out["file"] = a.mesh;
  out["notes"] = notes;
  return mesh;
}

void finish(const MeshArguments& a, const Mesh& mesh, json& out) {
  if (!a.out.empty()) {
    save_mesh(a.out, mesh);
    std::cout << "written: " << a.out << "\n";
    out["written"] = a.out;
  }
  write_json(a.json_file, json_text(out, 2) + "\n");
}

/// Says which tolerance would join the open edges that lie beside one another; false when none would.
bool offer_to_weld(const Mesh& mesh, const MeshReport& report, json& out) {
  const auto near = report.open_edges.empty() ? std::nullopt : find_near_nodes(mesh);
  if (!near) return false;
  const std::string tolerance = text(near->tolerance);
  std::cout << near->count << " nodes lie at most " << short_number(near->distance)
            << " from another one at an open edge: mesh repair --weld " << tolerance << " joins them (open edges "
            << near->open_edges_before << " -> " << near->open_edges_after << ")\n";
  out["weld"] = {{"nodes", near->count},
                 {"distance", near->distance},
                 {"tolerance", near->tolerance},
                 {"open_edges_before", near->open_edges_before},
                 {"open_edges_after", near->open_edges_after}};
  return true;
}

void info(const MeshArguments& a) {
  check_outputs(a);
  json out;
  std::cout << a.mesh << "\n";
  const Mesh mesh = load(a, true, out);
  const MeshReport report = examine(mesh, {.self_intersections = !a.no_intersections});
  std::cout << report_text(mesh, report, a.places) << (report.clean() ? "no defects found\n" : "");
  offer_to_weld(mesh, report, out);
  out["report"] = report_json(mesh, report);
  finish(a, mesh, out);
}

void print_wrap(const WrapResult& w, bool was_closed) {
  std::cout << "  wrapped with alpha " << w.alpha << ", offset " << w.offset << "\n  volume " << w.volume_before
            << " -> " << w.volume_after;
  if (was_closed && w.volume_before > 0)
    std::cout << " (" << std::showpos << 100 * (w.volume_after / w.volume_before - 1) << std::noshowpos << " %)";
  else
    std::cout << " (the input encloses none)";
  std::cout << "\n  largest distance from the input to the wrap " << w.distance_to_wrap << ", back "
            << w.distance_to_input << "\n";
}

void run_repair(MeshArguments& a) {
  check_outputs(a);
  json out;
  std::cout << a.mesh << "\n";
  const Mesh input = load(a, true, out);
  a.repair.timeout = a.wrap.timeout = a.timeout;
  a.repair.stop = a.wrap.stop = &stop_requested();
  RepairResult repaired = repair(input, a.repair);
  for (const std::string& line : repaired.done) std::cout << "  " << line << "\n";
  if (repaired.done.empty()) std::cout << "  nothing to repair\n";
  out["done"] = repaired.done;
  if (a.use_wrap) {
    const bool was_closed = examine(repaired.mesh, {.self_intersections = false}).closed();
    WrapResult wrapped = wrap(repaired.mesh, a.wrap);
    print_wrap(wrapped, was_closed);
    out["wrap"] = wrap_json(wrapped);
    repaired.mesh = std::move(wrapped.mesh);
  }
  const MeshReport report = examine(repaired.mesh, {.self_intersections = !a.no_intersections});
  std::cout << "result\n" << report_text(repaired.mesh, report, a.places);
  if (report.clean())
    std::cout << "no defects left\n";
  else if (offer_to_weld(repaired.mesh, report, out))
    std::cout << "defects are left: see above\n";
  else
    std::cout << "defects are left: see above" << (a.use_wrap ? "\n" : "; --wrap makes a closed surface of anything\n");
  out["report"] = report_json(repaired.mesh, report);
  finish(a, repaired.mesh, out);
}

void tet(MeshArguments& a) {
  check_outputs(a);
  json out;
  std::cout << a.mesh << "\n";
  const Mesh surface = load(a, false, out);
  a.tet.name = a.mesh;
  a.tet.timeout = a.timeout;
  a.tet.stop = &stop_requested();
  std::vector<std::string> notes;
  a.tet.notes = &notes;
  const auto start = std::chrono::steady_clock::now();
  const Mesh solid = tetrahedralize(surface, a.tet);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (const std::string& note : notes) std::cout << "  " << note << '\n';
  const TetrahedraQuality q = tetrahedra_quality(solid);
  const double surface_volume = enclosed_volume(surface);
  std::cout << "  " << solid.num_nodes() << " nodes, " << solid.tetrahedra.size() << " tetrahedra, "
            << solid.triangles.size() << " surface triangles in " << seconds << " s\n  volume " << q.volume
            << " (surface: " << surface_volume << "), largest radius/edge " << q.radius_edge_max
            << ", smallest dihedral angle " << q.dihedral_min << " degrees\n";
  out["nodes"] = solid.num_nodes();
  out["tetrahedra"] = solid.tetrahedra.size();
  out["triangles"] = solid.triangles.size();
  out["volume"] = q.volume;
  out["surface_volume"] = surface_volume;
  out["radius_edge_max"] = q.radius_edge_max;
  out["dihedral_min_deg"] = q.dihedral_min;
  out["seconds"] = seconds;
  finish(a, solid, out);
}

void add_common(CLI::App& command, MeshArguments& a) {
  command.add_option("MESH", a.mesh, "file: " + join(readable_mesh_extensions()))->required();
  command.add_option("-o,--out", a.out, "write the mesh: " + join(writable_mesh_extensions()));
  add_json_option(command, a.json_file, "the whole result");
}

}  // namespace

void add_mesh_command(CLI::App& app, int& exit_code) {
  const auto a = std::make_shared<MeshArguments>();  // outlives this function with the callbacks
  CLI::App* mesh = app.add_subcommand("mesh", "examine a mesh, repair it, fill it with tetrahedra");
  mesh->require_subcommand(1);

  CLI::App* info_command = mesh->add_subcommand("info", "faults of a mesh, and their places");
  add_common(*info_command, *a);
  info_command->add_option("--places", a->places, "places shown per defect")->check(CLI::Range(0, 1000000));
  info_command->add_flag("--no-intersections", a->no_intersections, "skip the search for self-intersections");
  info_command->footer("Example: kilotouch mesh info meshes/broken/open.off");
  info_command->callback([a, &exit_code] {
    info(*a);
    exit_code = 0;
  });

  CLI::App* repair_command = mesh->add_subcommand("repair", "repair a mesh without changing its shape");
  add_common(*repair_command, *a);
  repair_command->add_option("--places", a->places, "places shown per defect")->check(CLI::Range(0, 1000000));
  repair_command->add_flag("--no-intersections", a->no_intersections, "skip the search for self-intersections");
  repair_command->add_option("--weld", a->repair.weld_tolerance,
                             "largest distance of nodes to join, in the mesh's unit, 0 for equal places");
  repair_command->add_option("--fill-holes", a->repair.fill_holes, "close holes of at most this many edges");
  repair_command->add_flag("--wrap", a->use_wrap,
                           "draw a closed surface around the mesh, which changes the shape a little");
  repair_command->add_option("--alpha", a->wrap.alpha,
                             "with --wrap, size of the ball that closes holes, in the mesh's unit, 0 for diagonal/40");
  repair_command->add_option("--offset", a->wrap.offset,
                             "with --wrap, distance from the mesh, in its unit, 0 for alpha/30");
  repair_command->add_option("--timeout", a->timeout, "limit for filling and wrapping, s");
  repair_command->footer("Example: kilotouch mesh repair liver.obj --wrap -o liver_wrapped.off");
  repair_command->callback([a, &exit_code] {
    run_repair(*a);
    exit_code = 0;
  });

  CLI::App* tet_command = mesh->add_subcommand("tet", "fill a closed surface with tetrahedra");
  add_common(*tet_command, *a);
  std::vector<std::string> names;
  for (const BackendInfo& b : tetrahedralizers())
    names.push_back(b.available ? b.name : b.name + " (not in this build)");
  tet_command->add_option("--backend", a->tet.backend, join(names));
  tet_command->add_option("--max-volume", a->tet.max_volume,
                          "largest volume of a tetrahedron, in the mesh's unit^3, 0 to follow the surface's edges");
  tet_command->add_option("--quality", a->tet.quality, "bound on radius / shortest edge, 1.1 .. 10");
  tet_command->add_option("--timeout", a->timeout, "limit for the backend, s");
  tet_command->footer("Example: kilotouch mesh tet meshes/organ.off --max-volume 1e-7 -o organ.vtu");
  tet_command->callback([a, &exit_code] {
    tet(*a);
    exit_code = 0;
  });
}

}  // namespace kt
