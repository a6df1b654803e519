// Which cells object.model.element auto takes.
#include <gtest/gtest.h>

#include "io/scene/scene.hpp"

namespace kt {
namespace {

TEST(ElementOf, AutoHasTenNodesWhereFourWouldLockInALattice) {
  SceneObject object;
  object.body = "lattice";
  object.model.type = "fem";
  object.model.poisson = 0.45;
  EXPECT_EQ(element_of(object), "tet4");
  object.model.poisson = 0.46;
  EXPECT_EQ(element_of(object), "tet10");
  object.model.element = "tet4";
  EXPECT_EQ(element_of(object), "tet4") << "asked for";
  object.model.element = "auto";
  object.body = "mesh";
  EXPECT_EQ(element_of(object), "tet4") << "its tetrahedra are the file's";
  object.body = "lattice";
  object.model.type = "msd";
  EXPECT_EQ(element_of(object), "tet4") << "springs";
}

}  // namespace
}  // namespace kt
