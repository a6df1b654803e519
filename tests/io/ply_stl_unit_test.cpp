// PLY and STL: what we write reads back, what other programs write is read as it stands, what is garbled is refused.
#include <array>
#include <bit>
#include <cctype>
#include <cstring>

#include "io/files/text_reader.hpp"
#include "io/surface/mesh_doctor.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

constexpr double kFloat = 6e-8;  // relative rounding of a 32-bit float

TEST(PlyStl, OwnMeshesReadBackPlyBitForBitAndStlToItsFloats) {
  const PrivateFolder folder;
  for (const std::string& f : own_meshes()) {
    const Mesh mesh = load_mesh(f);
    for (const char* name : {"a.ply", "a.stl"}) {
      save_mesh(folder / name, mesh);
      const Mesh back = load_mesh(folder / name);
      EXPECT_EQ(back.num_nodes(), mesh.num_nodes()) << f << name;
      EXPECT_EQ(back.triangles.size(), mesh.triangles.size()) << f << name;
      EXPECT_NEAR(enclosed_volume(back), enclosed_volume(mesh), 100 * kFloat * enclosed_volume(mesh)) << f << name;
      EXPECT_TRUE(examine(back, {.self_intersections = false}).closed()) << f << name;
    }
    save_mesh(folder / "a.ply", mesh);
    EXPECT_EQ(load_mesh(folder / "a.ply"), mesh) << f;
  }
}

TEST(Ply, NonManifoldInputKeepsItsNodes) {
  const PrivateFolder folder;
  for (const char* name : {"nonmanifold_edge.off", "nonmanifold_vertex.off", "duplicate_degenerate.off"}) {
    const Mesh mesh = load_mesh(std::string(KT_SOURCE_DIR "/meshes/broken/") + name);
    save_mesh(folder / "a.ply", mesh);
    const Mesh back = load_mesh(folder / "a.ply");
    EXPECT_EQ(back.num_nodes(), mesh.num_nodes()) << name;
    EXPECT_EQ(back.triangles, mesh.triangles) << name;
  }
}

