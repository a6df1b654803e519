// Loop's masks against OpenMesh's: the limit of a mesh that OpenMesh refined is the limit of the mesh.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>
#pragma GCC diagnostic pop

#include <gtest/gtest.h>

#include "core/contact_surface/subdivision.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
};
using Peer = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

/// Positions of the limit surface's vertices, as found from triangles and positions.
std::vector<Vec3> limit(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x, int levels) {
  const std::vector<std::array<bool, 3>> sharp(triangles.size(), {false, false, false});
  const Subdivision s = subdivide_loop(triangles, static_cast<int>(x.size()), sharp, levels);
  std::vector<Vec3> out;
  for (int v = 0; v < s.num_vertices(); ++v) {
    Vec3 sum = Vec3::Zero();
    for (int k = s.first[v]; k < s.first[v + 1]; ++k) sum += s.weight[k] * x[s.from[k]];
    out.push_back(sum);
  }
  return out;
}

void compare(const std::vector<Triangle>& triangles, const std::vector<Vec3>& x) {
  Peer peer;
  std::vector<Peer::VertexHandle> handle;
  for (const Vec3& p : x) handle.push_back(peer.add_vertex({p[0], p[1], p[2]}));
  for (const Triangle& t : triangles) peer.add_face(handle[t[0]], handle[t[1]], handle[t[2]]);
  OpenMesh::Subdivider::Uniform::LoopT<Peer, double> loop;
  loop.attach(peer);
  loop(1);
  loop.detach();
  std::vector<Triangle> fine;
  std::vector<Vec3> fine_x;
  for (const auto v : peer.vertices()) fine_x.emplace_back(peer.point(v)[0], peer.point(v)[1], peer.point(v)[2]);
  for (const auto f : peer.faces()) {
    Triangle t{};
    int c = 0;
    for (const auto v : peer.fv_range(f)) t[c++] = v.idx();
    fine.push_back(t);
  }
  const std::vector<Vec3> ours = limit(triangles, x, 2), theirs = limit(fine, fine_x, 1);
  ASSERT_EQ(ours.size(), theirs.size());
  double worst = 0;
  for (const Vec3& p : ours) {
    double nearest = 1e300;
    for (const Vec3& q : theirs) nearest = std::min(nearest, (p - q).norm());
    worst = std::max(worst, nearest);
  }
  EXPECT_LT(worst, 1e-7);  // its weights are rounded to single precision
}

TEST(Subdivision, HasOpenMeshsLoopMasks) {
  Mesh open = sheet(4, 3, 1);
  std::vector<Vec3> x;
  for (int i = 0; i < open.num_nodes(); ++i)
    x.push_back(node(open.x, i) + 0.3 * Vec3(random_vector(3, static_cast<unsigned>(i))));
  compare(open.triangles, x);

  // Closed, with vertices of four and of eight neighbours: a cube of four triangles a side.
  std::vector<Vec3> cube{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
  std::vector<Triangle> triangles;
  for (const auto& q : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    const int middle = static_cast<int>(cube.size());
    cube.push_back((cube[q[0]] + cube[q[1]] + cube[q[2]] + cube[q[3]]) / 4);
    for (int i = 0; i < 4; ++i) triangles.push_back({q[i], q[(i + 1) % 4], middle});
  }
  for (std::size_t i = 0; i < cube.size(); ++i) cube[i] += 0.1 * Vec3(random_vector(3, 50 + static_cast<unsigned>(i)));
  compare(triangles, cube);
}

}  // namespace
}  // namespace kt
