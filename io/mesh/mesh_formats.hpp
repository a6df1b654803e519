#pragma once
// One function a file format; mesh_io.cpp picks by extension. Internal to io/.
#include <string>
#include <vector>

#include "core/body/mesh.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {

using Notes = std::vector<std::string>;

/// The bytes of a file, from where the options say.
std::string file_content(const std::string& path, const LoadOptions& options);

/// The same without NULs at its end: some exporters write C's end of string.
std::string text_content(const std::string& path, const LoadOptions& options);

Mesh read_obj(const std::string& path, const LoadOptions& options, Notes& notes);
Mesh read_off(const std::string& path, const LoadOptions& options, Notes& notes);
Mesh read_ply(const std::string& path, const LoadOptions& options, Notes& notes);
Mesh read_stl(const std::string& path, const LoadOptions& options, Notes& notes);
Mesh read_node_ele(const std::string& path, const LoadOptions& options, Notes& notes);
Mesh read_msh(const std::string& path, const LoadOptions& options, Notes& notes);
Mesh read_vtu(const std::string& path, const LoadOptions& options, Notes& notes);
Mesh read_vtk(const std::string& path, const LoadOptions& options, Notes& notes);
Mesh read_medit(const std::string& path, const LoadOptions& options, Notes& notes);

/// What a reader of tetrahedra ends with: takes doubled ones once, orients all of them positive and sets the surface
/// to their boundary.
/// @throws InputError for a flat tetrahedron, unless lenient.
void finish_solid(Mesh& mesh, const std::string& path, const LoadOptions& options, Notes& notes);

/// Removes nodes that no triangle and no tetrahedron uses, keeping the order of the others. Returns how many went.
int drop_unused_nodes(Mesh& mesh);

/// Removes the tetrahedra outside the closed `surface` (in its cavities), when the triangles of the surface, whose
/// nodes come first in `solid`, separate them from those inside.
void drop_cavities(Mesh& solid, const Mesh& surface);

std::string write_obj(const Mesh& mesh);
std::string write_off(const Mesh& mesh);
std::string write_ply(const Mesh& mesh);
std::string write_stl(const Mesh& mesh);  ///< binary
std::string write_msh(const Mesh& mesh);  ///< ASCII 4.1
std::string write_vtu(const Mesh& mesh);

}  // namespace kt
