// Each broken mesh of the project shows its one fault, and where; the good ones show none.
#include "io/surface/mesh_doctor.hpp"

#include <map>

#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

std::map<std::string, std::size_t> found(const MeshReport& report) {
  std::map<std::string, std::size_t> out;
  for (const DefectList& d : defects(report))
    if (!d.places->empty()) out[d.key] = d.places->size();
  return out;
}
using Found = std::map<std::string, std::size_t>;

MeshReport of_broken(const std::string& name, bool self_intersections = false) {
  return examine(load_mesh(KT_SOURCE_DIR "/meshes/broken/" + name, {.lenient = true}),
                 {.self_intersections = self_intersections});
}

TEST(MeshDoctor, OwnMeshesAreClean) {
  std::map<std::string, int> genus;
  for (const std::string& f : own_meshes()) {
    const MeshReport r = examine(load_mesh(f));
    EXPECT_TRUE(r.clean()) << f;
    EXPECT_EQ(found(r), Found{}) << f;
    EXPECT_EQ(r.components, 1) << f;
    EXPECT_GT(r.volume, 0) << f;
    EXPECT_EQ(r.likely_unit.substr(0, 2), "m ") << f;
    genus[file_name(f)] = r.genus.value();
  }
  EXPECT_EQ(genus["sphere.off"], 0);
  EXPECT_EQ(genus["torus.off"], 1);
  EXPECT_EQ(genus["genus5.off"], 5);
}

TEST(MeshDoctor, OpenEdgesAreNamed) {
  const MeshReport r = of_broken("open.off");
  EXPECT_EQ(found(r), (Found{{"open_edges", 3}}));
  EXPECT_FALSE(r.closed());
  EXPECT_EQ(describe(r.open_edges[0]), "at (0.02, 0.01, 0), nodes 0 1, triangle 0");
}

TEST(MeshDoctor, OneFlippedTriangleIsTheOneNamed) {
  const MeshReport r = of_broken("flipped_face.off");
  ASSERT_EQ(found(r), (Found{{"flipped", 1}}));
  EXPECT_EQ(r.flipped[0].triangles, std::vector<int>{3});
}

TEST(MeshDoctor, InsideOutIsSeen) { EXPECT_EQ(found(of_broken("inside_out.off")), (Found{{"inside_out", 1}})); }

TEST(MeshDoctor, NonManifoldEdgeNamesItsThreeTriangles) {
  const MeshReport r = of_broken("nonmanifold_edge.off", true);
  ASSERT_EQ(found(r), (Found{{"nonmanifold_edges", 1}, {"open_edges", 2}}));
  EXPECT_EQ(r.nonmanifold_edges[0].triangles.size(), 3u);
  EXPECT_FALSE(r.manifold());
}

TEST(MeshDoctor, NonManifoldNodeIsTheSharedCorner) {
  const MeshReport r = of_broken("nonmanifold_vertex.off");
  ASSERT_EQ(found(r), (Found{{"nonmanifold_nodes", 1}}));
  EXPECT_EQ(r.nonmanifold_nodes[0].at, Vec3(0.02, 0.02, 0.02));
  EXPECT_EQ(r.components, 2);
  EXPECT_TRUE(r.closed());
}

TEST(MeshDoctor, DuplicatesDegenerateTrianglesAndUnusedNodesAreNamed) {
  const MeshReport r = of_broken("duplicate_degenerate.off");
  ASSERT_EQ(found(r), (Found{{"duplicates", 2}, {"degenerate", 2}, {"isolated_nodes", 1}}));
  EXPECT_EQ(r.duplicates[0].triangles, (std::vector<int>{12, 0}));
  EXPECT_EQ(r.degenerate[0].triangles, std::vector<int>{14});
  EXPECT_EQ(r.isolated_nodes[0].nodes, std::vector<int>{8});
}

TEST(MeshDoctor, NanIsNamedByNode) {
  const MeshReport r = of_broken("nan.off", true);
  ASSERT_EQ(found(r), (Found{{"non_finite", 1}}));
  EXPECT_EQ(r.non_finite[0].nodes, std::vector<int>{2});
}

TEST(MeshDoctor, ACollinearTriangleIsDegenerateAtAnyScale) {
  for (const double scale : {1e-9, 1.0, 1e9}) {
    Mesh mesh = tetrahedron_surface();
    mesh.x.conservativeResize(15);
    mesh.x.tail(3) = VectorX{{0.01, 0, 0}};
    mesh.x *= scale;
    mesh.triangles.push_back({0, 1, 4});
    EXPECT_EQ(examine(mesh, {.self_intersections = false}).degenerate.size(), 1u) << scale;
  }
}

TEST(MeshDoctor, CoincidentNodesAreGrouped) {
  Mesh mesh = tetrahedron_surface();
  mesh.x.conservativeResize(15);
  mesh.x.tail(3) = VectorX{{-0.0, 0, 0}};  // equals 0
  mesh.triangles[3] = {4, 3, 2};
  const MeshReport r = examine(mesh, {.self_intersections = false});
  ASSERT_EQ(r.coincident_nodes.size(), 1u);
  EXPECT_EQ(r.coincident_nodes[0].nodes, (std::vector<int>{0, 4}));
}

/// A box with a smaller one inside it.
Mesh nested(bool cavity) {
  Mesh mesh = tetrahedron_surface();
  const int n = mesh.num_nodes();
  mesh.x.conservativeResize(6 * n);
  for (int i = 0; i < n; ++i) node(mesh.x, n + i) = 0.2 * node(mesh.x, i) + Vec3::Constant(0.002);
  for (const Triangle& t : tetrahedron_surface().triangles)
    mesh.triangles.push_back(cavity ? Triangle{t[0] + n, t[2] + n, t[1] + n} : Triangle{t[0] + n, t[1] + n, t[2] + n});
  return mesh;
}

TEST(MeshDoctor, ACavityIsFineAndASolidInsideASolidIsNot) {
  EXPECT_EQ(found(examine(nested(true), {.self_intersections = false})), Found{});
  EXPECT_EQ(found(examine(nested(false), {.self_intersections = false})), (Found{{"nested", 1}}));
}

TEST(MeshDoctor, AMoebiusStripIsOneSided) {
  Mesh mesh;
  const int n = 7;
  mesh.x = VectorX::Zero(6 * n);
  for (int i = 0; i < n; ++i)
    for (int s = 0; s < 2; ++s) {
      const double u = 6.283185307179586 * i / n, w = (s - 0.5) * 0.4;
      node(mesh.x, 2 * i + s) =
          Vec3((1 + w * std::cos(u / 2)) * std::cos(u), (1 + w * std::cos(u / 2)) * std::sin(u), w * std::sin(u / 2));
    }
  for (int i = 0; i < n; ++i) {
    const int a = 2 * i, b = a + 1, c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({b, d, c});
  }
  const MeshReport r = examine(mesh, {.self_intersections = false});
  EXPECT_EQ(r.one_sided.size(), 1u);
  EXPECT_TRUE(r.flipped.empty());
  EXPECT_FALSE(r.genus.has_value());
}

}  // namespace
}  // namespace kt
