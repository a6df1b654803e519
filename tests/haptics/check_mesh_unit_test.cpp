#include "haptics/body/check_mesh.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

TEST(CheckMesh, TurnsTetrahedraAndTheirFaces) {
  const Mesh right = kuhn_block(2, 1, 1, 0.01);
  Mesh mesh = right;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); i += 2) std::swap(mesh.tetrahedra[i][0], mesh.tetrahedra[i][3]);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  std::vector<std::string> notes;
  check_and_orient(mesh, "mesh", &notes);
  for (const Tetrahedron& t : mesh.tetrahedra) EXPECT_GT(tetrahedron_volume(mesh.x, t), 0);
  EXPECT_NEAR(enclosed_volume(mesh), 2e-6, 1e-18);
  EXPECT_EQ(notes.size(), 2u);
  mesh.triangles.clear();
  check_and_orient(mesh, "mesh");
  EXPECT_NEAR(enclosed_volume(mesh), 2e-6, 1e-18);
}

TEST(CheckMesh, LeavesARightMeshAsItIs) {
  const Mesh right = kuhn_block(2, 2, 1, 0.01);
  Mesh mesh = right;
  std::vector<std::string> notes;
  check_and_orient(mesh, "mesh", &notes);
  EXPECT_EQ(mesh, right);
  EXPECT_TRUE(notes.empty());
}

TEST(CheckMesh, RefusesWhatIsNoMesh) {
  const auto refused = [](auto change) {
    Mesh mesh = one_tetrahedron(0.01);
    change(mesh);
    EXPECT_THROW(check_and_orient(mesh, "mesh"), InputError);
  };
  refused([](Mesh& m) { m.tetrahedra[0][2] = 4; });
  refused([](Mesh& m) { m.triangles[0][1] = -1; });
  refused([](Mesh& m) { m.x[4] = std::numeric_limits<double>::quiet_NaN(); });
  refused([](Mesh& m) { m.x[4] = std::numeric_limits<double>::infinity(); });
  refused([](Mesh& m) { node(m.x, 3) = node(m.x, 2); });
  refused([](Mesh& m) { m.tetrahedra.clear(), m.triangles.clear(); });
}

}  // namespace
}  // namespace kt