TEST(Ply, AsciiWithExtrasAndPolygonsIsRead) {
  const PrivateFolder folder;
  const std::string content =
      "ply\nformat ascii 1.0\ncomment by hand\nobj_info num_cols 512\nelement vertex 4\nproperty float x\nproperty "
      "float y\nproperty float z\n"
      "property uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0 1\n1 0 0 2\n1 1 0 3\n0 1 0 4\n4 0 1 2 3\n";
  EXPECT_EQ(load_mesh(write_sample(folder, "a.ply", content)).triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(Ply, NulsAtTheEndOfATextAreNothing) {
  const PrivateFolder folder;
  const std::string content =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2";
  for (const char* end : {"", "\n"})
    EXPECT_EQ(load_mesh(write_sample(folder, "a.ply", content + end + std::string(3, '\0'))).triangles,
              (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(Ply, BadFilesAreRefused) {
  const PrivateFolder folder;
  save_mesh(folder / "good.ply", tetrahedron_surface());
  const std::string good = read_whole_file(folder / "good.ply");
  const auto says = [&](const std::string& content) {
    return input_error(folder, [&] { load_mesh(write_sample(folder, "a.ply", content)); });
  };
  const auto with = [&](const std::string& what, const std::string& by) {
    std::string s = good;
    return s.replace(s.find(what), what.size(), by);
  };
  EXPECT_NE(says("plx\n"), "");
  EXPECT_NE(says(with("vertex 4", "vertex 2000000000")).find("header announces 2000000000 elements vertex"),
            std::string::npos);
  EXPECT_NE(says(with("end_header\n", "")), "");
  EXPECT_NE(
      says(with("property double x", "property quad x")).find("a.ply:4: property type \"quad\" is not a PLY type"),
      std::string::npos);
  EXPECT_NE(says(good + "x").find("1 bytes follow the elements"), std::string::npos);
  EXPECT_NE(says("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 0\nproperty list uchar int vertex_indices\nend_header\n1 2 3 4\n")
                .find("a.ply:10: data \"4\" after"),
            std::string::npos);
  EXPECT_NE(says(good.substr(0, good.size() - 20)), "");
  std::string wild = good;
  const std::int32_t index = 99;
  std::memcpy(wild.data() + wild.size() - 4, &index, 4);
  EXPECT_NE(says(wild), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::string holes = good;
  std::memcpy(holes.data() + holes.find("end_header\n") + 11, &nan, 8);
  EXPECT_NE(says(holes).find("x of vertex 0"), std::string::npos) << says(holes);
}

TEST(Stl, TextAndBinaryAreToldApartBySize) {
  const PrivateFolder folder;
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
  EXPECT_EQ(load_mesh(write_sample(folder, "a.stl", "solid x y\n" + facet + "endsolid x\n")).triangles.size(), 1u);
  save_mesh(folder / "b.stl", tetrahedron_surface());
  std::string binary = read_whole_file(folder / "b.stl");
  EXPECT_EQ(load_mesh(folder / "b.stl").triangles.size(), 4u);
  EXPECT_EQ(load_mesh(folder / "b.stl").num_nodes(), 4);
  const auto says = [&](const std::string& content) {
    return input_error(folder, [&] { load_mesh(write_sample(folder, "c.stl", content)); });
  };
  EXPECT_NE(says(binary.substr(0, binary.size() - 1))
                .find("binary STL announces 4 triangles (284 bytes) but the file has 283"),
            std::string::npos);
  EXPECT_NE(says("short").find("too few for an STL file"), std::string::npos);
  EXPECT_NE(says("solid x\n" + facet).find("without endsolid"), std::string::npos);
  EXPECT_NE(says("solid x\nfacet\nvertex 0 0 nan\n").find("c.stl:3: a vertex coordinate is \"nan\""),
            std::string::npos);
  EXPECT_NE(says("solid x\nfacet\nvertex 0 0 0\nendfacet\nendsolid\n").find("facet 0 has not 3 vertices"),
            std::string::npos);
}

/// Of vertices (1 2 3), (4 5 6), ... as the header `properties` and the lines of the body say.
std::string text_ply(const std::string& vertex_properties, const std::string& face_properties,
                     const std::string& body) {
  return "ply\nformat ascii 1.0\nelement vertex 3\n" + vertex_properties + "element face 1\n" + face_properties +
         "end_header\n" + body;
}

TEST(Ply, CommentsAndMoreListsAreRead) {
  const PrivateFolder folder;
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string corners = "property list uchar int vertex_indices\n";
  const VectorX x{{0, 0, 0, 1, 0, 0, 0, 1, 0}};
  const auto check = [&](const std::string& content) {
    const Mesh mesh = load_mesh(write_sample(folder, "a.ply", content));
    EXPECT_EQ(mesh.x, x) << content;
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}})) << content;
  };
  check(text_ply(xyz, corners, "0 0 0\n1 0 0 # a comment\n0 1 0\n3 0 1 2\n"));
  check(text_ply("property list uchar int more\n" + xyz, corners, "1 7 0 0 0\n2 7 7 1 0 0\n0 0 1 0\n3 0 1 2\n"));
  check(text_ply(xyz, "property uchar red\nproperty list uchar float more\n" + corners,
                 "0 0 0\n1 0 0\n0 1 0\n9 2 0.5 0.5 3 0 1 2\n"));
  check(text_ply(xyz, "property list ushort uint vertex_index\n", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
}

TEST(Ply, NanIsKeptForTheDoctorAndMovesNothing) {
  const PrivateFolder folder;
  const std::string path =
      write_sample(folder, "a.ply",
                   text_ply("property float x\nproperty float y\nproperty float z\n",
                            "property list uchar int vertex_indices\n", "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"));
  const Mesh mesh = load_mesh(path, {.lenient = true});
  EXPECT_TRUE(std::isnan(mesh.x[4]));
  EXPECT_EQ(mesh.x[7], 1);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_NE(input_error(folder, [&] { load_mesh(path); })
                .find("a.ply:11: coordinate y of vertex 1 is \"nan\"; must be finite"),
            std::string::npos);
}

TEST(Ply, CornersThatAreNoIndicesAreRefused) {
  const PrivateFolder folder;
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const auto says = [&](const std::string& vertices, const std::string& faces, const std::string& body) {
    return input_error(folder, [&] { load_mesh(write_sample(folder, "a.ply", text_ply(vertices, faces, body))); });
  };
  const std::string corners = "property list uchar int vertex_indices\n", nodes = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_NE(says(xyz, corners, nodes + "3 0 1 1.5\n").find("\"1.5\" is not an integer"), std::string::npos);
  EXPECT_NE(says(xyz, corners, nodes + "3 0 1 3\n").find("vertex index 3 of face 0 is out of range 0..2"),
            std::string::npos);
  EXPECT_NE(says(xyz, "property list uchar float vertex_indices\n", nodes + "3 0 1 2\n").find("a list of integers"),
            std::string::npos);
  EXPECT_NE(says(xyz, "property uchar red\n", nodes + "3\n").find("no list vertex_indices"), std::string::npos);
  EXPECT_NE(says("property float x\nproperty float y\n", corners, "0 0\n1 0\n0 1\n3 0 1 2\n").find("property z"),
            std::string::npos);
}

TEST(Stl, TextNeedNotComeInLines) {
  const PrivateFolder folder;
  const std::string content =
      "solid x\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0\nvertex 0 1 0 endloop endfacet\nendsolid x\n";
  const Mesh mesh = load_mesh(write_sample(folder, "a.stl", content));
  EXPECT_EQ(mesh.x, (VectorX{{0, 0, 0, 1, 0, 0, 0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(Stl, CoordinatesThatAreNoneAreRefused) {
  const PrivateFolder folder;
  save_mesh(folder / "b.stl", tetrahedron_surface());
  std::string binary = read_whole_file(folder / "b.stl");
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(binary.data() + 84 + 50 + 12 + 4, &nan, 4);
  const std::string path = write_sample(folder, "a.stl", binary);
  EXPECT_EQ(input_error(folder, [&] { load_mesh(path); }),
            "a.stl: byte 154: coordinate y of a corner of triangle 1 is nan; must be finite");
  EXPECT_EQ(load_mesh(path, {.lenient = true}).num_nodes(), 5);  // that corner is joined with no other
  EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "a.stl", "solid\nvertex 0 0 1\nendsolid\n")); })
                .find("vertices follow the last facet"),
            std::string::npos);
}

const std::string kFacet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

std::string in_capitals(std::string s) {
  for (char& c : s) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return s;
}

std::string replaced_all(std::string s, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = s.find(what, at)) != std::string::npos; at += by.size())
    s.replace(at, what.size(), by);
  return s;
}

/// What other programs write: each is one triangle.
TEST(Stl, KeywordsComeInCapitalsInTwoWordsAndBehindAByteOrderMark) {
  const PrivateFolder folder;
  const std::string plain = "solid part\n" + kFacet + "endsolid part\n";
  for (const std::string& content :
       {plain, in_capitals(plain), replaced_all(plain, "endsolid", "end solid"),
        in_capitals(replaced_all(plain, "endsolid", "end solid")), replaced_all(plain, "endsolid", "ENDSOLID"),
        replaced_all(replaced_all(plain, "endloop", "end loop"), "endfacet", "end facet"), "\xEF\xBB\xBF" + plain,
        "\r\n" + plain, replaced_all(plain, "\n", "\r"), replaced_all(plain, "\n", "\r\n"),
        plain + std::string(3, '\0')}) {
    std::vector<std::string> notes;
    const Mesh mesh = load_mesh(write_sample(folder, "a.stl", content), {}, &notes);
    EXPECT_EQ(mesh.x, (VectorX{{0, 0, 0, 1, 0, 0, 0, 1, 0}})) << content;
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}})) << content;
    EXPECT_EQ(notes.size(), 1u) << content;
  }
}

