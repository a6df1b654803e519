// Pictures of a body over a run: no torn rim around the patch, and as many frames as there is room for.
#include "haptics/session/body_film.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "haptics/touch/patch_lead.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-15;  // [m]

TEST(PatchLead, FadesOverTheNextRowsOfNodes) {
  const Mesh bar = kuhn_block(14, 1, 1, 0.01);
  const PatchLead lead(bar, {});
  VectorX before = bar.x, x = bar.x;
  const auto row = [&](int i) { return std::lround(node(bar.x, i).x() / 0.01); };
  for (int i = 0; i < bar.num_nodes(); ++i)
    if (row(i) <= 2) node(x, i) += Vec3(0, 0, 0.008);  // the patch: it has run ahead by 8 mm
  lead.fade(before, x);
  for (int i = 0; i < bar.num_nodes(); ++i) {
    const double expected = 0.008 * std::clamp(1 - static_cast<double>(row(i) - 2) / PatchLead::kRows, 0.0, 1.0);
    EXPECT_NEAR(node(x, i).z() - node(bar.x, i).z(), expected, kRoundoff) << i;
    EXPECT_EQ(node(x, i).x(), node(bar.x, i).x());
  }
}

TEST(PatchLead, LeavesThePatchAndWhatIsHeldWhereTheyAre) {
  const Mesh bar = kuhn_block(6, 2, 2, 0.01);
  std::vector<int> held;
  for (int i = 0; i < bar.num_nodes(); ++i)
    if (node(bar.x, i).x() > 0.035) held.push_back(i);
  const PatchLead lead(bar, held);
  VectorX x = bar.x;
  node(x, 0) += Vec3(0.001, 0.002, 0.003);
  const Vec3 patch = node(x, 0);
  lead.fade(bar.x, x);
  EXPECT_EQ(Vec3(node(x, 0)), patch);
  for (const int i : held) EXPECT_EQ(Vec3(node(x, i)), Vec3(node(bar.x, i)));
  EXPECT_NE(x, bar.x);
  VectorX same = bar.x;
  lead.fade(bar.x, same);
  EXPECT_EQ(same, bar.x) << "nothing has moved";
}

TEST(PatchLead, FollowsTheTrianglesOfASurfaceMesh) {
  Mesh surface = kuhn_block(6, 6, 6, 0.01);
  surface.tetrahedra.clear();
  const PatchLead lead(surface, {});
  VectorX x = surface.x;
  node(x, 0) += Vec3(0, 0, 0.008);
  lead.fade(surface.x, x);
  EXPECT_NEAR(node(x, 1).z() - node(surface.x, 1).z(), 0.007, kRoundoff);
}

TEST(BodyFilm, HoldsTheSurfaceAtItsTimes) {
  const Mesh block = kuhn_block(3, 3, 3, 0.01);
  BodyFilm film(block);
  EXPECT_EQ(film.nodes().size(), 56u) << "64 nodes, 8 of them inside";
  EXPECT_TRUE(film.is_due(0.001, false));
  film.add(0.001, block.x);
  EXPECT_FALSE(film.is_due(0.03, false));
  EXPECT_TRUE(film.is_due(0.03, true)) << "a new local model";
  EXPECT_FALSE(film.is_due(0.01, true)) << "but not every tick";
  EXPECT_TRUE(film.is_due(0.035, false));
  for (std::size_t k = 0; k < film.nodes().size(); ++k)
    for (int c = 0; c < 3; ++c)
      EXPECT_EQ(film.frames()[0][3 * k + c], static_cast<float>(node(block.x, film.nodes()[k])[c]));
}

TEST(BodyFilm, LeavesOutEverySecondFrameWhenItIsFull) {
  const Mesh block = kuhn_block(2, 2, 2, 0.01);
  constexpr std::size_t kRoom = 10;
  BodyFilm film(block, 6 * 26 * kRoom);
  VectorX x = block.x;
  for (int tick = 1; tick <= 20000; ++tick) {
    const double t = 0.001 * tick;
    x[0] = t;
    if (film.is_due(t, tick % 7 == 0)) film.add(t, x);
    ASSERT_LE(film.times().size(), kRoom);
  }
  ASSERT_EQ(film.times().size(), film.frames().size());
  EXPECT_GE(film.times().size(), kRoom / 2);
  EXPECT_EQ(film.times().front(), 0.001);
  EXPECT_GT(film.times().back(), 20 - film.interval());
  for (std::size_t i = 0; i < film.times().size(); ++i) {
    EXPECT_EQ(film.frames()[i][0], static_cast<float>(film.times()[i])) << "each with its own time";
    const double since = i > 0 ? film.times()[i] - film.times()[i - 1] : 0;
    EXPECT_LE(since, 1.01 * film.interval());
  }
}

}  // namespace
}  // namespace kt
