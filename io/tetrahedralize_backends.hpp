#pragma once
// What a backend in tetrahedralizer.def implements. Internal to io/.
#include "io/tetrahedralize.hpp"

namespace kt {

/// `surface` is closed, manifold, outward and without unused nodes; options.max_volume is set. The result needs nodes
/// (the surface's own first when the backend keeps the surface) and positive tetrahedra; tetrahedralize() checks the
/// rest. @throws RunError
#define TETRAHEDRALIZER(name, available, option, what) \
  Mesh tetrahedralize_##name(const Mesh& surface, const TetrahedralizeOptions& options);
#include "io/tetrahedralizer.def"
#undef TETRAHEDRALIZER

}  // namespace kt
