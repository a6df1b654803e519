// Slabs of elements: every element once, and no node shared between slabs that run at the same time.
#include <gtest/gtest.h>

#include <random>

#include "models/fem/slabs.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

void expect_valid(int num_nodes, const std::vector<Tetrahedron>& elements) {
  const Slabs slabs = make_slabs<4>(num_nodes, elements);
  std::vector<int> seen = slabs.elements;
  std::sort(seen.begin(), seen.end());
  for (std::size_t i = 0; i < elements.size(); ++i) ASSERT_EQ(seen.at(i), static_cast<int>(i));
  ASSERT_EQ(slabs.begin.back(), static_cast<int>(elements.size()));
  for (int parity : {0, 1}) {
    std::vector<int> owner(static_cast<std::size_t>(num_nodes), -1);
    for (int s = parity; s < slabs.count(); s += 2)
      for (int k = slabs.begin[s]; k < slabs.begin[s + 1]; ++k)
        for (int a : elements[slabs.elements[k]]) {
          ASSERT_TRUE(owner[a] < 0 || owner[a] == s) << "node " << a << " in slabs " << owner[a] << " and " << s;
          owner[a] = s;
        }
  }
}

TEST(Slabs, ShareNoNodeWithTheirSecondNeighbours) {
  const Mesh block = kuhn_block(12, 9, 7, 0.01);
  expect_valid(block.num_nodes(), block.tetrahedra);
  EXPECT_GT(make_slabs<4>(block.num_nodes(), block.tetrahedra).count(), 8);
}

TEST(Slabs, TakeSeveralComponentsNodesWithoutElementsAndShuffledElements) {
  const Mesh block = kuhn_block(6, 6, 6, 0.01);
  std::vector<Tetrahedron> two = block.tetrahedra;
  const int n = block.num_nodes() + 5;  // five without elements between the two
  for (const Tetrahedron& t : block.tetrahedra) two.push_back({t[0] + n, t[1] + n, t[2] + n, t[3] + n});
  std::shuffle(two.begin(), two.end(), std::mt19937(3));
  expect_valid(n + block.num_nodes(), two);
  expect_valid(3, {});
}

}  // namespace
}  // namespace kt
