// Every reader against files written by hand: what it takes, and the exact line it says to what it does not take.
#include <cmath>
#include <ctime>

#include "io/surface/mesh_doctor.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

struct Sample {
  const char* name;
  std::string content;
  const char* expected;  ///< part of the message
};

void PrintTo(const Sample& s, std::ostream* out) { *out << s.name << " " << s.expected; }

Mesh load_text(const std::string& name, const std::string& content, std::vector<std::string>* notes = nullptr) {
  const PrivateFolder folder;
  return load_mesh(write_sample(folder, name, content), {}, notes);
}

const std::vector<Triangle> kTwo = {{0, 1, 2}, {0, 2, 3}};
const char* const kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(Obj, SlashesNegativeIndicesColoursAndContinuedLinesAreRead) {
  const Mesh mesh =
      load_text("a.obj",
                "# comment\r\nmtllib x.mtl\r\no thing\r\nv 0 0 0 0.5 0.5 0.5\r\nv +1 0 -0.0 1\r\n"
                "v 1. 1e0 0 # behind\r\nv 0 1 \\\r\n 0\r\nvt 0 0\r\nvn 0 0 1\r\ng a b\r\nusemtl m\r\ns off\r\n"
                "l 1 2\r\nf 1/1/1 2//1 3/1\r\nf -4 -2// -1\r\n");
  EXPECT_EQ(mesh.num_nodes(), 4);
  EXPECT_EQ(mesh.triangles, kTwo);
  EXPECT_EQ(mesh.x[10], 1.0);
}

TEST(Obj, FacesMayComeBeforeTheirVertices) {
  EXPECT_EQ(load_text("a.obj", std::string("f 1 2 3\nf 1 3 4\n") + kSquare).triangles, kTwo);
}

TEST(Obj, ANulAtTheEndIsIgnored) {
  EXPECT_EQ(load_text("a.obj", std::string(kSquare) + "f 1 2 3 4\n" + std::string(1, '\0')).triangles, kTwo);
}

TEST(Obj, NumbersAreReadInDoublePrecision) {
  const Mesh mesh = load_text("a.obj", "v 0.1234567890123456 0 0\nv 1 0 0\nv 0 1 1e-320\nf 1 2 3\n");
  EXPECT_EQ(mesh.x[0], 0.1234567890123456);
  EXPECT_EQ(mesh.x[8], 1e-320);
}

TEST(Polygon, AConcaveOneIsCutIntoEarsInsideIt) {
  std::vector<std::string> notes;
  const Mesh mesh = load_text("a.obj", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\n", &notes);
  ASSERT_EQ(mesh.triangles.size(), 3u);
  double area = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = node(mesh.x, t[0]), u = node(mesh.x, t[1]) - a, v = node(mesh.x, t[2]) - a;
    const double twice = u[0] * v[1] - u[1] * v[0];
    EXPECT_GT(twice, 0);  // a fan from corner 0 or 2 would turn one over
    area += twice / 2;
  }
  EXPECT_NEAR(area, 10.0, 1e-12);
  EXPECT_EQ(notes.size(), 2u);
}

TEST(Off, CommentsFreeWhiteSpaceAndGluedKeywordAreRead) {
  const char* const body = "0 0 0 1 0 0 # two on a line\n 1 1\n\n0 0 1 0\n# faces\n3 0 1 2 255 0 0\n3 0 2 3\n";
  for (const char* header : {"OFF\n4 2 0\n", "OFF 4\n# hm\n2\n", "\t OFF4 2 5 # ok\n", "4 2 0\n", "OFF\r\n4 2 0\r\n"})
    EXPECT_EQ(load_text("a.off", std::string(header) + body).triangles, kTwo) << header;
}

TEST(Off, ColoursNormalsAndTextureValuesAreSkipped) {
  const std::string faces = "4 0 1 2 3 0.1 0.2 0.3 1\n";
  EXPECT_EQ(load_text("a.off", "COFF\n4 1 0\n0 0 0 1 2 3 4\n1 0 0 1 2 3\n1 1 0\n0 1 0 9 9 9 9\n" + faces).triangles,
            kTwo);
  EXPECT_EQ(load_text("a.off", "NOFF\n4 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n" + faces).triangles,
            kTwo);
  EXPECT_EQ(load_text("a.off", "STOFF\n4 1 0\n0 0 0 0 1\n1 0 0 0 1\n1 1 0 0 1\n0 1 0 0 1\n" + faces).triangles, kTwo);
}

