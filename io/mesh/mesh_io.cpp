#include "io/mesh/mesh_io.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "io/files/output_file.hpp"
#include "io/files/text_reader.hpp"
#include "io/mesh/mesh_formats.hpp"

namespace kt {
namespace {

struct Format {
  std::vector<std::string> extensions;
  Mesh (*read)(const std::string&, const LoadOptions&, Notes&);
  std::string (*write)(const Mesh&);
  bool solid;  ///< can hold tetrahedra
};

const std::vector<Format>& formats() {
  static const std::vector<Format> table = {
      {{".obj"}, read_obj, write_obj, false},
      {{".off"}, read_off, write_off, false},
      {{".ply"}, read_ply, write_ply, false},
      {{".stl"}, read_stl, write_stl, false},
      {{".node", ".ele"}, read_node_ele, nullptr, true},
      {{".msh"}, read_msh, write_msh, true},
      {{".vtu"}, read_vtu, write_vtu, true},
      {{".vtk"}, read_vtk, nullptr, true},
      {{".mesh"}, read_medit, nullptr, true},
  };
  return table;
}

const Format& format_of(const std::string& path, bool to_write) {
  const std::string extension = mesh_extension(path);
  for (const Format& f : formats())
    if (std::find(f.extensions.begin(), f.extensions.end(), extension) != f.extensions.end() && (!to_write || f.write))
      return f;
  throw InputError(text(path, ": file extension ", extension.empty() ? "(none)" : extension,
                        to_write ? " cannot be written; known: " : " is not a mesh format; known: ",
                        join(to_write ? writable_mesh_extensions() : readable_mesh_extensions())));
}

/// Of a solid, a surface file gets the surface's nodes only: interior nodes would be isolated vertices there.
Mesh surface_of_solid(const Mesh& mesh) {
  Mesh out{mesh.x, mesh.triangles, {}};
  drop_unused_nodes(out);
  return out;
}

/// What no reader may let through, whatever its format.
void check_coordinates(const Mesh& mesh, const std::string& path, const LoadOptions& options) {
  for (Eigen::Index i = 0; i < mesh.x.size(); ++i) {
    const double value = mesh.x[i];
    if (std::isfinite(value) ? std::abs(value) < kLargestCoordinate : options.lenient) continue;
    throw InputError(text(path, ": coordinate ", "xyz"[i % 3], " of node ", i / 3, " is ", value,
                          "; must be finite and below ", kLargestCoordinate));
  }
}

}  // namespace

std::string file_content(const std::string& path, const LoadOptions& options) {
  std::string data = options.read_file ? options.read_file(path) : read_whole_file(path);
  if (data.starts_with(std::string_view("\0\5\26\7", 4)))
    throw InputError(text(path, ": is what a Mac keeps beside a file (AppleDouble, \"._\"), not the mesh itself"));
  return data;
}

std::string text_content(const std::string& path, const LoadOptions& options) {
  std::string data = file_content(path, options);
  while (!data.empty() && data.back() == '\0') data.pop_back();
  return data;
}

std::string mesh_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = lower(c);
  return extension;
}

std::vector<std::string> readable_mesh_extensions() {
  std::vector<std::string> out;
  for (const Format& f : formats()) out.insert(out.end(), f.extensions.begin(), f.extensions.end());
  return out;
}

std::vector<std::string> writable_mesh_extensions() {
  std::vector<std::string> out;
  for (const Format& f : formats())
    if (f.write) out.insert(out.end(), f.extensions.begin(), f.extensions.end());
  return out;
}

Mesh load_mesh(const std::string& path, const LoadOptions& options, std::vector<std::string>* notes) {
  Notes own_notes;
  Mesh mesh = format_of(path, false).read(path, options, notes ? *notes : own_notes);
  check_coordinates(mesh, path, options);
  if (mesh.num_nodes() == 0) throw InputError(text(path, ": the mesh is empty: it has no vertices"));
  if (mesh.triangles.empty() && mesh.tetrahedra.empty() && !options.lenient)
    throw InputError(text(path, ": the mesh has ", mesh.num_nodes(), " vertices but no faces"));
  return mesh;
}

void save_mesh(const std::string& path, const Mesh& mesh) {
  const Format& format = format_of(path, true);
  const bool reduce = !format.solid && !mesh.tetrahedra.empty();
  write_named_file(path, format.write(reduce ? surface_of_solid(mesh) : mesh));
}

}  // namespace kt