TEST(Stl, ASecondSolidIsTakenToo) {
  const PrivateFolder folder;
  std::vector<std::string> notes;
  const std::string shifted = replaced_all(kFacet, "0 0 0", "0 0 5");
  const Mesh mesh =
      load_mesh(write_sample(folder, "a.stl",
                             "solid a\n" + kFacet + "endsolid a\nsolid b\n" + shifted + "endsolid b\nmade by hand\n"),
                {}, &notes);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 1, 2}}));
  EXPECT_EQ(notes[0], "text behind endsolid ignored");
  EXPECT_EQ(notes[1], "2 solids in the file, taken together");
  EXPECT_NE(
      input_error(folder,
                  [&] { load_mesh(write_sample(folder, "a.stl", "solid a\n" + kFacet + "endsolid a\n" + kFacet)); })
          .find("a.stl:10: found \"facet\" after endsolid"),
      std::string::npos);
}

TEST(Stl, TextKeepsItsDigits) {
  const PrivateFolder folder;
  // Map coordinates: as 32-bit floats the first two corners would be one.
  std::string content = "solid\n" + replaced_all(kFacet, "0 0 0", "5400000.125 4649000.25 0");
  content = replaced_all(content, "1 0 0", "5400000.25 4649000.25 0") + "endsolid\n";
  const Mesh mesh = load_mesh(write_sample(folder, "a.stl", content));
  EXPECT_EQ(mesh.x.head(6), (VectorX{{5400000.125, 4649000.25, 0, 5400000.25, 4649000.25, 0}}));
  // The last digit of a double is rounding: one node.
  const Mesh joined =
      load_mesh(write_sample(folder, "b.stl",
                             "solid\n" + replaced_all(kFacet, "1 0 0", "0.85065080835203999 0 0") +
                                 replaced_all(kFacet, "1 0 0", "0.85065080835203988 0 0") + "endsolid\n"));
  EXPECT_EQ(joined.num_nodes(), 3);
}

