// A lattice around a surface: how much material it holds, and where, against the surface's own volume and centre; of
// surfaces that are open, a heap of triangles, inside out, or overlap.
#include "core/body/embedded_surface.hpp"
#include "io/solid/lattice.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "core/base/error.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/solid/lattice_grid.hpp"
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

TEST(Lattice, EmbedsVerticesInCellsOfTenNodes) {
  const Mesh lattice = make_lattice(sphere(), {.nodes = 400, .is_quadratic = true});
  const EmbeddedSurface& surface = *lattice.embedded;
  EXPECT_GT(surface.first, 300);
  EXPECT_LT(surface.first, 600);
  // Any motion of the second degree of the cells is one of the vertices.
  const double size = bounds(lattice).size().x();
  const auto moved = [&](const Vec3& p) {
    const Vec3 q = p / size;
    return Vec3(q.x() + 0.3 * q.y() * q.z(), q.y() - 0.2 * q.x() * q.x() + 0.1 * q.z(), q.z() + 0.4 * q.x() * q.y());
  };
  VectorX x = lattice.x;
  for (int i = 0; i < surface.first; ++i) node(x, i) = moved(node(lattice.x, i));
  surface.follow(x);
  for (int i = surface.first; i < lattice.num_nodes(); ++i)
    EXPECT_LT((node(x, i) - moved(node(lattice.x, i))).norm(), 1e-14);
}

/// Of the points of the cells, each with a quarter of its material.
template <class Of>
double integral(const Mesh& lattice, const Of& of) {
  double out = 0;
  for (std::size_t t = 0; t < lattice.tetrahedra.size(); ++t) {
    const Tetrahedron& c = lattice.tetrahedra[t];
    const double volume = lattice.embedded->share[t] * tetrahedron_volume(lattice.x, c);
    for (Eigen::Index q = 0; q < 4; ++q) {
      Vec3 place = Vec3::Zero();
      for (int k = 0; k < 4; ++k) place += lattice.embedded->points[t](k, q) * node(lattice.x, c[k]);
      out += 0.25 * volume * of(place);
    }
  }
  return out;
}

/// A ball, whose integrals are known, and a plate that is turned and thinner than the points of a cube are apart.
TEST(Lattice, IntegratesOverTheMaterialOfTenNodeCells) {
  Mesh ball = sphere();
  const Vec3 middle = bounds(ball).centre();
  const double radius = 0.5 * bounds(ball).size().x(), volume = enclosed_volume(ball);
  for (const int nodes : {150, 1000}) {
    const Mesh lattice = make_lattice(ball, {.nodes = nodes, .is_quadratic = true});
    EXPECT_NEAR(integral(lattice, [](const Vec3&) { return 1; }), volume, 0.01 * volume) << nodes;
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(integral(lattice, [&](const Vec3& p) { return (p - middle)[k]; }), 0, 2e-3 * volume * radius);
      const double squares = volume * radius * radius / 5;
      EXPECT_NEAR(integral(lattice, [&](const Vec3& p) { return std::pow((p - middle)[k], 2); }), squares,
                  0.03 * squares)
          << nodes;
    }
  }
  constexpr double kThick = 0.004, kWide = 0.06;
  Mesh plate = kuhn_block(1, 1, 1, 1);
  plate.tetrahedra.clear();
  const Mat3 turn = Eigen::AngleAxisd(0.5, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (int i = 0; i < plate.num_nodes(); ++i)
    node(plate.x, i) = turn * (node(plate.x, i) - Vec3::Constant(0.5)).cwiseProduct(Vec3(kThick, kWide, kWide));
  const Mesh lattice = make_lattice(plate, {.edge = 0.02, .is_quadratic = true});
  const Vec3 normal = turn.col(0);
  const double bending = integral(lattice, [&](const Vec3& p) { return std::pow(normal.dot(p), 2); });
  const double truth = std::pow(kThick, 3) * kWide * kWide / 12;
  EXPECT_NEAR(bending, truth, 0.2 * truth);
}

