// A lattice around a surface: how much material it holds, and where, against the surface's own volume and centre; of
// surfaces that are open, a heap of triangles, inside out, or overlap.
#include "io/solid/lattice.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "core/base/error.hpp"
#include "io/mesh/mesh_io.hpp"
#include "tests/support/input_errors.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

Mesh sphere() { return load_mesh(KT_SOURCE_DIR "/meshes/sphere.off"); }

/// Of the tetrahedra, each by its share [m^3].
double filled_volume(const Mesh& lattice) {
  double out = 0;
  for (std::size_t t = 0; t < lattice.tetrahedra.size(); ++t)
    out += lattice.embedded->share[t] * tetrahedron_volume(lattice.x, lattice.tetrahedra[t]);
  return out;
}

Vec3 filled_centre(const Mesh& lattice) {
  Vec3 out = Vec3::Zero();
  for (std::size_t t = 0; t < lattice.tetrahedra.size(); ++t) {
    const Tetrahedron& c = lattice.tetrahedra[t];
    const double volume = lattice.embedded->share[t] * tetrahedron_volume(lattice.x, c);
    for (const int i : c) out += 0.25 * volume * node(lattice.x, i);
  }
  return out / filled_volume(lattice);
}

TEST(Lattice, HoldsTheVolumeOfTheSurface) {
  for (const char* name : {"sphere.off", "organ.off", "torus.off", "genus5.off"}) {
    const Mesh surface = load_mesh(std::string(KT_SOURCE_DIR "/meshes/") + name);
    LatticeReport report;
    const Mesh lattice = make_lattice(surface, {}, &report);
    const double volume = enclosed_volume(surface);
    EXPECT_NEAR(filled_volume(lattice), volume, 0.01 * volume) << name;
    EXPECT_NEAR(report.volume, volume, 0.01 * volume) << name;
    EXPECT_EQ(report.open_edges + report.turned + report.degenerate, 0) << name;
    EXPECT_GT(report.nodes, 300) << name;
    EXPECT_LT(report.nodes, 900) << name;
    for (const Tetrahedron& t : lattice.tetrahedra) EXPECT_GT(tetrahedron_volume(lattice.x, t), 0) << name;
  }
}

TEST(Lattice, HasItsMaterialWhereTheSurfaceHas) {
  const Mesh surface = sphere();
  const Bounds box = bounds(surface);
  EXPECT_LT((filled_centre(make_lattice(surface, {})) - box.centre()).norm(), 0.002 * box.size().x());
}

TEST(Lattice, EmbedsEveryVertexWhereItIs) {
  const Mesh lattice = make_lattice(sphere(), {.nodes = 200});
  const EmbeddedSurface& surface = *lattice.embedded;
  // Any affine motion of the cells is one of the vertices.
  Mat3 F;
  F << 1.1, 0.2, -0.1, 0, 0.9, 0.3, 0.2, -0.2, 1.2;
  VectorX x = lattice.x;
  for (int i = 0; i < surface.first; ++i) node(x, i) = F * node(lattice.x, i);
  surface.follow(x);
  for (int i = surface.first; i < lattice.num_nodes(); ++i)
    EXPECT_LT((node(x, i) - F * node(lattice.x, i)).norm(), 1e-15);
  for (const auto& weights : surface.weights)
    for (const double w : weights) EXPECT_NEAR(w, 0.5, 0.55);
}

TEST(Lattice, FillsASurfaceThatIsOpen) {
  Mesh open = sphere();
  const double volume = enclosed_volume(open);
  const Bounds box = bounds(open);
  const double hole = box.max.z() - 0.03 * box.size().z();
  std::erase_if(open.triangles, [&](const Triangle& t) {
    return std::ranges::any_of(t, [&](int i) { return open.x[3 * i + 2] > hole; });
  });
  LatticeReport report;
  const Mesh lattice = make_lattice(open, {}, &report);
  EXPECT_GT(report.open_edges, 5);
  EXPECT_NEAR(filled_volume(lattice), volume, 0.02 * volume);
  ASSERT_EQ(report.lines().size(), 2u);
  EXPECT_NE(report.lines()[1].find("open edges closed by winding number"), std::string::npos) << report.lines()[1];
}

/// Every triangle by itself, none quite where it was.
TEST(Lattice, FillsAHeapOfTriangles) {
  const Mesh whole = sphere();
  const Bounds box = bounds(whole);
  Sample sample{std::mt19937_64(5)};
  Mesh heap;
  heap.x.resize(9 * static_cast<Eigen::Index>(whole.triangles.size()));
  for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
    const Vec3 off = 1e-3 * box.size().x() * sample.cube();
    const int first = 3 * static_cast<int>(t);
    for (int c = 0; c < 3; ++c) node(heap.x, first + c) = node(whole.x, whole.triangles[t][c]) + off;
    heap.triangles.push_back({first, first + 1, first + 2});
  }
  const double volume = enclosed_volume(whole);
  EXPECT_NEAR(filled_volume(make_lattice(heap, {})), volume, 0.02 * volume);
}

