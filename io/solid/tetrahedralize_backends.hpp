#pragma once
// What a backend in tetrahedralizer.def implements. Internal to io/.
#include "io/files/child_process.hpp"
#include "io/solid/tetrahedralize.hpp"

namespace kt {

/// `surface` is closed, manifold, outward and without unused nodes; options.max_volume is set. The result needs nodes
/// (the surface's own first when the backend keeps the surface) and positive tetrahedra; tetrahedralize() checks the
/// rest. @throws RunError
#define TETRAHEDRALIZER(name, available, option, what) \
  Mesh tetrahedralize_##name(const Mesh& surface, const TetrahedralizeOptions& options);
#include "io/solid/tetrahedralizer.def"

/// Limits that the options ask for.
ChildLimits child_limits(const TetrahedralizeOptions& options);

/// Runs `fill` in a forked child; nodes and tetrahedra come back through a file, the surface is made here.
/// @throws RunError with what the child last said.
Mesh fill_in_child(const std::string& backend, const Mesh& surface, const TetrahedralizeOptions& options,
                   Mesh (*fill)(const Mesh&, const TetrahedralizeOptions&));

}  // namespace kt
