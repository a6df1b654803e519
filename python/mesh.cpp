#include "apps/outputs/mesh_report.hpp"
#include "haptics/body/check_mesh.hpp"
#include "io/mesh/mesh_io.hpp"
#include "python/bindings.hpp"

namespace kt {
namespace {

using Indices = py::array_t<long long, py::array::c_style | py::array::forcecast>;

/// Rows of `width` indices, all of nodes that are there.
template <class Row>
std::vector<Row> index_rows(const py::object& given, const char* what, int nodes) {
  constexpr auto kWidth = static_cast<py::ssize_t>(std::tuple_size_v<Row>);
  std::vector<Row> out;
  if (given.is_none()) return out;
  const auto array = py::array::ensure(given);
  const bool is_whole = array && (array.dtype().kind() == 'i' || array.dtype().kind() == 'u');  // a float is no index
  if (!is_whole || array.ndim() != 2 || array.shape(1) != kWidth)
    throw InputError(text(what, ": an integer array of shape (n, ", kWidth, ") is needed"));
  const auto values = numbers_in<Indices>(array);
  const auto rows = values.unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    Row row;
    for (py::ssize_t k = 0; k < kWidth; ++k) {
      if (rows(i, k) < 0 || rows(i, k) >= nodes)
        throw InputError(text(what, "[", i, "]: node ", rows(i, k), " is outside 0 .. ", nodes, " - 1"));
      row[static_cast<std::size_t>(k)] = static_cast<int>(rows(i, k));
    }
    out.push_back(row);
  }
  return out;
}

Mesh make_mesh(const py::object& given, const py::object& triangles, const py::object& tetrahedra) {
  const Floats x = numbers_of(given, "x", "an array of shape (n, 3) [m]");
  if (x.ndim() != 2 || x.shape(1) != 3) throw InputError("x: an array of shape (n, 3) is needed [m]");
  Mesh out;
  out.x = Eigen::Map<const VectorX>(x.data(), x.size());
  for (py::ssize_t i = 0; i < x.size(); ++i)
    if (!std::isfinite(out.x[i])) throw InputError(text("x[", i / 3, "]: ", out.x[i], " is not finite"));
  out.triangles = index_rows<Triangle>(triangles, "triangles", out.num_nodes());
  out.tetrahedra = index_rows<Tetrahedron>(tetrahedra, "tetrahedra", out.num_nodes());
  check_and_orient(out, "Mesh");
  return out;
}

template <class Row>
py::array_t<int> index_array(const std::vector<Row>& rows) {
  const auto width = std::tuple_size_v<Row>;
  py::array_t<int> out({rows.size(), width});
  auto to = out.mutable_unchecked<2>();
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = 0; k < width; ++k) to(static_cast<py::ssize_t>(i), static_cast<py::ssize_t>(k)) = rows[i][k];
  return out;
}

}  // namespace

py::array_t<double> rows_of(const VectorX& x) {
  py::array_t<double> out({x.size() / 3, Eigen::Index{3}});
  std::copy_n(x.data(), x.size(), out.mutable_data());
  return out;
}

void bind_mesh(py::module_& m) {
  py::class_<Mesh>(m, "Mesh", "Rest places and triangles of a surface, and the tetrahedra of a solid. SI units.")
      .def(py::init(&make_mesh), py::arg("x"), py::arg("triangles") = py::none(), py::arg("tetrahedra") = py::none(),
           "x is (n, 3) [m], triangles (m, 3), counter-clockwise from outside, without them the tetrahedra's faces, "
           "tetrahedra (k, 4), turned to positive volume. All are copied. InputError with quantity, place and value.")
      .def_property_readonly(
          "x", [](const Mesh& mesh) { return rows_of(mesh.x); }, "(n, 3) [m], a copy")
      .def_property_readonly(
          "triangles", [](const Mesh& mesh) { return index_array(mesh.triangles); }, "(m, 3), a copy")
      .def_property_readonly(
          "tetrahedra", [](const Mesh& mesh) { return index_array(mesh.tetrahedra); }, "(k, 4), a copy")
      .def(
          "report", [](const Mesh& mesh) { return report_text(mesh, examine(mesh), 3); },
          "Size, counts and every defect, as `kilotouch mesh info` prints them.")
      .def(
          "save", [](const Mesh& mesh, const py::object& path) { save_mesh(path_of(path), mesh); }, py::arg("path"),
          "Writes by extension, .obj .off .ply .stl .vtu .msh. The file appears whole or not at all.")
      .def(py::pickle(
          [](const Mesh& mesh) {
            return py::make_tuple(rows_of(mesh.x), index_array(mesh.triangles), index_array(mesh.tetrahedra));
          },
          [](const py::tuple& s) {
            if (s.size() != 3) throw InputError("Mesh: pickled by another version");
            return make_mesh(s[0], s[1], s[2]);
          }))
      .def("__repr__", [](const Mesh& mesh) {
        return text("<kilotouch.Mesh: ", mesh.num_nodes(), " nodes, ", mesh.triangles.size(), " triangles, ",
                    mesh.tetrahedra.size(), " tetrahedra>");
      });
  m.def(
      "load_mesh",
      [](const py::object& path, double scale) {
        Mesh mesh = load_mesh(path_of(path));
        if (!(scale > 0) || !std::isfinite(scale)) throw InputError(text("scale: ", scale, ", must be above 0 [m]"));
        mesh.x *= scale;
        return mesh;
      },
      py::arg("path"), py::arg("scale") = 1.0,
      "A mesh file (.obj .off .ply .stl .node .msh .vtu .vtk .mesh). scale is one unit of it [m].");
}

}  // namespace kt
