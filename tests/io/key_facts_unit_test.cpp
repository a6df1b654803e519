// The table of keys that scripts/scene_fields makes of the schema, as the engine asks it.
#include "io/scene/key_facts.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "core/base/error.hpp"

namespace kt {
namespace {

TEST(KeyFacts, AreThoseOfTheSchema) {
  const KeyFacts poisson = facts_of("object.model.poisson");
  EXPECT_EQ(poisson.least, -1);
  EXPECT_EQ(poisson.most, 0.5);
  EXPECT_TRUE(poisson.above && poisson.below);
  const KeyFacts rate = facts_of("local.rate_hz");
  EXPECT_EQ(rate.least, 10);
  EXPECT_EQ(rate.most, 1e6);
  EXPECT_FALSE(rate.above || rate.below);
  EXPECT_EQ(facts_of("global.self_contact.creep").most, 10);  // a group that is not there by default
  EXPECT_EQ(facts_of("second_tool.path.hand.mass").most, 100);
  EXPECT_EQ(std::string(facts_of("local.rings").read_by.key), "local.reducer");
  EXPECT_THROW(facts_of("local.ring"), std::out_of_range);
  EXPECT_THROW(facts_of("locals"), std::out_of_range);
}

std::string limit_error(const SceneObject& object) {
  try {
    require_limits("object", object);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(KeyFacts, RefuseANumberWhereverItIs) {
  SceneObject object;
  EXPECT_EQ(limit_error(object), "");
  object.model.young = 0;
  EXPECT_EQ(limit_error(object), "object.model.young is 0, must be above 0, at most 1e+13");
  object = {};
  object.lattice.emplace().nodes = 7;
  EXPECT_EQ(limit_error(object), "object.lattice.nodes is 7, must be at least 8, at most 20000");
  object = {};
  object.model.inclusions = {{.radius = 1, .stiffer = 2}, {.radius = -1, .stiffer = 2}};
  EXPECT_EQ(limit_error(object), "object.model.inclusions[1].radius is -1, must be above 0, at most 1000");
  object = {};
  object.size = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(limit_error(object), "object.size is nan, must be above 0, at most 1000");
}

TEST(UnreadKeys, AreThoseThatWereChangedAndThatAnotherWordReads) {
  Scene scene;
  EXPECT_TRUE(unread_keys(scene).empty());
  scene.local.rings = 2;
  scene.second_tool.emplace().length = 0.03;
  scene.object.model.least_volume = 0.5;  // of springs, as they are
  const std::vector<UnreadKey> found = unread_keys(scene);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].key, "second_tool.length");
  EXPECT_EQ(found[0].value, "0.03");
  EXPECT_EQ(found[0].chooser, "second_tool.shape");
  EXPECT_EQ(found[0].chosen, "sphere");
  EXPECT_EQ(found[0].would_be, std::vector<std::string>{"capsule"});
  EXPECT_EQ(found[1].key, "local.rings");
  scene.local.reducer = "wall";
  EXPECT_EQ(unread_keys(scene).size(), 1u);
}

}  // namespace
}  // namespace kt
