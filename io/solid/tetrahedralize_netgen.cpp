// Netgen (LGPL) as a library, in a forked child: it keeps the surface, and ends the process on some bad ones. The
// library is loaded there and not with the program: it brings 90 others (OpenCASCADE, MPI, Python), 0.2 s of a
// processor at every start.
#include <dlfcn.h>

#include <cmath>
#include <cstddef>
#include <new>

namespace nglib {
#include <nglib.h>
}

#include "core/base/error.hpp"
#include "io/files/child_process.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/solid/tetrahedralize_backends.hpp"

namespace kt {
namespace {

/// Its functions, by the names that the C++ ABI of GCC and Clang gives them; their types are the header's.
class Netgen {
 public:
  Netgen() : library_(dlopen(KT_NETGEN_LIBRARY, RTLD_NOW | RTLD_LOCAL)) {
    if (library_ == nullptr) throw RunError(text("cannot be loaded: ", dlerror()));
    find(init, "_ZN5nglib7Ng_InitEv");
    find(new_mesh, "_ZN5nglib10Ng_NewMeshEv");
    find(add_point, "_ZN5nglib11Ng_AddPointEPPvPd");
    find(add_triangle, "_ZN5nglib20Ng_AddSurfaceElementEPPvNS_23Ng_Surface_Element_TypeEPi");
    find(set_defaults, "_ZN5nglib21Ng_Meshing_ParametersC1Ev");
    find(generate, "_ZN5nglib21Ng_GenerateVolumeMeshEPPvPNS_21Ng_Meshing_ParametersE");
    find(num_points, "_ZN5nglib8Ng_GetNPEPPv");
    find(num_tetrahedra, "_ZN5nglib8Ng_GetNEEPPv");
    find(get_point, "_ZN5nglib11Ng_GetPointEPPviPd");
    find(get_tetrahedron, "_ZN5nglib19Ng_GetVolumeElementEPPviPi");
  }

  decltype(nglib::Ng_Init)* init;
  decltype(nglib::Ng_NewMesh)* new_mesh;
  decltype(nglib::Ng_AddPoint)* add_point;
  decltype(nglib::Ng_AddSurfaceElement)* add_triangle;
  void (*set_defaults)(void* parameters);  // the constructor of Ng_Meshing_Parameters
  decltype(nglib::Ng_GenerateVolumeMesh)* generate;
  decltype(nglib::Ng_GetNP)* num_points;
  decltype(nglib::Ng_GetNE)* num_tetrahedra;
  decltype(nglib::Ng_GetPoint)* get_point;
  decltype(nglib::Ng_GetVolumeElement)* get_tetrahedron;

 private:
  template <class Function>
  void find(Function*& function, const char* name) {
    function = reinterpret_cast<Function*>(dlsym(library_, name));
    if (function == nullptr) throw RunError(text("of another version: ", dlerror()));
  }

  void* library_;  // stays loaded until the child ends
};

/// Netgen's absolute tolerances want a mesh of size about 1; a power of two scales without rounding.
double scale_to_one(const Mesh& surface) { return std::ldexp(1.0, -std::ilogb(bounds(surface).size().maxCoeff())); }

/// Runs in the child.
Mesh fill(const Mesh& surface, const TetrahedralizeOptions& options) {
  const double scale = scale_to_one(surface);
  const Netgen netgen;
  netgen.init();
  nglib::Ng_Mesh* const mesh = netgen.new_mesh();
  for (int i = 0; i < surface.num_nodes(); ++i) {
    Vec3 p = scale * node(surface.x, i);
    netgen.add_point(mesh, p.data());
  }
  for (const Triangle& t : surface.triangles) {
    int corners[3] = {t[0] + 1, t[1] + 1, t[2] + 1};
    netgen.add_triangle(mesh, nglib::NG_TRIG, corners);
  }
  alignas(nglib::Ng_Meshing_Parameters) std::byte room[sizeof(nglib::Ng_Meshing_Parameters)];
  netgen.set_defaults(room);
  auto& parameters = *std::launder(reinterpret_cast<nglib::Ng_Meshing_Parameters*>(room));
  parameters.maxh = scale * std::cbrt(6 * std::sqrt(2.0) * options.max_volume);  // edge of the regular tetrahedron
  parameters.check_overlap = 0;                                                  // checked exactly before
  const nglib::Ng_Result result = netgen.generate(mesh, &parameters);
  if (result != nglib::NG_OK) throw RunError(text("gave up with code ", static_cast<int>(result)));
  Mesh out;
  out.x.resize(3 * netgen.num_points(mesh));
  for (int i = 0; i < out.num_nodes(); ++i) {
    double p[3];
    netgen.get_point(mesh, i + 1, p);
    for (int k = 0; k < 3; ++k) out.x[3 * i + k] = p[k] / scale;
  }
  for (int i = 1; i <= netgen.num_tetrahedra(mesh); ++i) {
    int c[8];
    netgen.get_tetrahedron(mesh, i, c);
    out.tetrahedra.push_back({c[0] - 1, c[1] - 1, c[2] - 1, c[3] - 1});
  }
  return out;
}

}  // namespace

Mesh tetrahedralize_netgen(const Mesh& surface, const TetrahedralizeOptions& options) {
  return fill_in_child("netgen", surface, options, fill);
}

}  // namespace kt
