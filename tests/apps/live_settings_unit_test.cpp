// A setting that may change while the body is touched has the range that its key has in a scene.
#include "haptics/touch/live_settings.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "io/scene/number_range.hpp"

namespace kt {
namespace {

bool is_taken(const std::string& key, double value) {
  TouchOptions touch;
  touch.tools.resize(1);
  touch.tools[0].shape.kind = ToolShape::Kind::sphere;
  touch.local.rate_hz = 1e9;  // of the bounds this one is another setting's
  touch.contact.mu_static = 1e9;
  SceneModel material;
  try {
    change_setting({.tick = 0, .key = key, .value = value, .word = {}}, {touch, material});
  } catch (const InputError&) {
    return false;
  }
  return true;
}

TEST(LiveSettings, HaveTheRangesOfTheSchema) {
  int numbers = 0;
  for (const LiveSetting& s : live_settings()) {
    if (!s.number) continue;
    ++numbers;
    const NumberRange range = number_range(s.key);
    EXPECT_TRUE(std::isfinite(range.least) && std::isfinite(range.most)) << s.key;
    EXPECT_TRUE(is_taken(s.key, range.most)) << s.key;
    EXPECT_FALSE(is_taken(s.key, 1.001 * range.most)) << s.key;
    EXPECT_EQ(is_taken(s.key, range.least), !range.above && s.key != std::string("tool.radius")) << s.key;
    EXPECT_FALSE(is_taken(s.key, range.least - 1)) << s.key;
    EXPECT_FALSE(is_taken(s.key, std::nan(""))) << s.key;
  }
  EXPECT_EQ(numbers, 10);
  EXPECT_EQ(number_range("contact.mu").told(), "at least 0, at most 100");
  EXPECT_EQ(number_range("object.model.young").told(), "above 0, at most 1e+13");
  EXPECT_THROW(number_range("local.reducer"), InputError);
  EXPECT_THROW(number_range("contact.nu"), InputError);
}

}  // namespace
}  // namespace kt
