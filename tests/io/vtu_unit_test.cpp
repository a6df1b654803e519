#include "io/mesh/format/vtu.hpp"

#include <cstring>

#include "io/files/text_reader.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

Mesh solid() {
  Mesh mesh = tetrahedron_surface();
  mesh.tetrahedra = {{0, 1, 2, 3}};
  return mesh;
}

TEST(Vtu, TheRawBlockHoldsTheFieldsAtTheirOffsets) {
  const Mesh mesh = solid();
  const VectorX heat{{1.5, -2, 3, 4}};
  const std::string file = vtu_text(mesh, mesh.x, {{"v", 2 * mesh.x}, {"heat & \"co\"", heat}});
  const std::size_t raw =
      file.find("<AppendedData encoding=\"raw\">\n_") + std::strlen("<AppendedData encoding=\"raw\">\n_");
  std::uint64_t length = 0;
  std::memcpy(&length, file.data() + raw, sizeof length);
  EXPECT_EQ(length, 12 * sizeof(double));
  const std::size_t second = raw + 8 + 96;
  std::memcpy(&length, file.data() + second, sizeof length);
  EXPECT_EQ(length, 4 * sizeof(double));
  EXPECT_EQ(std::memcmp(file.data() + second + 8, heat.data(), 32), 0);
  EXPECT_NE(file.find("Name=\"heat &amp; &quot;co&quot;\" NumberOfComponents=\"1\" format=\"appended\" offset=\"104\""),
            std::string::npos);
  EXPECT_TRUE(file.ends_with("\n</AppendedData>\n</VTKFile>\n"));
}

TEST(Vtu, WrongLengthsAreRefused) {
  const Mesh mesh = solid();
  EXPECT_THROW(vtu_text(mesh, VectorX::Zero(9)), InputError);
  EXPECT_THROW(vtu_text(mesh, mesh.x, {{"f", VectorX::Zero(5)}}), InputError);
}

const char* const kHead =
    "<?xml version='1.0'?>\n<!-- by <hand> -->\n<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\"";
const char* const kPiece =
    ">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" NumberOfCells=\"2\">\n<PointData/>\n<Points>\n";

TEST(Vtu, AsciiArraysAreRead) {
  const PrivateFolder folder;
  const std::string content =
      std::string(kHead) + kPiece +
      "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0 1 0 0\n0 1 0 0 0 "
      "1\n</DataArray>\n</Points>\n"
      "<Cells>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 2 1 3 0 1</DataArray>\n"
      "<DataArray Name=\"offsets\" type=\"Int32\" format=\"ascii\"> 4 6 </DataArray>\n"
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 3</DataArray>\n</Cells>\n"
      "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  std::vector<std::string> notes;
  const Mesh mesh = load_mesh(write_sample(folder, "a.vtu", content), {}, &notes);
  ASSERT_EQ(mesh.tetrahedra.size(), 1u);
  EXPECT_GT(tetrahedron_volume(mesh.x, mesh.tetrahedra[0]), 0);
  EXPECT_EQ(notes.size(), 2u);  // the line was skipped, the tetrahedron turned

  std::string broken = content;
  broken.replace(broken.find("0 2 1 3"), 7, "0 2 1 9");
  EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "b.vtu", broken)); })
                .find("b.vtu:14: point 9 of cell 0 is no integer in the range 0..3"),
            std::string::npos);
  broken = content;
  broken.replace(broken.find("10 3<"), 4, "12 3");
  EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "b.vtu", broken)); })
                .find("cell 0 has type 12; known: points and lines"),
            std::string::npos);
  broken = content;
  broken.replace(broken.find("byte_order"), 10, "compressor=\"vtkLZ4DataCompressor\" byte_order");
  EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "b.vtu", broken)); })
                .find("\"vtkLZ4DataCompressor\" is not supported; known: vtkZLibDataCompressor"),
            std::string::npos);
}

/// A tetrahedron with one thing replaced.
std::string said_of_tetrahedron(const std::string& what, const std::string& by) {
  std::string content =
      "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n"
      "<Points>\n<DataArray>0 0 0 1 0 0 0 1 0 0 0 1</DataArray>\n</Points>\n<Cells>\n"
      "<DataArray Name=\"connectivity\">0 1 2 3</DataArray>\n<DataArray Name=\"offsets\">4</DataArray>\n"
      "<DataArray Name=\"types\">10</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  content.replace(content.find(what), what.size(), by);
  const PrivateFolder folder;
  return input_error(folder, [&] { load_mesh(write_sample(folder, "a.vtu", content)); });
}

