#pragma once
// A model of cells with a surface embedded in them.
#include <memory>

#include "core/body/deformable_model.hpp"

namespace kt {

/// The cells alone, a mesh of their own. The triangles are those of their boundary.
Mesh without_embedded(const Mesh& mesh);

/// Of fixed nodes those that are no embedded vertices: a copy of a model names these, too.
std::vector<int> own_fixed_nodes(const Mesh& mesh, const std::vector<int>& fixed);

/// The model of the cells as one of the whole mesh: the vertices of the embedded surface are fixed nodes without mass
/// and force, which EmbeddedSurface::follow() places. Refinable where `cells` is.
std::unique_ptr<DeformableModel> embed_surface(Mesh mesh, std::unique_ptr<DeformableModel> cells);

}  // namespace kt