Mesh both(const Mesh& a, const Mesh& b) {
  Mesh out = a;
  out.x.resize(a.x.size() + b.x.size());
  out.x << a.x, b.x;
  for (const Triangle& t : b.triangles)
    out.triangles.push_back({t[0] + a.num_nodes(), t[1] + a.num_nodes(), t[2] + a.num_nodes()});
  return out;
}

TEST(Lattice, TurnsPiecesThatAreInsideOut) {
  Mesh turned = sphere();
  for (Triangle& t : turned.triangles) std::swap(t[1], t[2]);
  Mesh beside = sphere();
  const double wide = bounds(beside).size().x(), volume = enclosed_volume(beside);
  for (int i = 0; i < beside.num_nodes(); ++i) beside.x[3 * i] += 1.5 * wide;
  LatticeReport report;
  const Mesh lattice = make_lattice(both(turned, beside), {.nodes = 1000}, &report);
  EXPECT_EQ(report.turned, static_cast<int>(turned.triangles.size()));
  EXPECT_NEAR(filled_volume(lattice), 2 * volume, 0.02 * volume);
  EXPECT_NEAR(enclosed_volume({lattice.x, lattice.triangles, {}}), 2 * volume, 1e-9 * volume);
}

/// Two balls with their centres a radius apart: the lens between them is there once.
TEST(Lattice, CountsOverlappingPiecesOnce) {
  Mesh other = sphere();
  const double radius = 0.5 * bounds(other).size().x(), volume = enclosed_volume(other);
  for (int i = 0; i < other.num_nodes(); ++i) other.x[3 * i] += radius;
  const double lens = 5.0 / 16 * volume;  // of balls
  EXPECT_NEAR(filled_volume(make_lattice(both(sphere(), other), {})), 2 * volume - lens, 0.02 * volume);
}

TEST(Lattice, LeavesAHollowEmpty) {
  Mesh inner = sphere();
  const Vec3 centre = bounds(inner).centre();
  const double volume = enclosed_volume(inner);
  for (int i = 0; i < inner.num_nodes(); ++i) node(inner.x, i) = centre + 0.7 * (node(inner.x, i) - centre);
  for (Triangle& t : inner.triangles) std::swap(t[1], t[2]);
  LatticeReport report;
  const Mesh lattice = make_lattice(both(sphere(), inner), {}, &report);
  EXPECT_EQ(report.turned, 0);
  EXPECT_NEAR(filled_volume(lattice), (1 - 0.343) * volume, 0.01 * volume);
}

/// Two blocks with a slit of a fifth of a cube between them.
TEST(Lattice, SaysThatItJoinsANarrowGap) {
  const double h = 0.01;
  Mesh low = kuhn_block(4, 4, 2, h), high = low;
  low.tetrahedra.clear();
  high.tetrahedra.clear();
  for (int i = 0; i < high.num_nodes(); ++i) high.x[3 * i + 2] += 2 * h + 0.25 * h;
  const Mesh surface = both(low, high);
  LatticeReport joined, apart;
  make_lattice(surface, {.edge = 1.4 * h}, &joined);
  EXPECT_EQ(joined.joining_cubes, 9);  // all that meet at the slit
  EXPECT_NE(joined.lines().back().find("a gap narrower than"), std::string::npos);
  make_lattice(low, {.edge = 1.4 * h}, &apart);
  EXPECT_EQ(apart.joining_cubes, 0);
}

TEST(Lattice, FitsABoxExactly) {
  Mesh block = kuhn_block(6, 4, 2, 0.01);
  block.tetrahedra.clear();
  const Mesh lattice = make_lattice(block, {.edge = 0.01});
  const Mesh truth = kuhn_block(6, 4, 2, 0.01);
  EXPECT_EQ(lattice.embedded->first, truth.num_nodes());
  EXPECT_EQ(lattice.tetrahedra.size(), truth.tetrahedra.size());
  EXPECT_LT((lattice.x.head(truth.x.size()) - truth.x).lpNorm<Eigen::Infinity>(), 1e-15);
  for (const double share : lattice.embedded->share) EXPECT_NEAR(share, 1, 1e-12);
}

TEST(Lattice, RefusesWhatIsNoBodyInOneLine) {
  Mesh flat = sphere();
  for (int i = 0; i < flat.num_nodes(); ++i) flat.x[3 * i + 2] = 0;
  EXPECT_NE(message([&] { make_lattice(flat, {.name = "flat.off"}); }).find("flat.off: "), std::string::npos);
  const std::string fine = message([] { make_lattice(sphere(), {.edge = 1e-4}); });
  EXPECT_NE(fine.find("object.lattice.edge: 0.0001 m makes"), std::string::npos) << fine;
}

}  // namespace
}  // namespace kt
