// Netgen (LGPL) as a library, in a forked child: it keeps the surface, and ends the process on some bad ones.
#include <cmath>

namespace nglib {
#include <nglib.h>
}

#include "core/error.hpp"
#include "io/child_process.hpp"
#include "io/mesh_formats.hpp"
#include "io/mesh_io.hpp"
#include "io/output_file.hpp"
#include "io/tetrahedralize_backends.hpp"

namespace kt {
namespace {

/// Netgen's absolute tolerances want a mesh of size about 1; a power of two scales without rounding.
double scale_to_one(const Mesh& surface) { return std::ldexp(1.0, -std::ilogb(bounds(surface).size().maxCoeff())); }

/// Runs in the child.
Mesh fill(const Mesh& surface, const TetrahedralizeOptions& options) {
  const double scale = scale_to_one(surface);
  nglib::Ng_Init();
  nglib::Ng_Mesh* const mesh = nglib::Ng_NewMesh();
  for (int i = 0; i < surface.num_nodes(); ++i) {
    Vec3 p = scale * node(surface.x, i);
    nglib::Ng_AddPoint(mesh, p.data());
  }
  for (const Triangle& t : surface.triangles) {
    int corners[3] = {t[0] + 1, t[1] + 1, t[2] + 1};
    nglib::Ng_AddSurfaceElement(mesh, nglib::NG_TRIG, corners);
  }
  nglib::Ng_Meshing_Parameters parameters;
  parameters.maxh = scale * std::cbrt(6 * std::sqrt(2.0) * options.max_volume);  // edge of the regular tetrahedron
  parameters.check_overlap = 0;                                                  // checked exactly before
  const nglib::Ng_Result result = nglib::Ng_GenerateVolumeMesh(mesh, &parameters);
  if (result != nglib::NG_OK) throw RunError(text("gave up with code ", static_cast<int>(result)));
  Mesh out;
  out.x.resize(3 * nglib::Ng_GetNP(mesh));
  for (int i = 0; i < out.num_nodes(); ++i) {
    double p[3];
    nglib::Ng_GetPoint(mesh, i + 1, p);
    for (int k = 0; k < 3; ++k) out.x[3 * i + k] = p[k] / scale;
  }
  for (int i = 1; i <= nglib::Ng_GetNE(mesh); ++i) {
    int c[8];
    nglib::Ng_GetVolumeElement(mesh, i, c);
    out.tetrahedra.push_back({c[0] - 1, c[1] - 1, c[2] - 1, c[3] - 1});
  }
  return out;
}

}  // namespace

Mesh tetrahedralize_netgen(const Mesh& surface, const TetrahedralizeOptions& options) {
  return fill_in_child("netgen", surface, options, fill);
}

}  // namespace kt
