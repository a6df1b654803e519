// PLY and STL: what we write reads back, and what OpenMesh alone would swallow is refused.
#include <cstring>

#include "io/border_loops.hpp"
#include "io/mesh_doctor.hpp"
#include "io/text_reader.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

constexpr double kFloat = 6e-8;  // relative rounding of a 32-bit float

TEST(PlyStl, OwnMeshesReadBackToFloatPrecision) {
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
    const Mesh back = load_mesh(folder / "a.ply");
    EXPECT_EQ(back.triangles, mesh.triangles);
    EXPECT_LE((back.x - mesh.x).lpNorm<Eigen::Infinity>(), kFloat * mesh.x.lpNorm<Eigen::Infinity>());
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
  EXPECT_NE(says(with("end_header\n", "")), "");  // OpenMesh alone never ends on this one
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

TEST(Ply, WhatTheLibraryLosesItsPlaceAtIsRead) {
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
  EXPECT_NE(input_error(folder, [&] { load_mesh(path); }).find("y of vertex 1 is nan"), std::string::npos);
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
  EXPECT_NE(says(xyz, corners, "0 0 1e39\n1 0 0\n0 1 0\n3 0 1 2\n").find("32-bit float"), std::string::npos);
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
  for (const bool lenient : {false, true})  // the library would join such a corner with any other
    EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "a.stl", binary), {.lenient = lenient}); })
                  .find("coordinate y of corner 0 of triangle 1 is nan"),
              std::string::npos);
  EXPECT_NE(input_error(folder,
                        [&] { load_mesh(write_sample(folder, "a.stl", "solid\nfacet\nvertex 0 0 1e39\nendsolid\n")); })
                .find("32-bit float"),
            std::string::npos);
  EXPECT_NE(input_error(folder, [&] { load_mesh(write_sample(folder, "a.stl", "solid\nvertex 0 0 1\nendsolid\n")); })
                .find("vertices follow the last facet"),
            std::string::npos);
}

TEST(BorderLoops, OneHoleIsOneLoop) {
  EXPECT_TRUE(find_border_loops(load_mesh(KT_SOURCE_DIR "/meshes/torus.off")).empty());
  const std::vector<BorderLoop> loops = find_border_loops(load_mesh(KT_SOURCE_DIR "/meshes/broken/open.off"));
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].nodes.size(), 3u);
  EXPECT_NEAR(loops[0].length, 0.04 + 0.02 * std::sqrt(2.0), 1e-15);
}

TEST(BorderLoops, HoldAllOpenEdgesOfManifoldMeshes) {
  if (real_meshes().empty()) GTEST_SKIP() << kNoMeshes;
  for (const std::string& f : real_meshes()) {
    const Mesh mesh = load_mesh(f);
    const MeshReport r = examine(mesh, {.self_intersections = false});
    if (!r.manifold() || !r.flipped.empty() || !r.one_sided.empty()) continue;
    std::size_t edges = 0;
    for (const BorderLoop& l : find_border_loops(mesh)) edges += l.nodes.size();
    if (r.degenerate.empty()) {
      EXPECT_EQ(edges, r.open_edges.size()) << f;
    }
  }
}

}  // namespace
}  // namespace kt
