// PLY and STL through OpenMesh's file modules, into a plain list of vertices and faces: its half-edge mesh would change
// non-manifold input in silence. The modules get a file that was checked and written anew, and what they read is
// compared with what it holds, because they report success whatever they are given.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <sstream>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpedantic"
#endif
#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <OpenMesh/Core/IO/reader/PLYReader.hh>
#include <OpenMesh/Core/IO/reader/STLReader.hh>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include "io/mesh_formats.hpp"
#include "io/ply_check.hpp"
#include "io/polygon.hpp"
#include "io/stl_check.hpp"
#include "io/text_reader.hpp"

namespace kt {
namespace {

namespace om = OpenMesh;

/// Takes vertices and faces as they come; everything else a file may carry is dropped.
class SoupImporter final : public om::IO::BaseImporter {
 public:
  std::vector<double> x;
  std::vector<std::vector<int>> faces;

  om::VertexHandle add_vertex(const om::Vec3f& p) override { return add_vertex(om::Vec3d(p)); }
  om::VertexHandle add_vertex(const om::Vec3d& p) override {
    x.insert(x.end(), {p[0], p[1], p[2]});
    return om::VertexHandle(static_cast<int>(x.size() / 3) - 1);
  }
  om::VertexHandle add_vertex() override { return add_vertex(om::Vec3d(0, 0, 0)); }
  om::HalfedgeHandle add_edge(om::VertexHandle, om::VertexHandle) override { return om::HalfedgeHandle(-1); }
  om::FaceHandle add_face(const VHandles& corners) override {
    std::vector<int>& face = faces.emplace_back();
    for (const om::VertexHandle v : corners) face.push_back(v.idx());
    return om::FaceHandle(static_cast<int>(faces.size()) - 1);
  }
  om::FaceHandle add_face(om::HalfedgeHandle) override { return om::FaceHandle(-1); }
  void set_point(om::VertexHandle v, const om::Vec3f& p) override {
    for (int k = 0; k < 3; ++k) x[3 * v.idx() + k] = static_cast<double>(p[k]);
  }
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec2f>&) override {}
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec3f>&) override {}
  void set_face_texindex(om::FaceHandle, int) override {}
  void set_halfedge(om::VertexHandle, om::HalfedgeHandle) override {}
  void set_normal(om::VertexHandle, const om::Vec3f&) override {}
  void set_normal(om::VertexHandle, const om::Vec3d&) override {}
  void set_normal(om::FaceHandle, const om::Vec3f&) override {}
  void set_normal(om::FaceHandle, const om::Vec3d&) override {}
  void set_color(om::VertexHandle, const om::Vec3uc&) override {}
  void set_color(om::VertexHandle, const om::Vec4uc&) override {}
  void set_color(om::VertexHandle, const om::Vec3f&) override {}
  void set_color(om::VertexHandle, const om::Vec4f&) override {}
  void set_color(om::EdgeHandle, const om::Vec3uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec4uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec3f&) override {}
  void set_color(om::EdgeHandle, const om::Vec4f&) override {}
  void set_color(om::FaceHandle, const om::Vec3uc&) override {}
  void set_color(om::FaceHandle, const om::Vec4uc&) override {}
  void set_color(om::FaceHandle, const om::Vec3f&) override {}
  void set_color(om::FaceHandle, const om::Vec4f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec2f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec2f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec3f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec3f&) override {}
  void set_status(om::VertexHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::HalfedgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::EdgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_status(om::FaceHandle, const om::Attributes::StatusInfo&) override {}
  void set_next(om::HalfedgeHandle, om::HalfedgeHandle) override {}
  void set_face(om::HalfedgeHandle, om::FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void add_texture_information(int, std::string) override {}
  std::size_t n_vertices() const override { return x.size() / 3; }
  std::size_t n_faces() const override { return faces.size(); }
  std::size_t n_edges() const override { return 0; }
};

struct Announced {
  long long vertices = -1, faces = -1;  ///< -1: the format does not say
};

/// STL repeats every corner: equal coordinates are one vertex. Exact comparison, in order of first appearance.
void weld(SoupImporter& soup) {
  std::map<std::array<double, 3>, int> known;
  std::vector<double> x;
  std::vector<int> new_index;
  for (std::size_t i = 0; i < soup.x.size(); i += 3) {
    const std::array<double, 3> p{soup.x[i] + 0.0, soup.x[i + 1] + 0.0, soup.x[i + 2] + 0.0};  // -0 becomes 0
    const auto [it, fresh] = known.try_emplace(p, static_cast<int>(x.size() / 3));
    if (fresh) x.insert(x.end(), p.begin(), p.end());
    new_index.push_back(it->second);
  }
  for (std::vector<int>& face : soup.faces)
    for (int& i : face) i = new_index[i];
  soup.x = std::move(x);
}

}  // namespace

Mesh read_ply_or_stl(const std::string& path, const LoadOptions& options, Notes& notes) {
  const std::string data = file_content(path, options);
  const bool stl = mesh_extension(path) == ".stl";
  Announced announced;
  std::istringstream plain;
  if (stl) {
    CheckedStl checked = check_stl(path, data);
    announced.faces = checked.faces;
    plain.str(std::move(checked.data));
  } else {
    CheckedPly checked = check_ply(path, data);
    announced = {checked.vertices, checked.faces};
    plain.str(std::move(checked.data));
  }

  SoupImporter soup;
  om::IO::Options read_options;
  std::ostringstream complaints;  // the library prints them; they belong into our one line
  std::streambuf* const usual = std::cerr.rdbuf(complaints.rdbuf());
  bool good = false;
  std::string reason;
  try {
    if (stl) read_options += om::IO::Options::Binary;
    good =
        stl ? om::IO::STLReader().read(plain, soup, read_options) : om::IO::PLYReader().read(plain, soup, read_options);
  } catch (const std::exception& e) {
    reason = e.what();
  }
  std::cerr.rdbuf(usual);
  if (reason.empty()) reason = complaints.str().substr(0, complaints.str().find('\n'));
  if (!good) throw InputError(text(path, ": OpenMesh cannot read it", reason.empty() ? "" : ": ", reason));

  const auto vertices = static_cast<long long>(soup.x.size() / 3), faces = static_cast<long long>(soup.faces.size());
  if (announced.vertices >= 0 && vertices != announced.vertices)
    throw InputError(text(path, ": the header announces ", announced.vertices, " vertices, ", vertices, " were read"));
  if (stl && faces < announced.faces)  // the size or every corner was checked above: nothing else is left out
    notes.push_back(text(announced.faces - faces, " of ", announced.faces,
                         " triangles have equal corners; OpenMesh leaves them out"));
  else if (faces != announced.faces)
    throw InputError(text(path, ": the file announces ", announced.faces, " faces, ", faces, " were read"));
  if (stl) {
    weld(soup);
    notes.push_back(
        text(3 * faces, " triangle corners joined to ", soup.x.size() / 3, " vertices by equal coordinates"));
  } else {
    notes.push_back("PLY coordinates have the precision of 32-bit floats: OpenMesh reads no other");
  }
  Mesh mesh;
  mesh.x = Eigen::Map<const VectorX>(soup.x.data(), static_cast<Eigen::Index>(soup.x.size()));
  for (Eigen::Index i = 0; i < mesh.x.size() && !options.lenient; ++i)
    if (!std::isfinite(mesh.x[i]))
      throw InputError(
          text(path, ": coordinate ", "xyz"[i % 3], " of vertex ", i / 3, " is ", mesh.x[i], "; must be finite"));
  PolygonTriangulator triangulator;
  for (std::size_t f = 0; f < soup.faces.size(); ++f) {
    if (soup.faces[f].size() < 3)
      throw InputError(text(path, ": face ", f, " has ", soup.faces[f].size(), " corners; must be at least 3"));
    for (const int i : soup.faces[f])
      if (i < 0 || i >= mesh.num_nodes())
        throw InputError(
            text(path, ": vertex index ", i, " of face ", f, " is out of range 0..", mesh.num_nodes() - 1));
    triangulator.add(mesh.x, soup.faces[f], mesh.triangles);
  }
  for (std::string& note : triangulator.notes()) notes.push_back(std::move(note));
  return mesh;
}

}  // namespace kt
