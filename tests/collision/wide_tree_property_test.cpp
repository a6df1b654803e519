// The shape of the hierarchy: every triangle once, children after parents, and never deeper than the queries' stack.
#include "collision/broad/wide_tree.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

void expect_sound(const WideTree& tree, int num_triangles) {
  ASSERT_GE(tree.num_nodes(), 1);
  ASSERT_EQ(tree.child.size(), static_cast<std::size_t>(kTreeWidth * tree.num_nodes()));
  ASSERT_LE(tree.num_levels(), kMaxTreeLevels);
  EXPECT_EQ(tree.level_begin.front(), 0);
  EXPECT_EQ(tree.level_begin.back(), tree.num_nodes());
  EXPECT_EQ(tree.parent_slot[0], -1);
  std::vector<int> seen(static_cast<std::size_t>(num_triangles)), level(static_cast<std::size_t>(tree.num_nodes()));
  for (int l = 0; l < tree.num_levels(); ++l)
    for (int i = tree.level_begin[l]; i < tree.level_begin[l + 1]; ++i) level[i] = l;
  int nodes = 1;
  for (int s = 0; s < static_cast<int>(tree.child.size()); ++s) {
    const int child = tree.child[s];
    if (child == WideTree::kEmpty) continue;
    if (child < 0) {
      ASSERT_LT(~child, num_triangles);
      ++seen[~child];
      continue;
    }
    ASSERT_LT(child, tree.num_nodes());
    EXPECT_EQ(tree.parent_slot[child], s);
    EXPECT_EQ(level[child], level[s / kTreeWidth] + 1);
    ++nodes;
  }
  EXPECT_EQ(nodes, tree.num_nodes());
  EXPECT_EQ(seen, std::vector<int>(seen.size(), 1));
}

std::vector<Box> random_boxes(Sample& s, int n, double size) {
  std::vector<Box> out;
  for (int i = 0; i < n; ++i) {
    const Vec3 a = s.cube(), b = a + size * s.cube();
    out.push_back({a.cwiseMin(b), a.cwiseMax(b)});
  }
  return out;
}

TEST(WideTree, HoldsEveryTriangleOnce) {
  Sample s{std::mt19937_64(71)};
  for (int n = 0; n < 70; ++n) expect_sound(make_wide_tree(random_boxes(s, n, 0.1)), n);
  for (const double size : {0.0, 0.01, 10.0}) expect_sound(make_wide_tree(random_boxes(s, 5000, size)), 5000);
}

TEST(WideTree, FillsItsNodes) {
  Sample s{std::mt19937_64(72)};
  const WideTree tree = make_wide_tree(random_boxes(s, 20000, 0.02));
  EXPECT_LT(tree.num_nodes(), 20000 / 2);  // 20000 / 3 if every slot were taken
  EXPECT_LT(tree.num_levels(), 14);        // 8 if every slot were taken
}

TEST(WideTree, StaysShallowWhateverTheBoxes) {
  constexpr int n = 3000;
  const auto boxes = [](auto&& place) {
    std::vector<Box> out;
    for (int i = 0; i < n; ++i) out.push_back({place(i), place(i)});
    return out;
  };
  const double huge = std::numeric_limits<double>::max();
  for (const auto& all : {
           boxes([](int) { return Vec3(1, 2, 3); }),
           boxes([](int i) { return Vec3(std::ldexp(1.0, i / 10 - 150), 0, 0); }),  // each cut parts a few from many
           boxes([](int i) { return Vec3(std::ldexp(1.0, i - 1000), 0, 0); }),
           boxes([&](int i) { return Vec3(i % 2 ? huge : -huge, i, huge); }),
           boxes([](int i) { return Vec3(1e6 + 1e-9 * i, 0, 0); }),
           std::vector<Box>(n, everywhere()),
       })
    expect_sound(make_wide_tree(all), n);
}

TEST(WideTree, OneBoxThatIsEverywhereDoesNotSpoilTheRest) {
  Sample s{std::mt19937_64(73)};
  std::vector<Box> boxes = random_boxes(s, 5000, 0.02);
  boxes[1234] = everywhere();
  boxes[0] = everywhere();
  const WideTree tree = make_wide_tree(boxes);
  expect_sound(tree, 5000);
  EXPECT_LT(tree.num_levels(), 14);
}

}  // namespace
}  // namespace kt
