// A setting that may change while the body is touched has the range that its key has in a scene.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "haptics/halves/live_settings.hpp"

namespace kt {
namespace {

TEST(LiveSettings, HaveTheRangesOfTheSchema) {
  const nlohmann::json schema = nlohmann::json::parse(std::ifstream(KT_SOURCE_DIR "/io/scene/scene.schema.json"));
  const auto resolved = [&](nlohmann::json node) {
    while (node.contains("$ref"))
      node = schema.at(nlohmann::json::json_pointer(node["$ref"].get<std::string>().substr(1)));
    return node;
  };
  int numbers = 0;
  for (const LiveSetting& s : live_settings()) {
    nlohmann::json node = schema;
    std::istringstream words(s.key);
    for (std::string word; std::getline(words, word, '.');) node = resolved(node).at("properties").at(word);
    if (!s.number) {
      EXPECT_EQ(node.at("type"), "string") << s.key;
      continue;
    }
    ++numbers;
    EXPECT_EQ(node.at("maximum").get<double>(), s.most) << s.key;
    // A point's radius is 0 in a scene; a tool that has one keeps it above that.
    const bool above = s.above && s.key != std::string("tool.radius");
    EXPECT_EQ(node.contains("exclusiveMinimum"), above) << s.key;
    EXPECT_EQ(node.at(above ? "exclusiveMinimum" : "minimum").get<double>(), s.least) << s.key;
  }
  EXPECT_EQ(numbers, 10);
}

}  // namespace
}  // namespace kt