/// A square of two triangles, whatever stands behind the coordinates.
TEST(Off, ValuesBehindTheCoordinatesAreSkippedWhateverTheHeaderSays) {
  const auto square = [](const std::string& header, const std::string& extra) {
    std::string out = header + "\n4 2 0\n";
    for (const char* point : {"0 0 0", "1 0 0", "1 1 0", "0 1 0"}) out += point + extra + "\n";
    return out + "3 0 1 2\n3 0 2 3\n";
  };
  for (const char* header : {"NCOFF", "CNOFF", "STNCOFF", "STCNOFF"})
    EXPECT_EQ(load_text("a.off", square(header, " 0 0 1 255 0 0 255")).triangles, kTwo) << header;
  for (const char* header : {"NSTOFF", "STNOFF"})
    EXPECT_EQ(load_text("a.off", square(header, " 0 0 1 0.5 0.5")).triangles, kTwo) << header;
  EXPECT_EQ(load_text("a.off", square("4OFF", " 1")).triangles, kTwo);
  for (const char* extra : {" 255 0 0 255", " 0.5 0.5 0.5", " 0 0 1 0 0 0", " 0 0 1 255 0 0 255", " 7"}) {
    std::vector<std::string> notes;
    EXPECT_EQ(load_text("a.off", square("OFF", extra), &notes).triangles, kTwo) << extra;
    ASSERT_EQ(notes.size(), 1u) << extra;
    EXPECT_NE(notes[0].find("which the header does not announce, are ignored"), std::string::npos);
  }
}

TEST(Obj, ABackslashBehindANameSwallowsNoFace) {
  for (const char* statement : {"usemtl tex\\", "g a\\", "o C:\\", "mtllib x \\ "}) {
    std::vector<std::string> notes;
    EXPECT_EQ(load_text("a.obj", std::string(kSquare) + statement + "\nf 1 2 3\nf 1 3 4\n", &notes).triangles, kTwo);
    EXPECT_EQ(notes.size(), 1u) << statement;
  }
  EXPECT_EQ(load_text("a.obj", std::string(kSquare) + "g a \\\n b\nf 1 2 \\\n\\\n 3\nf 1 3 4\n\\\n\n\\").triangles,
            kTwo);
}

TEST(LinesThatEndInReturnsAlone, AreReadInEveryTextFormat) {
  const auto with_returns = [](std::string s) {
    std::replace(s.begin(), s.end(), '\n', '\r');
    return s;
  };
  EXPECT_EQ(load_text("a.obj", with_returns("# a comment\n" + std::string(kSquare) + "f 1 2 3\nf 1 3 4\n")).triangles,
            kTwo);
  const std::string off = "OFF\n# by hand\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3 9 9 9\n";
  EXPECT_EQ(load_text("a.off", with_returns(off)).triangles, kTwo);
  const PrivateFolder folder;
  const std::string bad = write_sample(folder, "b.obj", with_returns("v 0 0 0\nv 1 O 0\n"));
  EXPECT_NE(input_error(folder, [&] { load_mesh(bad); }).find("b.obj:2: coordinate \"O\""), std::string::npos);
}

TEST(LoadMesh, TheSideFileOfAMacIsNamedAsSuch) {
  const PrivateFolder folder;
  const std::string path = write_sample(folder, "._liver.obj", std::string("\0\5\26\7\0\2\0\0Mac OS X", 16));
  EXPECT_NE(input_error(folder, [&] { load_mesh(path); }).find("AppleDouble"), std::string::npos);
}

