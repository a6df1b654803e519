// Surfaces that are wrong in many ways at once: each becomes a lattice that is sound, or one line.
#include <gtest/gtest.h>

#include <random>

#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"
#include "io/solid/lattice.hpp"

namespace kt {
namespace {

Mesh ball() {
  Mesh out = kuhn_block(4, 4, 4, 0.5);
  out.tetrahedra.clear();
  for (int i = 0; i < out.num_nodes(); ++i) {
    const Vec3 off = node(out.x, i) - Vec3::Ones();
    node(out.x, i) = off.lpNorm<Eigen::Infinity>() * off.normalized();
  }
  return out;
}

class Mutation {
 public:
  explicit Mutation(unsigned seed) : random_(seed) {}

  Mesh of(Mesh surface) {
    for (std::size_t i = 1 + pick(4); i > 0; --i) change(surface);
    return surface;
  }

 private:
  std::size_t pick(std::size_t n) { return random_() % std::max<std::size_t>(n, 1); }
  double number(double most) { return std::uniform_real_distribution<>(-most, most)(random_); }
  Vec3 off(double most) { return {number(most), number(most), number(most)}; }
  Triangle& triangle(Mesh& m) { return m.triangles[pick(m.triangles.size())]; }

  void change(Mesh& m) {
    if (m.triangles.empty()) return;
    switch (pick(10)) {
      case 0:  // holes
        for (std::size_t i = pick(40); i > 0 && m.triangles.size() > 1; --i)
          m.triangles.erase(m.triangles.begin() + static_cast<std::ptrdiff_t>(pick(m.triangles.size())));
        break;
      case 1:  // turned triangles
        for (std::size_t i = pick(60); i > 0; --i) {
          Triangle& t = triangle(m);
          std::swap(t[0], t[1]);
        }
        break;
      case 2:  // duplicates
        for (std::size_t i = pick(60); i > 0; --i) m.triangles.push_back(Triangle(triangle(m)));
        break;
      case 3:  // through itself
        for (std::size_t i = pick(30); i > 0; --i)
          node(m.x, static_cast<int>(pick(static_cast<std::size_t>(m.num_nodes())))) += off(1.5);
        break;
      case 4:  // without area
        for (std::size_t i = pick(20); i > 0; --i) triangle(m)[1] = triangle(m)[0];
        break;
      case 5:  // another shell: within, crossing or apart, of either orientation
        add_shell(m, std::exp(number(1)), off(1.2), pick(2) == 0);
        break;
      case 6:  // flat
        for (int i = 0; i < m.num_nodes(); ++i) m.x[3 * i + 2] *= pick(2) == 0 ? 0.02 : 1;
        break;
      case 7:  // a needle
        node(m.x, triangle(m)[0]) *= 30;
        break;
      case 8:  // wrong neighbours
        for (std::size_t i = pick(10); i > 0; --i) triangle(m)[2] = triangle(m)[0];
        break;
      default:  // noise
        for (Eigen::Index i = 0; i < m.x.size(); ++i) m.x[i] += number(0.05);
    }
  }

  static void add_shell(Mesh& m, double size, const Vec3& at, bool turned) {
    const Mesh other = ball();
    const int first = m.num_nodes();
    VectorX x(m.x.size() + other.x.size());
    x << m.x, size * other.x;
    m.x = std::move(x);
    for (int i = first; i < m.num_nodes(); ++i) node(m.x, i) += at;
    for (const Triangle& t : other.triangles)
      m.triangles.push_back({t[0] + first, t[turned ? 2 : 1] + first, t[turned ? 1 : 2] + first});
  }

  std::mt19937_64 random_;
};

void expect_sound(const Mesh& lattice, unsigned seed) {
  const EmbeddedSurface& e = *lattice.embedded;
  const Bounds box = bounds(lattice);
  ASSERT_EQ(e.share.size(), lattice.tetrahedra.size()) << seed;
  ASSERT_EQ(e.first + e.num_vertices(), lattice.num_nodes()) << seed;
  for (std::size_t t = 0; t < lattice.tetrahedra.size(); ++t) {
    EXPECT_GT(tetrahedron_volume(lattice.x, lattice.tetrahedra[t]), 0) << seed;
    EXPECT_GT(e.share[t], 0) << seed;
    EXPECT_LE(e.share[t], 1 + 1e-9) << seed;
  }
  for (std::size_t v = 0; v < e.corners.size(); ++v) {
    ASSERT_GE(e.cell[v], 0) << seed;
    const Tetrahedron& cell = lattice.tetrahedra[static_cast<std::size_t>(e.cell[v])];
    EXPECT_EQ(cell, e.corners[v]) << seed;
    Vec3 place = Vec3::Zero();
    for (std::size_t c = 0; c < 4; ++c) {
      EXPECT_NEAR(e.weights[v][c], 0.5, 0.55) << seed;
      place += e.weights[v][c] * node(lattice.x, cell[c]);
    }
    EXPECT_LT((place - node(lattice.x, e.first + static_cast<int>(v))).norm(), 1e-9 * box.size().norm()) << seed;
    // It lies on the surface; where its cell's cube is one that the surface does not pass through, it lies just beside
    // it.
    const double depth = e.material->depth(e.cell[v], place, e.edge);
    EXPECT_TRUE(std::abs(depth) < 1e-6 * e.edge || std::abs(depth) == e.edge) << seed << ' ' << depth;
  }
}

TEST(LatticeOfWrongSurfaces, IsSoundOrOneLine) {
  int made = 0, refused = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Mesh surface = Mutation(seed).of(ball());
    try {
      expect_sound(make_lattice(surface, {.nodes = 40}), seed);
      ++made;
    } catch (const InputError& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
      ++refused;
    }
    if (testing::Test::HasFailure()) break;
  }
  EXPECT_GT(made, 150);
  EXPECT_LT(refused, 50);
}

}  // namespace
}  // namespace kt