/// ParaView writes keys into every array; a comment may hold any words.
TEST(Vtu, KeysInsideArraysAndWordsInCommentsChangeNothing) {
  const PrivateFolder folder;
  const std::string keys =
      "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\" length=\"1\">\n<Value index=\"0\">\n1\n"
      "</Value>\n</InformationKey>\n</DataArray>\n";
  const auto array = [&](const std::string& name, const std::string& values) {
    return "<DataArray type=\"Float64\" Name=\"" + name + "\" format=\"ascii\">\n" + values + "\n" + keys;
  };
  const std::string content = "<!-- <AppendedData encoding=\"raw\">_ <Piece> -->\n" + std::string(kHead) + kPiece +
                              array("p", "0 0 0 1 0 0 0 1 0 0 0 1") + "</Points>\n<Cells>\n" +
                              array("connectivity", "0 1 2 3 0 1") + array("offsets", "4 6") + array("types", "10 3") +
                              "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  const Mesh mesh = load_mesh(write_sample(folder, "a.vtu", content));
  EXPECT_EQ(mesh.num_nodes(), 4);
  EXPECT_EQ(mesh.tetrahedra, (std::vector<Tetrahedron>{{0, 1, 2, 3}}));
}

TEST(Vtu, NumbersThatAreNoIndicesAreRefused) {
  EXPECT_EQ(said_of_tetrahedron("Name", "Name"), "");
  EXPECT_NE(said_of_tetrahedron("1 2 3<", "1 2 2.5<").find("point 2.5 of cell 0 is no integer"), std::string::npos);
  EXPECT_NE(
      said_of_tetrahedron("0 0 1<", "0 0 -1e200<").find("a.vtu:5: coordinate z of point 3 is -1e+200; must be finite"),
      std::string::npos);
  EXPECT_NE(said_of_tetrahedron(">4<", ">3.5<").find("offset 3.5 of cell 0 is no integer"), std::string::npos);
  EXPECT_NE(said_of_tetrahedron(">10<", ">1e300<").find("cell 0 has type 1e+300"), std::string::npos);
  EXPECT_NE(said_of_tetrahedron(">10<", ">nan<").find("cell 0 has type nan"), std::string::npos);
}

TEST(Vtu, ACountThatOverflowsIsRefused) {  // three times it is 11, modulo 2^64
  EXPECT_NE(said_of_tetrahedron("Points=\"4\"", "Points=\"6148914691236517209\"").find("the file has only"),
            std::string::npos);
}

TEST(Vtu, InlineBase64ArraysAreRead) {
  // UInt32 lengths, then the values, as VTK writes "binary": 4 points, 1 triangle.
  const PrivateFolder folder;
  const std::string points = "MAAAAA==AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/";
  const std::string content =
      std::string(kHead) + kPiece + "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"binary\">\n" +
      points +
      "\n</DataArray>\n</Points>\n"
      "<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" "
      "format=\"binary\">GAAAAA==AAAAAAEAAAACAAAAAAAAAAEAAAADAAAA</DataArray>\n"
      "<DataArray type=\"Int32\" Name=\"offsets\" format=\"binary\">CAAAAAMAAAAGAAAA</DataArray>\n"
      "<DataArray type=\"UInt8\" Name=\"types\" format=\"binary\">AgAAAAUF</DataArray>\n</Cells>\n"
      "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  const Mesh mesh = load_mesh(write_sample(folder, "a.vtu", content));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 1, 3}}));
  EXPECT_EQ(mesh.x, (VectorX{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}}));
}

TEST(Vtu, EveryCutIsNoticed) {
  const Mesh mesh = solid();
  const std::string whole = vtu_text(mesh, mesh.x);
  const PrivateFolder folder;
  const std::size_t last = whole.find("\n</AppendedData>");
  for (std::size_t n = 1; n < last; n += 7)
    EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "a.vtu", whole.substr(0, n))); }), "") << n;
}

TEST(Pvd, TheSeriesIsCompleteAfterEveryState) {
  const PrivateFolder folder;
  const Mesh mesh = solid();
  PvdSeries series(folder / "run.pvd");
  for (int i = 0; i < 3; ++i) {
    series.add(0.1 * i, mesh, (1 + i) * mesh.x);
    const std::string index = read_whole_file(folder / "run.pvd");
    EXPECT_NE(index.find(text("file=\"run_00000", i, ".vtu\"")), std::string::npos);
    EXPECT_TRUE(index.ends_with("</Collection>\n</VTKFile>\n"));
    EXPECT_EQ(load_mesh(folder / text("run_00000", i, ".vtu")).x, (1 + i) * mesh.x);
  }
  EXPECT_NE(read_whole_file(folder / "run.pvd").find("timestep=\"0.2\""), std::string::npos);
  EXPECT_THROW(PvdSeries("run.vtu"), InputError);
}

}  // namespace
}  // namespace kt
