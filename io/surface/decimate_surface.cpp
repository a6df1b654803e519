#include "io/surface/decimate_surface.hpp"

#include "core/base/error.hpp"
#include "io/files/child_process.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {

#if KT_WITH_CGAL
Mesh decimate_surface(const Mesh& surface, int triangles, const DecimateOptions& options) {
  const PrivateFolder folder;
  const std::string file = folder / "out.obj";
  const ChildLimits limits{.seconds = options.timeout, .memory_bytes = std::size_t{8} << 30, .stop = options.stop};
  const ChildResult run =
      run_forked([&] { save_mesh(file, decimate_cgal(surface, triangles, options.evenly)); }, folder, limits);
  require_good(run, "decimation", limits);
  return load_mesh(file);
}
#else
Mesh decimate_surface(const Mesh&, int, const DecimateOptions&) {
  throw InputError("decimation needs CGAL: configure with -DKT_WITH_CGAL=ON");
}
#endif

}  // namespace kt