TEST(NodeEle, BothNamesAndBothCountsFromWork) {
  for (const int base : {0, 1}) {
    const PrivateFolder folder;
    std::string nodes = "# made by hand\n4 3 1 1\n", element = text("1 4 0\n", base);
    const char* const points[4] = {"0 0 0", "1 0 0", "0 1 0", "0 0 1"};
    for (int i = 0; i < 4; ++i) nodes += text(base + i, ' ', points[i], " 7.5 1\n");
    for (const int i : {0, 2, 1, 3}) element += text(' ', base + i);  // negative volume
    write_sample(folder, "a.node", nodes);
    write_sample(folder, "a.ele", element + "\n");
    for (const char* name : {"a.node", "a.ele"}) {
      std::vector<std::string> notes;
      const Mesh mesh = load_mesh(folder / name, {}, &notes);
      ASSERT_EQ(mesh.tetrahedra.size(), 1u);
      EXPECT_GT(tetrahedron_volume(mesh.x, mesh.tetrahedra[0]), 0);
      EXPECT_EQ(mesh.triangles.size(), 4u);
      EXPECT_NEAR(enclosed_volume(mesh), 1.0 / 6, 1e-15);
      EXPECT_EQ(notes.size(), 1u);
    }
  }
}

const std::string kMsh2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"wall\"\n$EndPhysicalNames\n"
    "$Nodes\n5\n1 0 0 0\n20 1 0 0\n3 0 1 0\n4 0 0 1\n9 5 5 5\n$EndNodes\n"
    "$Elements\n3\n1 15 2 0 1 9\n2 2 2 0 1 1 20 3\n3 4 2 0 1 1 20 3 4\n$EndElements\n";
const std::string kMsh4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 0 0\n$EndEntities\n"
    "$Nodes\n2 4 1 20\n2 1 1 1\n1\n0 0 0 0.5 0.5\n3 1 0 3\n20\n3\n4\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n"
    "$Elements\n2 2 1 2\n2 1 2 1\n1 1 20 3\n3 1 4 1\n2 1 20 3 4\n$EndElements\n";

TEST(Msh, Versions2And4GiveTheTetrahedronWithItsBoundary) {
  for (const std::string& content : {kMsh2, kMsh4}) {
    const Mesh mesh = load_text("a.msh", content);
    EXPECT_EQ(mesh.num_nodes(), 4);  // the point element's node is unused
    EXPECT_EQ(mesh.tetrahedra.size(), 1u);
    EXPECT_EQ(mesh.triangles.size(), 4u);
    EXPECT_NEAR(enclosed_volume(mesh), 1.0 / 6, 1e-15);
  }
}

std::string replaced(std::string s, const std::string& what, const std::string& by);

/// Gmsh 2.2 saves an element once for each physical group that it is in: the same nodes, in whatever order.
TEST(Msh, ATetrahedronOfSeveralGroupsIsTakenOnce) {
  std::vector<std::string> notes;
  const Mesh mesh = load_text("a.msh",
                              replaced(replaced(kMsh2, "$Elements\n3\n", "$Elements\n5\n"), "$EndElements",
                                       "4 4 2 5 1 1 20 3 4\n5 4 2 6 1 20 3 1 4\n$EndElements"),
                              &notes);
  EXPECT_EQ(mesh.tetrahedra.size(), 1u);
  EXPECT_EQ(mesh.triangles.size(), 4u);  // faces of three tetrahedra would be none of the surface
  EXPECT_NEAR(enclosed_volume(mesh), 1.0 / 6, 1e-15);
  EXPECT_TRUE(std::ranges::any_of(notes, [](const std::string& n) {
    return n.starts_with("2 of 3 tetrahedra were there before") && n.ends_with("taken once");
  })) << testing::PrintToString(notes);
}

/// Triangles of several groups stay for the doctor, who names them.
TEST(Msh, ATriangleOfSeveralGroupsReachesTheDoctor) {
  const Mesh mesh = load_text("a.msh", replaced(kMsh2, "3 4 2 0 1 1 20 3 4", "3 2 2 5 1 20 3 1"));
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(examine(mesh).duplicates.size(), 1u);
}

std::string replaced(std::string s, const std::string& what, const std::string& by) {
  const std::size_t at = s.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? s : s.replace(at, what.size(), by);
}

const std::string kOff = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";

class BadFile : public testing::TestWithParam<Sample> {};