/// Of a ball no more than it is looked for: six edges of a cube.
TEST(Lattice, KnowsHowThickTheMaterialIs) {
  Mesh plate = kuhn_block(10, 10, 1, 0.006);
  plate.tetrahedra.clear();
  for (int i = 0; i < plate.num_nodes(); ++i) plate.x[3 * i + 2] *= 0.5;
  EXPECT_NEAR(make_lattice(plate, {.edge = 0.01}).embedded->thickness, 0.003, 1e-5);
  // A hollow ball.
  Mesh hollow = sphere();
  const Vec3 middle = bounds(hollow).centre();
  const double radius = 0.5 * bounds(hollow).size().x();
  const int outer = hollow.num_nodes();
  hollow.x.conservativeResize(6 * outer);
  for (int i = 0; i < outer; ++i) node(hollow.x, outer + i) = middle + 0.9 * (node(hollow.x, i) - middle);
  for (std::size_t t = 0, count = hollow.triangles.size(); t < count; ++t) {
    const Triangle& v = hollow.triangles[t];
    hollow.triangles.push_back({v[0] + outer, v[2] + outer, v[1] + outer});
  }
  EXPECT_NEAR(make_lattice(hollow, {}).embedded->thickness, 0.1 * radius, 0.01 * radius);
  const Mesh ball = make_lattice(sphere(), {.edge = 0.3 * radius});
  EXPECT_NEAR(ball.embedded->thickness, 6 * ball.embedded->edge, 1e-9);
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

// ---- gaps narrower than a cube ----

/// Of each node of the cells: the first one that it hangs together with.
std::vector<int> parts_of(const Mesh& lattice) {
  std::vector<int> same(static_cast<std::size_t>(lattice.num_own_nodes()));
  std::iota(same.begin(), same.end(), 0);
  const auto root = [&](int i) {
    while (same[static_cast<std::size_t>(i)] != i) i = same[static_cast<std::size_t>(i)];
    return i;
  };
  for (const Tetrahedron& t : lattice.tetrahedra)
    for (const int i : t) same[static_cast<std::size_t>(root(i))] = root(t[0]);
  for (int& i : same) i = root(i);
  return same;
}

int count_parts(const Mesh& lattice) {
  std::vector<int> part = parts_of(lattice);
  std::ranges::sort(part);
  return static_cast<int>(std::unique(part.begin(), part.end()) - part.begin());
}

/// Two blocks of 4 x 4 x 2 cubes of 1 cm, one above the other, and further along x.
Mesh stacked(double gap, double shift = 0) {
  const double h = 0.01;
  Mesh low = kuhn_block(4, 4, 2, h), high = low;
  low.tetrahedra.clear();
  high.tetrahedra.clear();
  for (int i = 0; i < high.num_nodes(); ++i) node(high.x, i) += Vec3(shift, 0, 2 * h + gap);
  return both(low, high);
}

TEST(Lattice, KeepsApartWhatANarrowGapParts) {
  for (const double gap : {2.5e-3, 1e-4, 2e-6}) {
    LatticeReport report;
    const Mesh surface = stacked(gap, 0.003), lattice = make_lattice(surface, {.edge = 0.014}, &report);
    EXPECT_EQ(count_parts(lattice), 2) << gap;
    EXPECT_GT(report.parted_cubes, gap < 1e-3 ? 5 : -1) << gap;
    if (gap < 1e-3) {
      EXPECT_NE(report.lines().back().find("apart"), std::string::npos) << report.lines().back();
    }
    const double volume = enclosed_volume(surface);
    EXPECT_NEAR(filled_volume(lattice), volume, 0.02 * volume) << gap;
    // Every vertex goes with cells of its own block.
    const std::vector<int> part = parts_of(lattice);
    std::array<int, 2> of_block{-1, -1};
    for (int v = 0; v < lattice.embedded->num_vertices(); ++v) {
      int& its = of_block[node(lattice.x, lattice.embedded->first + v).z() > 0.02 + 0.5 * gap];
      for (const int i : lattice.embedded->corners[static_cast<std::size_t>(v)]) {
        if (its < 0) its = part[static_cast<std::size_t>(i)];
        EXPECT_EQ(part[static_cast<std::size_t>(i)], its) << gap;
      }
    }
    EXPECT_NE(of_block[0], of_block[1]) << gap;
  }
  LatticeReport one;
  EXPECT_EQ(count_parts(make_lattice(sphere(), {}, &one)), 1);
  EXPECT_EQ(one.parted_cubes, 0);
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

constexpr double kAll = std::numeric_limits<double>::infinity();

/// Cubes of at most 10 mm, two below a plane at 13 mm, that fill the 47 mm above it.
TEST(Lattice, HasNodesWhereTheClampedPartEnds) {
  const auto along_z = [&](double low, double high, double width = kAll, double tall = 0.06, double deep = 0.06) {
    const Bounds clamped{Vec3(-width, -kAll, low), Vec3(width, kAll, high)};
    const LatticeGrid grid = make_lattice_grid({Vec3::Zero(), Vec3(deep, 0.04, tall)}, 0.01, clamped);
    return std::array{grid.origin.z(), grid.edge.z(), static_cast<double>(grid.count[2])};
  };
  const auto expect = [](const std::array<double, 3>& its, double origin, double edge, int count) {
    EXPECT_NEAR(its[0], origin, 1e-12);
    EXPECT_NEAR(its[1], edge, 1e-12);
    EXPECT_EQ(its[2], count);
  };
  expect(along_z(-kAll, 0.013), 0.013 - 2 * 0.0094, 0.0094, 7);
  expect(along_z(0.047, kAll), 0, 0.0094, 7);
  expect(along_z(0.0009, 0.013), 0.013 - 2 * 0.0094, 0.0094, 7);  // its lower end is the box's
  expect(along_z(0.013, 0.03), 0.013 - 2 * 0.0094, 0.0094, 7);
  expect(along_z(-kAll, 0.0009), 0, 0.01, 6);
  expect(along_z(-kAll, 0.013, 0.009), 0, 0.01, 6);  // narrower than a cube along x
  expect(along_z(-kAll, 0.004, kAll, 0.009), 0, 0.009, 1);
  expect(along_z(-kAll, 0.013, kAll, 0.06, 0.004), 0.013 - 2 * 0.0094, 0.0094, 7);  // a plate that stands

  Mesh block = kuhn_block(6, 4, 6, 0.01);
  block.tetrahedra.clear();
  block.x.conservativeResize(block.x.size() + 3);
  block.x.tail(3) = Vec3(0, 0, -1);  // of no triangle
  const Mesh lattice = make_lattice(block, {.edge = 0.01, .clamped = [](const Bounds& body) {
                                              Bounds out = body;
                                              out.max.z() = body.min.z() + 0.013;
                                              return out;
                                            }});
  int there = 0;
  for (int i = 0; i < lattice.num_own_nodes(); ++i) there += std::abs(lattice.x[3 * i + 2] - 0.013) < 1e-12;
  EXPECT_EQ(there, 7 * 5);
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
