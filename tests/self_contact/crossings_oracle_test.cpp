// Where a surface passes through itself, against an exact search and by hand.
#include "self_contact/crossings.hpp"

#include <gtest/gtest.h>

#include "bench/pressed_bodies.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/surface/mesh_doctor.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

std::vector<std::array<int, 2>> crossings(const Mesh& mesh) {
  const auto model = make_model("fem", mesh, {.young = 1e4});
  SelfContact contact(*model, {});
  std::vector<std::array<int, 2>> out;
  for (const Crossing& crossing : find_crossings(contact, mesh.triangles, mesh.x)) out.push_back(crossing.triangles);
  return out;
}

Mesh two_blocks(const Vec3& apart) {
  const Mesh block = kuhn_block(2, 2, 2, 0.01);
  return joined({block, placed(block, apart)});
}

TEST(FindCrossings, BodiesApartHaveNone) {
  EXPECT_TRUE(crossings(two_blocks({0, 0, 0.0201})).empty());
  EXPECT_TRUE(crossings(two_blocks({0.0201, 0, 0})).empty());  // whole faces in one plane
}

/// Once an edge of a flat face counted as going through another triangle of it: at rest but for a step's rounding, the
/// signs of volumes are those of noise.
TEST(FindCrossings, AFlatFaceAfterAStepAtRestHasNone) {
  Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/two_blocks.msh");
  ModelOptions options{.young = 2e4, .poisson = 0.4, .damping_mass = 5, .damping_stiffness = 2e-3};
  options.material = "neo_hookean";
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (node(mesh.x, i).z() < 1e-4) options.fixed_nodes.push_back(i);
  const auto model = make_model("fem", mesh, options);
  SelfContact contact(*model, {.mu = 0.5});
  TouchingEuler integrator(contact);
  State state = rest_state(*model);
  integrator.step(*model, VectorX::Zero(state.x.size()), 0.033, state);
  EXPECT_TRUE(find_crossings(contact, mesh.triangles, state.x).empty());
}

TEST(FindCrossings, NodesOnNodesTouchAndDoNotCross) {
  const Mesh blocks = two_blocks({0, 0, 0.02});
  const auto model = make_model("fem", blocks, {.young = 1e4});
  SelfContact contact(*model, {});
  const auto found = find_crossings(contact, blocks.triangles, blocks.x);
  EXPECT_FALSE(found.empty());
  for (const Crossing& c : found) EXPECT_TRUE(c.only_touches) << c.triangles[0] << ' ' << c.triangles[1];
}

TEST(FindCrossings, AThinBodyThroughTheMiddleOfALargeFaceIsFound) {
  const Mesh large = kuhn_block(1, 1, 1, 0.1), thin = placed(kuhn_block(1, 1, 4, 0.005), {0.07, 0.03, 0.09});
  const auto found = crossings(joined({large, thin}));
  EXPECT_GE(found.size(), 8u);  // each of its four sides is two triangles
  for (const auto& [a, b] : found) EXPECT_TRUE(a < 12 && b >= 12) << a << " " << b;
}

/// No node of the thin body lies on the face that it goes through: none only touch.
TEST(FindPiercings, AreAllCrossingsWhereNoNodeLiesOnAFace) {
  const Mesh large = kuhn_block(1, 1, 1, 0.1), thin = placed(kuhn_block(1, 1, 4, 0.005), {0.0703, 0.0307, 0.0912});
  const Mesh both = joined({large, thin});
  std::vector<std::array<int, 2>> pierced;
  for (const Crossing& c : find_piercings(both.triangles, both.x)) pierced.push_back(c.triangles);
  EXPECT_GE(pierced.size(), 8u);
  EXPECT_EQ(pierced, crossings(both));
}

TEST(FindPiercings, AreNoneOfBodiesThatTouchOrAreApart) {
  for (const Vec3& apart : {Vec3(0, 0, 0.0201), Vec3(0, 0, 0.02), Vec3(0.0201, 0, 0)}) {
    const Mesh blocks = two_blocks(apart);
    EXPECT_TRUE(find_piercings(blocks.triangles, blocks.x).empty()) << apart.transpose();
  }
  for (const char* file : {"sphere.off", "torus.off", "organ.off", "block.msh"}) {
    const Mesh mesh = load_mesh(std::string(KT_SOURCE_DIR "/meshes/") + file);
    EXPECT_TRUE(find_piercings(mesh.triangles, mesh.x).empty()) << file;
  }
}

#if KT_WITH_CGAL
TEST(FindCrossings, AreThoseOfAnExactSearch) {
  int crossed = 0, free = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const VectorX r = random_vector(3, seed);
    Mesh mesh = joined(
        {kuhn_block(2, 2, 1, 0.02), placed(kuhn_block(2, 2, 2, 0.006), 0.02 * Vec3(r) + Vec3(0.014, 0.014, 0.014))});
    mesh.x += 5e-4 * random_vector(mesh.x.size(), seed + 100);
    bool complete = false;
    const auto exact = find_self_intersections(mesh, 10000, complete);
    ASSERT_TRUE(complete);
    EXPECT_EQ(crossings(mesh), exact) << seed;
    (exact.empty() ? free : crossed)++;
  }
  EXPECT_GT(crossed, 10);
  EXPECT_GT(free, 3);
}
#endif

}  // namespace
}  // namespace kt