TEST_P(BadFile, IsRefusedWithFileLineValueAndRange) {
  const PrivateFolder folder;
  const Sample& s = GetParam();
  const std::string path = write_sample(folder, s.name, s.content);
  const std::string what = input_error(folder, [&] { load_mesh(path); });
  EXPECT_NE(what.find(s.expected), std::string::npos) << "said: " << what;
  EXPECT_EQ(what.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Obj, BadFile,
    testing::Values(
        Sample{"a.obj", "", "a.obj: file is empty (0 bytes)"},
        Sample{"a.obj", "v 0 0 0\nv 1 O 0\n", "a.obj:2: coordinate \"O\" is not a number"},
        Sample{"a.obj", "v 0 0\n", "a.obj:1: vertex has 2 numbers; must be 3"},
        Sample{"a.obj", "v 0 0 nan\n", "a.obj:1: coordinate is \"nan\"; must be finite"},
        Sample{"a.obj", "v 0 0 1e999\n", "a.obj:1: coordinate \"1e999\" is beyond the range of a double"},
        Sample{"a.obj", "v 0 0 0\nv 0 0 -1e200\n", "a.obj:2: coordinate is \"-1e200\"; must be below 1e+100"},
        Sample{"a.obj", std::string(kSquare) + "f 1 2 5\n",
               "a.obj:5: vertex index 5 is out of range; the file has 4 vertices"},
        Sample{"a.obj", std::string(kSquare) + "f 1 2 0\n", "a.obj:5: vertex index is 0; OBJ counts from 1"},
        Sample{"a.obj", std::string(kSquare) + "f 1 2 -5\n",
               "a.obj:5: vertex index -5 reaches before the first vertex; 4"},
        Sample{"a.obj", std::string(kSquare) + "f 1 2\n", "a.obj:5: face has 2 corners; must be at least 3"},
        Sample{"a.obj", std::string(kSquare) + "f 1 2 3/x\n", "a.obj:5: texture index \"x\" is not an integer"},
        Sample{"a.obj", std::string(kSquare) + "f 1 2 3.5\n", "a.obj:5: vertex index \"3.5\" is not an integer"},
        Sample{"a.obj", std::string(kSquare) + "face 1 2 3\n", "a.obj:5: unknown statement \"face\""},
        Sample{"a.obj",
               "\x7f"
               "ELF\x02\x01",
               "a.obj:1: unknown statement"},
        Sample{"a.obj", "# nothing\n", "a.obj: the mesh is empty"},
        Sample{"a.obj", kSquare, "a.obj: the mesh has 4 vertices but no faces"}));

INSTANTIATE_TEST_SUITE_P(
    Off, BadFile,
    testing::Values(
        Sample{"a.off", "# only a comment\n", "a.off:2: file holds no data"},
        Sample{"a.off", "PLY\n", "a.off:1: file starts with \"PLY\"; must start with OFF"},
        Sample{"a.off", "nOFF\n3\n4 4 0\n", "only three-dimensional OFF"},
        Sample{"a.off", "4OFF\n3 1 0\n0 0 0 1\n1 0 0 0.5\n0 1 0 1\n3 0 1 2\n",
               "a.off:4: the weight of vertex 1 is 0.5; must be 1"},
        Sample{"a.off", "CCOFF\n3 1 0\n", "a.off:1: file starts with \"CCOFF\"; must start with OFF"},
        Sample{"a.off", replaced(kOff, "0 1 0\n", "0 1 0 255 0\n"),
               "a.off:6: face 0 has 0 corners; must be at least 3 (line 5 has 5 values, those of the vertices before "
               "it 3)"},
        Sample{"a.off", replaced(kOff, "0 1 0\n", "0 1e150 0\n"),
               "a.off:5: y coordinate of vertex 2 is \"1e150\"; must be below 1e+100"},
        Sample{"a.off", "OFF BINARY\n", "a.off:1: binary OFF is not supported"},
        Sample{"a.off", replaced(kOff, "4 4 0", "2000000000 4 0"), "a.off:2: header announces 2000000000 vertices"},
        Sample{"a.off", replaced(kOff, "4 4 0", "4 500000000 0"), "a.off:2: header announces 500000000 faces, but the"},
        Sample{"a.off", replaced(kOff, "4 4 0", "-4 4 0"), "a.off:2: number of vertices is -4; must be at least 0"},
        Sample{"a.off", replaced(kOff, "4 4 0", "5 4 0"), "a.off:7: face 0 has 1 corners; must be at least 3"},
        Sample{"a.off", replaced(kOff, "4 4 0", "4 3 0"), "a.off:10: data \"3\" after the 4 vertices and 3 faces"},
        Sample{"a.off", replaced(kOff, "3 1 2 3\n3 0 3 2\n", ""), "file ends at face 2; the header announces 4"},
        Sample{"a.off", replaced(kOff, "3 1 2 3", "3 1 2 4"), "a.off:9: vertex index 4 of face 2 is out of range 0..3"},
        Sample{"a.off", replaced(kOff, "3 1 2 3", "3 1 2 -1"),
               "a.off:9: vertex index -1 of face 2 is out of range 0..3"},
        Sample{"a.off", replaced(kOff, "3 1 2 3", "2 1 2"), "a.off:9: face 2 has 2 corners; must be at least 3"},
        Sample{"a.off", replaced(kOff, "3 1 2 3", "3 1 2 3 1 2 3 4 5"), "a.off:9: more than 4 values follow"},
        Sample{"a.off", replaced(kOff, "0 1 0\n", "0 inf 0\n"),
               "a.off:5: y coordinate of vertex 2 is \"inf\"; must be finite"}));

INSTANTIATE_TEST_SUITE_P(
    Solids, BadFile,
    testing::Values(
        Sample{"a.msh", replaced(kMsh2, "2.2 0 8", "2.2 2 8"),
               "a.msh:2: the file type is 2; must be 0 (text) or 1 (binary)"},
        Sample{"a.msh", replaced(kMsh2, "2.2 0 8", "2.2 1 8"), "are not the number 1 in either order"},
        Sample{"a.msh", replaced(kMsh2, "2.2 0 8", "4 0 8"),
               "a.msh:2: format version 4 is not supported; known: 2.x and 4.1"},
        Sample{"a.msh", replaced(kMsh2, "1 20 3 4", "1 20 3 5"), "element uses node 5, which $Nodes does not have"},
        Sample{"a.msh", replaced(kMsh2, "3 4 2 0 1 1", "3 5 2 0 1 1"), "element type 5 is not supported"},
        Sample{"a.msh", replaced(kMsh2, "\n5\n1 0", "\n1000000\n1 0"), "header announces 1000000 nodes"},
        Sample{"a.msh", replaced(kMsh2, "0 0 1\n9", "0 0 0\n9"),
               "a.msh: 1 tetrahedra have no volume, the first is number 0"},
        // Two nodes in one place: the volume is rounding, negative whichever way round.
        Sample{"a.msh",
               replaced(kMsh2, "20 1 0 0\n3 0 1 0\n4 0 0 1\n",
                        "20 1 -6.091852762901842e23 -2.4508376041794536e-20\n"
                        "3 1.0313471585932632e35 -1.1788004851024105e24 -2.4508376041794536e-20\n"
                        "4 1.0313471585932632e35 -1.1788004851024105e24 -2.4508376041794536e-20\n"),
               "a.msh: 1 tetrahedra have no volume, the first is number 0"},
        Sample{"a.msh", kMsh4.substr(0, kMsh4.size() - 20), "file ends where"},
        Sample{"a.vtu", "<VTKFile type=\"PolyData\">\n</VTKFile>", "a.vtu:1: VTKFile is not of type UnstructuredGrid"},
        Sample{"a.vtu", "hello", "a.vtu:1: no <VTKFile> element"},
        Sample{"a.node", "1 3 0 0\n0 0 0 1e200\n",
               "a.node:2: a coordinate of node 0 is \"1e200\"; must be below 1e+100"},
        Sample{"a.msh", replaced(kMsh2, "20 1 0 0", "20 1e200 0 0"), "a coordinate of node 20 is \"1e200\""},
        Sample{"a.stl", "solid\nfacet\nvertex 0 0 1e200\nendsolid\n", "a.stl:3: a vertex coordinate is \"1e200\""},
        Sample{"a.node", "4 2 0 0\n", "a.node:1: dimension is 2; must be 3"},
        Sample{"a.node", "2 3 0 0\n5 0 0 0\n6 0 0 0\n", "first node has number 5; must be 0 or 1"},
        Sample{"a.ele", "1 4 0\n", "a.node: no such file"},
        Sample{"a.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$A\x1b[2J\n", "file ends inside \"$A?[2J\""},
        Sample{"a.vtu", "<html\x1b[2J>", "file starts with \"<html?[2J\"; must start with <VTKFile"}));

TEST(NodeEle, ANodeNumberThatOverflowsIsRefused) {
  const PrivateFolder folder;
  write_sample(folder, "a.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n");
  const std::string path = write_sample(folder, "a.ele", "1 4 0\n1 1 2 3 -9223372036854775808\n");
  EXPECT_NE(input_error(folder, [&] { load_mesh(path); }).find("node -9223372036854775808 of tetrahedron 0 is out of"),
            std::string::npos);
}

TEST(LoadMesh, ReadsFromMemory) {
  const auto read_file = [](const std::string& path) {
    return path == "in/memory.node" ? "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n" : "1 4 0\n0 0 1 2 3\n";
  };
  const Mesh mesh = load_mesh("in/memory.ele", {.read_file = read_file});
  EXPECT_EQ(mesh.num_nodes(), 4);
  EXPECT_EQ(mesh.tetrahedra, (std::vector<Tetrahedron>{{0, 1, 2, 3}}));
}

TEST(Polygon, AWindingOneOfThousandsOfCornersTakesNoTime) {
  std::string content;
  constexpr int kHalf = 3000;  // a spiral: there and back
  for (int i = 0; i < 2 * kHalf; ++i) {
    const int j = i < kHalf ? i : 2 * kHalf - 1 - i;
    const double r = 1 + 0.05 * j + (i < kHalf ? 0 : 0.02);
    content += text("v ", r * std::cos(0.3 * j), ' ', r * std::sin(0.3 * j), " 0\n");
  }
  content += "f";
  for (int i = 1; i <= 2 * kHalf; ++i) content += text(' ', i);
  const auto start = std::clock();
  EXPECT_EQ(load_text("a.obj", content + "\n").triangles.size(), 2u * kHalf - 2);
  EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 20);  // by their cube it would be minutes
}

