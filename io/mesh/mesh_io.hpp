#pragma once
// Mesh files to Mesh and back. Surfaces are OBJ, OFF, PLY, STL. Solids are TetGen .node/.ele, Gmsh .msh, VTK's .vtu and
// .vtk, Medit .mesh.
// All are read by our own strict double-precision readers, because every library reader we tried alters bad input in
// silence (drops a line with NaN and shifts all later faces, reads floats...).
#include <functional>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

struct LoadOptions {
  bool lenient = false;  ///< keep NaN and infinite coordinates, flat tetrahedra and empty surfaces, so that they can be
                         ///< reported together (mesh info). An engine must not be given such a mesh
  std::function<std::string(const std::string& path)> read_file = {};  ///< gives a file's bytes, of an archive or in
                                                                       ///< memory, by default from the file system
};

/// Reads a mesh by its extension (.obj .off .ply .stl .node .ele .msh .vtu .vtk .mesh, any case), in the file's own
/// unit. Polygons become triangles. In a file with tetrahedra all are oriented positive and the surface is their
/// boundary, whatever triangles the file lists.
/// @param notes  when given, one sentence is appended for each change of the mesh
/// @throws InputError with file, line, quantity, value and allowed range. For a missing package, the CMake option.
Mesh load_mesh(const std::string& path, const LoadOptions& options = {}, std::vector<std::string>* notes = nullptr);

/// Writes .obj .off .ply .stl .vtu or .msh by extension. The file appears whole or not at all. Surface formats get the
/// triangles (and, of a solid, only the surface nodes). .vtu and .msh get the tetrahedra if there are any.
/// Numbers are written in full. They read back bit for bit, except STL (its format is 32-bit floats).
/// @throws InputError for an unknown extension or a file that cannot be written.
void save_mesh(const std::string& path, const Mesh& mesh);

/// The extensions load_mesh and save_mesh know, for messages and help texts.
std::vector<std::string> readable_mesh_extensions();
std::vector<std::string> writable_mesh_extensions();

/// Lower-case extension with its dot, ".obj".
std::string mesh_extension(const std::string& path);

}  // namespace kt
