// Our OBJ and OFF readers against CGAL's, which read doubles: every bit must agree.
#include <CGAL/IO/polygon_soup_io.h>
#include <CGAL/Simple_cartesian.h>

#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

TEST(Readers, AgreeWithCgalBitForBit) {
  std::vector<std::string> files = own_meshes();
  for (const std::string& f : real_meshes()) files.push_back(f);
  int compared = 0;
  for (const std::string& f : files) {
    if (mesh_extension(f) == ".stl") continue;
    std::vector<CGAL::Simple_cartesian<double>::Point_3> points;
    std::vector<std::vector<std::size_t>> faces;
    // CGAL refuses an OBJ with an `l` line and gets nothing out of some legal OFF files: those prove nothing.
    if (!CGAL::IO::read_polygon_soup(f, points, faces) || faces.empty()) continue;
    const Mesh mesh = load_mesh(f);
    ASSERT_EQ(static_cast<int>(points.size()), mesh.num_nodes()) << f;
    bool equal = true;
    for (int i = 0; i < mesh.num_nodes(); ++i)
      for (int k = 0; k < 3; ++k) equal = equal && mesh.x[3 * i + k] == points[static_cast<std::size_t>(i)][k];
    EXPECT_TRUE(equal) << f;
    std::vector<Triangle> triangles;
    bool only_triangles = true;
    for (const auto& p : faces) {
      only_triangles = only_triangles && p.size() == 3;
      if (p.size() == 3) triangles.push_back({static_cast<int>(p[0]), static_cast<int>(p[1]), static_cast<int>(p[2])});
    }
    if (only_triangles) {
      EXPECT_EQ(triangles, mesh.triangles) << f;
    }
    ++compared;
  }
  EXPECT_GE(compared, real_meshes().empty() ? 7 : 34);
}

}  // namespace
}  // namespace kt