TEST(Stl, BytesBehindTheLastTriangleAreNoted) {
  const PrivateFolder folder;
  save_mesh(folder / "b.stl", tetrahedron_surface());
  const std::string binary = read_whole_file(folder / "b.stl");
  std::vector<std::string> notes;
  const Mesh mesh = load_mesh(write_sample(folder, "a.stl", binary + std::string(2, '\0')), {}, &notes);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(notes[0], "2 bytes behind the 4 triangles that the header announces are ignored");
  std::string solid = binary;  // a header that looks like text
  std::memcpy(solid.data(), "solid\0", 6);
  EXPECT_EQ(load_mesh(write_sample(folder, "a.stl", solid + "xy")).triangles.size(), 4u);
}

template <class T>
std::string bytes_of(T value, std::endian order) {
  std::string out(reinterpret_cast<const char*>(&value), sizeof value);
  if (order != std::endian::native) std::reverse(out.begin(), out.end());
  return out;
}

TEST(Ply, DoublesKeepEveryBitInEitherByteOrderAndAsText) {
  const PrivateFolder folder;
  const VectorX x{{5400000.123456789, 4649000.25, 1.0 / 3, 5400000.125, 4649000.25, 0.1, 1e-300, -7e99, 0}};
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    std::string content =
        text("ply\nformat binary_", order == std::endian::big ? "big" : "little",
             "_endian 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
             "element face 1\nproperty list uchar short vertex_indices\nend_header\n");
    for (const double value : x) content += bytes_of(value, order);
    content += '\3';
    for (const std::int16_t i : std::array<std::int16_t, 3>{0, 1, 2}) content += bytes_of(i, order);
    const Mesh mesh = load_mesh(write_sample(folder, "a.ply", content));
    EXPECT_EQ(mesh.x, x);
    EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
  }
  const Mesh mesh = load_mesh(write_sample(
      folder, "a.ply",
      text_ply(
          "property double x\nproperty double y\nproperty double z\n", "property list uchar int vertex_indices\n",
          "5400000.123456789 4649000.25 0.3333333333333333\n5400000.125 4649000.25 0.1\n1e-300 -7e99 0\n3 0 1 2\n")));
  EXPECT_EQ(mesh.x, x);
}

TEST(Ply, ACommentThatEndsInABackslashIsOneLine) {
  const PrivateFolder folder;
  const std::string good = text_ply("property float x\nproperty float y\nproperty float z\n",
                                    "property list uchar int vertex_indices\n", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const std::string content = replaced_all(good, "element vertex", "comment TextureFile D:\\scans\\\nelement vertex");
  EXPECT_EQ(load_mesh(write_sample(folder, "a.ply", content)).triangles.size(), 1u);
  EXPECT_EQ(load_mesh(write_sample(folder, "a.ply", replaced_all(good, "\n", "\r"))).triangles.size(), 1u);
  EXPECT_EQ(load_mesh(write_sample(folder, "a.ply", replaced_all(good, "\n", "\r\n"))).triangles.size(), 1u);
}

}  // namespace
}  // namespace kt
