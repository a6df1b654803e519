// Files that other programs wrote (gmsh 4.8, meshio 5.0, both by their defaults): nodes, tetrahedra and surfaces as
// they were given to them.
#include <bit>
#include <cstring>

#include "io/files/text_reader.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

std::string seed(const std::string& name) { return std::string(KT_SOURCE_DIR "/tests/fuzz/seeds/") + name; }

/// Two tetrahedra over five nodes; gmsh writes 1/3 with 14 digits in one of its formats.
void check_two_tetrahedra(const std::string& name) {
  std::vector<std::string> notes;
  const Mesh mesh = load_mesh(seed(name), {}, &notes);
  const VectorX x{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1.0 / 3, 1, 1, 1.1}};
  ASSERT_EQ(mesh.x.size(), x.size()) << name;
  EXPECT_LE((mesh.x - x).lpNorm<Eigen::Infinity>(), name == "gmsh.mesh" ? 1e-14 : 0) << name;
  ASSERT_EQ(mesh.tetrahedra.size(), 2u) << name;
  EXPECT_EQ(mesh.tetrahedra[0], (Tetrahedron{0, 1, 2, 3})) << name;
  EXPECT_EQ(mesh.triangles.size(), 6u) << name;
  // By hand: the second one is a sixth of 1/3 + 1.1.
  EXPECT_NEAR(enclosed_volume(mesh), 1.0 / 18 + 4.3 / 18, 1e-14) << name;
}

TEST(OtherTools, GmshAndVtkAndMeditFilesAreReadAsTheyWereWritten) {
  for (const char* name :
       {"gmsh_binary_22.msh", "gmsh_binary_41.msh", "meshio_binary_22.msh", "gmsh.mesh", "meshio.mesh", "gmsh_text.vtk",
        "gmsh_binary.vtk", "meshio_text.vtk", "meshio_binary.vtk", "meshio_binary_42.vtk"})
    check_two_tetrahedra(name);
}

TEST(OtherTools, TrianglesOfVtkAreASurface) {
  const Mesh mesh = load_mesh(seed("meshio_surface.vtk"));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}));
  EXPECT_NEAR(enclosed_volume(mesh), 1.0 / 18, 1e-15);
}

const std::string kPolydata =
    "# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\nTIME 1 1 double\n0.5\n"
    "POINTS 6 float\n0 0 0 1 0 0 1 1 0\n0 1 0 2 0 0 2 1 0\nMETADATA\nINFORMATION 0\n\n"
    "VERTICES 1 2\n1 0\nLINES 1 3\n2 0 1\nPOLYGONS 1 5\n4 0 1 2 3\nTRIANGLE_STRIPS 1 5\n4 1 4 2 5\n"
    "POINT_DATA 6\nSCALARS s float\n";

TEST(Vtk, PolygonsAndStripsBecomeTriangles) {
  const PrivateFolder folder;
  std::vector<std::string> notes;
  const Mesh mesh = load_mesh(write_sample(folder, "a.vtk", kPolydata), {}, &notes);
  EXPECT_EQ(mesh.num_nodes(), 6);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {1, 4, 2}, {4, 5, 2}}));
  EXPECT_EQ(notes[0], "2 point and line elements skipped");
}

std::string replaced(std::string s, const std::string& what, const std::string& by) {
  const std::size_t at = s.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? s : s.replace(at, what.size(), by);
}

TEST(Vtk, NulsAtTheEndOfATextAreNothing) {
  const PrivateFolder folder;
  const std::string body = kPolydata.substr(0, kPolydata.find("\nPOINT_DATA")) + std::string(3, '\0');
  EXPECT_EQ(load_mesh(write_sample(folder, "a.vtk", body)).triangles.size(), 4u);
}

/// As file systems without small letters leave them.
TEST(NodeEle, EitherFileOfThePairMayBeNamedInCapitals) {
  const PrivateFolder folder;
  const char* const nodes = "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
  const char* const elements = "1 4 0\n1 1 2 3 4\n";
  write_sample(folder, "A.NODE", nodes);
  write_sample(folder, "A.ELE", elements);
  write_sample(folder, "b.node", nodes);
  write_sample(folder, "b.ELE", elements);
  for (const char* name : {"A.NODE", "A.ELE", "b.node", "b.ELE"})
    EXPECT_EQ(load_mesh(folder / name).tetrahedra.size(), 1u) << name;
}

const std::string kMedit =
    "MeshVersionFormatted 2\nDimension 3\n# by hand\nVertices\n4\n0 0 0 7\n1 0 0 7\n0 1 0 7\n0 0 1 7\nCorners 2\n1\n2\n"
    "Triangles\n1\n1 3 2 1\nTetrahedra\n1\n1 2 3 4 9\nEnd\n";

