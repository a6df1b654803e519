// TetGen (AGPL-3) as a program, never linked: on bad surfaces version 1.5 crashes, aborts, hangs, or makes nothing and
// reports success.
#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "io/files/child_process.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/solid/tetrahedralize_backends.hpp"

namespace kt {
namespace {

std::string smesh(const Mesh& surface) {
  std::string out = text(surface.num_nodes(), " 3 0 0\n");
  for (int i = 0; i < surface.num_nodes(); ++i) {
    out += std::to_string(i);
    for (int k = 0; k < 3; ++k) append_number(out += ' ', surface.x[3 * i + k]);
    out += '\n';
  }
  out += text(surface.triangles.size(), " 0\n");
  for (const Triangle& t : surface.triangles) out += text("3 ", t[0], ' ', t[1], ' ', t[2], '\n');
  return out + "0\n0\n";  // no holes, no regions
}

}  // namespace

Mesh tetrahedralize_tetgen(const Mesh& surface, const TetrahedralizeOptions& options) {
  const PrivateFolder folder;
  write_file_whole(folder / "in.smesh", smesh(surface));
  // p: fill a surface, Y: keep its triangles, q: quality, a: largest volume. TetGen does not read exponents.
  const std::string switches = "-pYq" + with_decimals(options.quality, 6) + "a" + with_decimals(options.max_volume, 30);
  const ChildLimits limits = child_limits(options);
  const ChildResult run = run_program({"tetgen", switches, "in.smesh"}, folder, limits);
  if (run.exit_code == 127) throw RunError("tetgen: the program is not installed (package tetgen)");
  require_good(run, "tetgen", limits,
               KT_WITH_CGAL ? "" : " (often a surface that intersects itself: only a build with CGAL sees where)");
  try {
    Notes ignored;
    Mesh solid = read_node_ele(folder / "in.1.node", LoadOptions{}, ignored);
    drop_cavities(solid, surface);  // TetGen fills them unless given a point in each
    return solid;
  } catch (const InputError& e) {
    throw RunError(text("tetgen left no usable result: ", e.what()));
  }
}

}  // namespace kt
