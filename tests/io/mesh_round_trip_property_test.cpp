// What is written reads back: bit for bit, for every mesh at hand.
#include "io/mesh/format/vtu.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

TEST(RoundTrip, SurfacesKeepEveryBitInObjOffVtuAndMsh) {
  std::vector<std::string> files = own_meshes();
  ASSERT_GE(files.size(), 7u);
  for (const std::string& f : real_meshes())
    if (mesh_extension(f) != ".stl" && file_name(f).find("huge") == std::string::npos) files.push_back(f);
  const PrivateFolder folder;
  for (const std::string& f : files) {
    const Mesh mesh = load_mesh(f);
    for (const char* name : {"a.obj", "a.off", "a.vtu"}) {
      save_mesh(folder / name, mesh);
      const Mesh back = load_mesh(folder / name);
      ASSERT_EQ(back.x.size(), mesh.x.size()) << f << name;
      EXPECT_EQ(back, mesh) << f << name;
    }
    save_mesh(folder / "a.msh", mesh);
    const Mesh back = load_mesh(folder / "a.msh", {.lenient = true});  // else unused nodes are dropped
    ASSERT_EQ(back.x.size(), mesh.x.size()) << f;
    EXPECT_EQ(back, mesh) << f;
  }
}

TEST(RoundTrip, SolidsKeepNodesAndTetrahedraInVtuAndMsh) {
  Mesh mesh = tetrahedron_surface();
  mesh.tetrahedra = {{0, 1, 2, 3}};
  mesh.x *= 1.0 / 3;
  const PrivateFolder folder;
  for (const char* name : {"a.vtu", "a.msh"}) {
    save_mesh(folder / name, mesh);
    const Mesh back = load_mesh(folder / name);
    ASSERT_EQ(back.x.size(), mesh.x.size()) << name;
    EXPECT_EQ(back.x, mesh.x);
    EXPECT_EQ(back.tetrahedra, mesh.tetrahedra);
    EXPECT_EQ(sorted_triangles(back.triangles), sorted_triangles(mesh.triangles));
  }
}

TEST(RoundTrip, ASurfaceFileOfASolidHoldsOnlyTheSurfaceNodes) {
  // Four tetrahedra around an inner node.
  Mesh mesh;
  mesh.x = VectorX{{0.25, 0.25, 0.25, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}};
  for (const Triangle& t : tetrahedron_surface().triangles)
    mesh.tetrahedra.push_back({0, t[0] + 1, t[1] + 1, t[2] + 1});
  for (Tetrahedron& t : mesh.tetrahedra)
    if (tetrahedron_volume(mesh.x, t) < 0) std::swap(t[2], t[3]);
  mesh.triangles = boundary_triangles(mesh.tetrahedra);
  const PrivateFolder folder;
  save_mesh(folder / "a.off", mesh);
  const Mesh back = load_mesh(folder / "a.off");
  EXPECT_EQ(back.num_nodes(), 4);
  EXPECT_EQ(back.triangles.size(), 4u);
  EXPECT_NEAR(enclosed_volume(back), 1.0 / 6, 1e-15);
}

}  // namespace
}  // namespace kt