TEST(Medit, WhatIsNotKnownOrDoesNotFitIsNamed) {
  const PrivateFolder folder;
  const auto says = [&](const std::string& name, const std::string& content) {
    return input_error(folder, [&] { load_mesh(write_sample(folder, name, content)); });
  };
  EXPECT_EQ(says("a.mesh", kMedit), "");
  EXPECT_EQ(
      says("a.mesh", replaced(kMedit, "Tetrahedra", "Hexahedra")),
      "a.mesh:16: section \"Hexahedra\" is not supported; known: Vertices, Triangles, Quadrilaterals, Tetrahedra, "
      "Edges, and what marks them");
  EXPECT_NE(
      says("a.mesh", replaced(kMedit, "1 2 3 4 9", "1 2 3 5 9")).find("a.mesh:18: a vertex of one of the tetrahedra"),
      std::string::npos);
  EXPECT_NE(says("a.mesh", replaced(kMedit, "\n4\n", "\n4000\n")).find("a.mesh:5: header announces 4000 vertices"),
            std::string::npos);
  EXPECT_NE(says("a.mesh", replaced(kMedit, "1 0 0 7", "1 0 1e200 7"))
                .find("a.mesh:7: a coordinate of vertex 2 is \"1e200\""),
            std::string::npos);
  EXPECT_NE(says("a.mesh", "v 0 0 0\n").find("must start with MeshVersionFormatted"), std::string::npos);
  EXPECT_NE(says("a.vtk", replaced(kPolydata, "4 0 1 2 3", "4 0 1 2 6")).find("node 6 of cell 0 is out of range 0..5"),
            std::string::npos);
  EXPECT_NE(says("a.vtk", replaced(kPolydata, "POLYGONS 1 5", "POLYGONS 1 6")).find("the cells have 5 numbers"),
            std::string::npos);
  EXPECT_NE(says("a.vtk", replaced(kPolydata, "POINTS 6", "POINTS 60000000"))
                .find("a.vtk:8: header announces 60000000 points"),
            std::string::npos);
  EXPECT_NE(
      says("a.vtk", replaced(kPolydata, "POLYDATA", "STRUCTURED_GRID")).find("known: UNSTRUCTURED_GRID, POLYDATA"),
      std::string::npos);
}

/// The bytes of one number, in an order.
template <class T>
std::string bytes_of(T value, std::endian order) {
  std::string out(reinterpret_cast<const char*>(&value), sizeof value);
  if (order != std::endian::native) std::reverse(out.begin(), out.end());
  return out;
}

/// One tetrahedron with nodes 7 8 9 20, in version 2.2 or 4.1.
std::string binary_msh(bool is_version_4, std::endian order) {
  const auto i = [&](std::int32_t value) { return bytes_of(value, order); };
  const auto n = [&](std::uint64_t value) { return bytes_of(value, order); };
  const std::int32_t tags[4] = {7, 8, 9, 20};
  const double x[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1.0 / 3};
  std::string out =
      std::string("$MeshFormat\n") + (is_version_4 ? "4.1" : "2.2") + " 1 8\n" + i(1) + "\n$EndMeshFormat\n";
  if (is_version_4) {
    out += "$Entities\n" + n(0) + "\n$EndEntities\n$Nodes\n" + n(1) + n(4) + n(7) + n(20) + i(3) + i(1) + i(0) + n(4);
    for (const std::int32_t tag : tags) out += n(static_cast<std::uint64_t>(tag));
    for (const double value : x) out += bytes_of(value, order);
    out += "\n$EndNodes\n$Elements\n" + n(1) + n(1) + n(1) + n(1) + i(3) + i(1) + i(4) + n(1) + n(1);
    for (const std::int32_t tag : tags) out += n(static_cast<std::uint64_t>(tag));
  } else {
    out += "$Nodes\n4\n";
    for (int k = 0; k < 4; ++k) {
      out += i(tags[k]);
      for (int c = 0; c < 3; ++c) out += bytes_of(x[3 * k + c], order);
    }
    out += "\n$EndNodes\n$Elements\n2\n" + i(15) + i(1) + i(0) + i(1) + i(7) + i(4) + i(1) + i(2) + i(2) + i(0) + i(1);
    for (const std::int32_t tag : tags) out += i(tag);
  }
  return out + "\n$EndElements\n";
}

TEST(Msh, BinaryFilesAreReadInEitherByteOrder) {
  const PrivateFolder folder;
  for (const bool is_version_4 : {false, true})
    for (const std::endian order : {std::endian::little, std::endian::big}) {
      const std::string content = binary_msh(is_version_4, order);
      const Mesh mesh = load_mesh(write_sample(folder, "a.msh", content));
      EXPECT_EQ(mesh.x, (VectorX{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1.0 / 3}}));
      EXPECT_EQ(mesh.tetrahedra, (std::vector<Tetrahedron>{{0, 1, 2, 3}}));
      const std::size_t end = content.find("$EndElements");
      for (std::size_t n = 1; n < end; ++n)
        EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "b.msh", content.substr(0, n))); }), "")
            << n;
    }
}

TEST(Vtu, BigEndianAppendedArraysAreRead) {
  const PrivateFolder folder;
  const auto i = [](std::int32_t value) { return bytes_of(value, std::endian::big); };
  std::string points, nodes;
  for (const double value : {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0 / 3})
    points += bytes_of(value, std::endian::big);
  for (const std::int32_t node : {0, 1, 2}) nodes += i(node);
  const std::string content =
      "<VTKFile type=\"UnstructuredGrid\" byte_order=\"BigEndian\"><UnstructuredGrid>\n"
      "<Piece NumberOfPoints=\"3\" NumberOfCells=\"1\"><Points>\n"
      "<DataArray type=\"Float64\" format=\"appended\" offset=\"0\"/></Points><Cells>\n"
      "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"appended\" offset=\"76\"/>\n"
      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray>\n"
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">5</DataArray></Cells></Piece></UnstructuredGrid>\n"
      "<AppendedData encoding=\"raw\">\n_" +
      i(72) + points + i(12) + nodes + "\n</AppendedData>\n</VTKFile>\n";
  const Mesh mesh = load_mesh(write_sample(folder, "a.vtu", content));
  EXPECT_EQ(mesh.x, (VectorX{{0, 0, 0, 1, 0, 0, 0, 1, 1.0 / 3}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

}  // namespace
}  // namespace kt
