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

TEST(BorderLoops, OneHoleIsOneLoop) {
  EXPECT_TRUE(find_border_loops(load_mesh(KT_SOURCE_DIR "/meshes/torus.off")).empty());
  const std::vector<BorderLoop> loops = find_border_loops(load_mesh(KT_SOURCE_DIR "/meshes/broken/open.off"));
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].nodes.size(), 3u);
  EXPECT_NEAR(loops[0].length, 0.04 + 0.02 * std::sqrt(2.0), 1e-15);
}

TEST(BorderLoops, HoldAllOpenEdgesOfManifoldMeshes) {
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
