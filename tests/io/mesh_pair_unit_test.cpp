#include "io/mesh/mesh_pair.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

TEST(MeshPair, EitherFileNamesTheOther) {
  EXPECT_EQ(other_of_pair("a/pad.1.node"), "a/pad.1.ele");
  EXPECT_EQ(other_of_pair("a/pad.1.ele"), "a/pad.1.node");
  EXPECT_EQ(other_of_pair("a/pad.off"), "");
}

}  // namespace
}  // namespace kt
