#include "io/mesh/format/vtu.hpp"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>

#include "core/base/error.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_formats.hpp"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "VTU files are written little-endian");

constexpr std::int32_t kTriangleCell = 5, kTetrahedronCell = 10;  // VTK's numbers

/// The appended block: each array is its length in bytes (UInt64) and its values.
struct Appended {
  std::string bytes;
  template <class T>
  std::size_t add(const T* values, std::size_t n) {
    const std::size_t offset = bytes.size();
    const std::uint64_t length = n * sizeof(T);
    bytes.append(reinterpret_cast<const char*>(&length), sizeof length);
    bytes.append(reinterpret_cast<const char*>(values), static_cast<std::size_t>(length));
    return offset;
  }
};

std::string escaped(const std::string& s) {
  std::string out;
  for (const char c : s) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string data_array(const std::string& type, const std::string& name, int components, std::size_t offset) {
  return text("<DataArray type=\"", type, "\" Name=\"", escaped(name), "\" NumberOfComponents=\"", components,
              "\" format=\"appended\" offset=\"", offset, "\"/>\n");
}

template <class Cell>
std::string cells(const std::vector<Cell>& list, std::int32_t cell_type, Appended& data) {
  std::vector<std::int32_t> connectivity;
  std::vector<std::int64_t> offsets;
  for (const Cell& cell : list) {
    connectivity.insert(connectivity.end(), cell.begin(), cell.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  const std::vector<std::uint8_t> types(list.size(), static_cast<std::uint8_t>(cell_type));
  return "<Cells>\n" + data_array("Int32", "connectivity", 1, data.add(connectivity.data(), connectivity.size())) +
         data_array("Int64", "offsets", 1, data.add(offsets.data(), offsets.size())) +
         data_array("UInt8", "types", 1, data.add(types.data(), types.size())) + "</Cells>\n";
}

}  // namespace

std::string vtu_text(const Mesh& mesh, const VectorX& x, const std::vector<PointField>& fields) {
  const Eigen::Index n = mesh.num_nodes();
  if (x.size() != 3 * n)
    throw InputError(text("vtu: ", x.size(), " position values for ", n, " nodes; must be ", 3 * n));
  const bool solid = !mesh.tetrahedra.empty();
  Appended data;
  std::string points = "<PointData>\n";
  for (const PointField& f : fields) {
    if (f.values.size() != n && f.values.size() != 3 * n)
      throw InputError(
          text("vtu: field \"", f.name, "\" has ", f.values.size(), " values; must be ", n, " or ", 3 * n));
    points += data_array("Float64", f.name, f.values.size() == n ? 1 : 3,
                         data.add(f.values.data(), static_cast<std::size_t>(f.values.size())));
  }
  points += "</PointData>\n<Points>\n" +
            data_array("Float64", "x", 3, data.add(x.data(), static_cast<std::size_t>(x.size()))) + "</Points>\n";
  const std::string topology =
      solid ? cells(mesh.tetrahedra, kTetrahedronCell, data) : cells(mesh.triangles, kTriangleCell, data);
  // The newline before </AppendedData> is needed: without it strict XML readers lose the last byte.
  return text(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"",
      n, "\" NumberOfCells=\"", solid ? mesh.tetrahedra.size() : mesh.triangles.size(), "\">\n", points, topology,
      "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_", data.bytes,
      "\n</AppendedData>\n</VTKFile>\n");
}

void save_vtu(const std::string& path, const Mesh& mesh, const VectorX& x, const std::vector<PointField>& fields) {
  write_file_whole(path, vtu_text(mesh, x, fields));
}

std::string write_vtu(const Mesh& mesh) { return vtu_text(mesh, mesh.x); }

PvdSeries::PvdSeries(std::string path) : path_(std::move(path)) {
  if (mesh_extension(path_) != ".pvd") throw InputError(text(path_, ": a series must end in .pvd"));
}

void PvdSeries::add(double t, const Mesh& mesh, const VectorX& x, const std::vector<PointField>& fields) {
  namespace fs = std::filesystem;
  char number[24];
  std::snprintf(number, sizeof number, "_%06d.vtu", count_);
  const fs::path series(path_);
  const std::string name = series.stem().string() + number;
  save_vtu((series.parent_path() / name).string(), mesh, x, fields);
  entries_ += "<DataSet timestep=\"";
  append_number(entries_, t);
  entries_ += "\" part=\"0\" file=\"" + escaped(name) + "\"/>\n";
  ++count_;
  write_file_whole(path_,
                   "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
                   "byte_order=\"LittleEndian\">\n<Collection>\n" +
                       entries_ + "</Collection>\n</VTKFile>\n");
}

}  // namespace kt
