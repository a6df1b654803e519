#include "io/surface/mesh_repair.hpp"

#include "io/mesh/weld.hpp"
#include "io/surface/mesh_doctor.hpp"
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

/// The triangles of a surface with corners of their own, each moved by up to `shift` along every axis.
Mesh shaken_soup(const Mesh& mesh, double shift) {
  Mesh soup;
  soup.x.resize(9 * static_cast<Eigen::Index>(mesh.triangles.size()));
  unsigned random = 1;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    for (int k = 0; k < 3; ++k) {
      node(soup.x, 3 * t + k) = node(mesh.x, mesh.triangles[t][k]);
      for (int c = 0; c < 3; ++c) {
        random = random * 1664525u + 1013904223u;
        soup.x[9 * t + 3 * k + c] += shift * (random / 2147483648.0 - 1);
      }
    }
    soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return soup;
}

TEST(MeshRepair, JoinsNodesWithinTheToleranceThatItOffers) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  const double shift = 1e-6;  // of 6 cm
  const Mesh soup = shaken_soup(mesh, shift);
  EXPECT_EQ(examine(repair(soup).mesh, {.self_intersections = false}).components,
            static_cast<int>(mesh.triangles.size()));
  const auto near = find_near_nodes(soup);
  ASSERT_TRUE(near.has_value());
  EXPECT_LE(near->distance, 2 * std::sqrt(3.0) * shift);
  EXPECT_GE(near->tolerance, near->distance);
  EXPECT_EQ(near->open_edges_before, 3 * static_cast<int>(mesh.triangles.size()));
  EXPECT_EQ(near->open_edges_after, 0);
  const RepairResult r = repair(soup, {.weld_tolerance = near->tolerance});
  EXPECT_EQ(r.mesh.num_nodes(), mesh.num_nodes());
  EXPECT_TRUE(examine(r.mesh, {.self_intersections = false}).clean());
  EXPECT_NEAR(enclosed_volume(r.mesh), enclosed_volume(mesh), 1e-3 * enclosed_volume(mesh));
  EXPECT_FALSE(find_near_nodes(load_mesh(KT_SOURCE_DIR "/meshes/broken/open.off")).has_value());  // a hole is no gap
  EXPECT_FALSE(find_near_nodes(mesh).has_value());
}

TEST(MeshRepair, NoNodeJoinsOneThatIsFartherThanTheTolerance) {
  Mesh mesh;  // a row, 1 apart
  mesh.x = VectorX{{0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 0, 5, 0}};
  mesh.triangles = {{0, 1, 4}, {2, 3, 4}};
  EXPECT_EQ(join_nodes(mesh, 1), 2);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 0, 4}, {2, 2, 4}}));
}

TEST(MeshRepair, JoinsTheNodesOfASolidAndDropsSecondCopies) {
  Mesh solid;  // two tetrahedra that share a face, whose nodes are there twice; the second one is given twice
  solid.x = VectorX{{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 1e-9, 0, 0, 1, 1, 1, 1}};
  solid.tetrahedra = {{0, 1, 2, 3}, {4, 5, 6, 7}, {5, 4, 7, 6}};
  solid.triangles = boundary_triangles(solid.tetrahedra);
  const RepairResult exact = repair(solid);
  EXPECT_EQ(exact.mesh.tetrahedra.size(), 2u);
  EXPECT_EQ(exact.mesh.triangles.size(), 8u);
  const RepairResult near = repair(solid, {.weld_tolerance = 1e-6});
  EXPECT_EQ(near.mesh.num_nodes(), 5);
  EXPECT_EQ(near.mesh.tetrahedra, (std::vector<Tetrahedron>{{0, 1, 2, 3}, {1, 2, 3, 4}}));
  EXPECT_EQ(near.mesh.triangles.size(), 6u);
  EXPECT_EQ(near.done[0], "3 nodes joined with another at most 1e-06 away");
}

TEST(MeshRepair, LeavesWhatItCannotSafelyFix) {
  EXPECT_EQ(examine(repair(broken("open.off")).mesh).open_edges.size(), 3u);
  EXPECT_EQ(examine(repair(broken("nonmanifold_edge.off")).mesh).nonmanifold_edges.size(), 1u);
  EXPECT_EQ(repair(broken("nan.off")).mesh.triangles.size(), 1u);
}

TEST(MeshRepair, RefusesBadOptions) {
  Mesh solid = tetrahedron_surface();
  solid.tetrahedra = {{0, 1, 2, 3}};
  EXPECT_THROW(repair(solid, {.fill_holes = 3}), InputError);
  EXPECT_THROW(repair(solid, {.weld_tolerance = 0.02}), InputError);  // as large as the mesh
  EXPECT_THROW(repair(tetrahedron_surface(), {.weld_tolerance = -1}), InputError);
  EXPECT_THROW(repair(tetrahedron_surface(), {.weld_tolerance = 1e-300}), InputError);  // below the rounding
  EXPECT_THROW(repair(tetrahedron_surface(), {.weld_tolerance = std::nan("")}), InputError);
  EXPECT_THROW(repair(tetrahedron_surface(), {.fill_holes = -1}), InputError);
  EXPECT_THROW(wrap(tetrahedron_surface(), {.alpha = -1}), InputError);
  EXPECT_THROW(wrap(tetrahedron_surface(), {.alpha = 1e-9}), InputError);
}

}  // namespace
}  // namespace kt
