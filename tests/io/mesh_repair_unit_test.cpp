#include "io/mesh_repair.hpp"

#include "io/mesh_doctor.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

Mesh broken(const std::string& name) { return load_mesh(KT_SOURCE_DIR "/meshes/broken/" + name, {.lenient = true}); }

TEST(MeshRepair, GoodMeshesStayAsTheyAre) {
  for (const std::string& f : own_meshes()) {
    const Mesh mesh = load_mesh(f);
    const RepairResult r = repair(mesh);
    ASSERT_EQ(r.mesh.x.size(), mesh.x.size()) << f;
    EXPECT_EQ(r.mesh, mesh) << f;
    EXPECT_TRUE(r.done.empty()) << f;
  }
}

TEST(MeshRepair, SafeFaultsAreFixedAndListed) {
  constexpr double kCube = 8e-6;  // m^3
  const struct {
    const char *file, *done;
    double volume;
  } cases[] = {
      {"duplicate_degenerate.off", "2 triangles with two equal corners dropped", kCube},
      {"flipped_face.off", "1 triangles turned to agree with their neighbours", kCube},
      {"inside_out.off", "1 closed pieces turned outward", kCube},
      {"nonmanifold_vertex.off", "1 nodes added where several fans of triangles touched in one node", 2 * kCube}};
  for (const auto& c : cases) {
    const RepairResult r = repair(broken(c.file));
    ASSERT_FALSE(r.done.empty()) << c.file;
    EXPECT_EQ(r.done[0], c.done);
    MeshReport report = examine(r.mesh);
    report.coincident_nodes.clear();  // a split node leaves two at one place
    EXPECT_TRUE(report.clean()) << c.file;
    EXPECT_NEAR(enclosed_volume(r.mesh), c.volume, 1e-18) << c.file;
  }
}

TEST(MeshRepair, WeldsASoupIntoAClosedSurface) {
  Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off"), soup;
  soup.x.resize(9 * static_cast<Eigen::Index>(mesh.triangles.size()));
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    for (int k = 0; k < 3; ++k) node(soup.x, 3 * t + k) = node(mesh.x, mesh.triangles[t][k]);
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const RepairResult r = repair(soup);
  EXPECT_EQ(r.mesh.num_nodes(), mesh.num_nodes());
  EXPECT_TRUE(examine(r.mesh, {.self_intersections = false}).clean());
}

TEST(MeshRepair, LeavesWhatItCannotSafelyFix) {
  EXPECT_EQ(examine(repair(broken("open.off")).mesh).open_edges.size(), 3u);
  EXPECT_EQ(examine(repair(broken("nonmanifold_edge.off")).mesh).nonmanifold_edges.size(), 1u);
  EXPECT_EQ(repair(broken("nan.off")).mesh.triangles.size(), 1u);
}

TEST(MeshRepair, RefusesSolidsAndBadOptions) {
  Mesh solid = tetrahedron_surface();
  solid.tetrahedra = {{0, 1, 2, 3}};
  EXPECT_THROW(repair(solid), InputError);
  EXPECT_THROW(repair(tetrahedron_surface(), {.fill_holes = -1}), InputError);
  EXPECT_THROW(wrap(tetrahedron_surface(), {.alpha = -1}), InputError);
  EXPECT_THROW(wrap(tetrahedron_surface(), {.alpha = 1e-9}), InputError);
}

}  // namespace
}  // namespace kt