TEST(LoadMesh, NamesTheFormatsForAnUnknownExtension) {
  const PrivateFolder folder;
  EXPECT_EQ(input_error(folder, [] { load_mesh("x.step"); })
                .find("x.step: file extension .step is not a mesh format; known: .obj"),
            0u);
  EXPECT_NE(input_error(folder, [] { load_mesh("noextension"); }).find("(none)"), std::string::npos);
}

TEST(LoadMesh, RefusesDirectoriesDevicesAndMissingFiles) {
  const PrivateFolder folder;
  std::filesystem::create_directory(folder / "d.obj");
  std::filesystem::create_symlink("/dev/zero", folder / "z.obj");
  EXPECT_EQ(input_error(folder, [&] { load_mesh(folder / "d.obj"); }), "d.obj: is a directory, not a file");
  EXPECT_EQ(input_error(folder, [&] { load_mesh(folder / "z.obj"); }), "z.obj: is not a regular file");
  EXPECT_EQ(input_error(folder, [&] { load_mesh(folder / "m.obj"); }), "m.obj: no such file");
}

TEST(LoadMesh, LenientKeepsNanForTheDoctor) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/broken/nan.off", {.lenient = true});
  EXPECT_TRUE(std::isnan(mesh.x[7]));
}

TEST(SaveMesh, LeavesNothingBehindWhenItCannotWrite) {
  const PrivateFolder folder;
  EXPECT_NE(input_error(folder, [&] { save_mesh(folder / "no/where.obj", tetrahedron_surface()); }), "");
  EXPECT_NE(input_error(folder, [&] { save_mesh(folder / "a.node", tetrahedron_surface()); }).find("cannot be written"),
            std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace kt
