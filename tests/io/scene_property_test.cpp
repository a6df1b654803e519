// The words and the verdict agree: every document that valijson refuses is explained, and nothing else is.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "core/base/error.hpp"
#include "io/scene/json_schema.hpp"
#include "io/scene/scene.hpp"

namespace kt {
namespace {

using Json = nlohmann::json;

const nlohmann::ordered_json& schema() {
  static const auto parsed = nlohmann::ordered_json::parse(scene_schema());
  return parsed;
}

/// "a.b.c" as "/a/b/c".
Json::json_pointer pointer_to(const std::string& key) {
  std::string path = "/" + key;
  for (char& c : path)
    if (c == '.') c = '/';
  return Json::json_pointer(path);
}

/// Values of every type, at and beyond every kind of bound.
const Json& odd_values() {
  static const Json values =
      Json::parse(R"([null, true, "", "x", "point", "z", 0, 1, -1, 0.5, 2, -0.5, 3601, 1e300, -1e300,
    101, 4294967296, 9007199254740992, [], {}, [1], [1, 2], [1, 2, 3], [1, 2, 3, 4], [[1, 2, 3], [4, 5, 6]], [[0, 1, 2, 3]],
    [[0, 1, 2, "x"]], [[0, 1, 2]], [[]], [-1], [0.5], ["a"], {"x": 1}, [{}]])");
  return values;
}

void expect_agreement(const Json& document) {
  const auto verdict = find_json_problem(document, schema());
  const auto words = explain_json(document, schema());
  EXPECT_EQ(verdict.has_value(), words.has_value())
      << document << "\nvalijson: " << (verdict ? verdict->path + " " + verdict->message : "fits")
      << "\nin words: " << (words ? words->path + " " + words->message : "fits");
}

TEST(SceneSchema, ValijsonAndTheWordsAgreeOnEveryKey) {
  for (const std::string& key : known_scene_keys())
    for (const Json& value : odd_values()) {
      Json document = Json::parse(R"({"object": {"mesh": "a.off"}})");
      document[pointer_to(key)] = value;
      expect_agreement(document);
    }
}

TEST(SceneSchema, ValijsonAndTheWordsAgreeOnGroupsAndPairs) {
  const std::vector<std::string> groups = {"object",         "object.fixed", "object.fixed.below",
                                           "object.model",   "tool",         "tool.path",
                                           "tool.path.hand", "contact",      "local"};
  for (const std::string& group : groups)
    for (const Json& value : odd_values()) {
      Json document = Json::parse(R"({"object": {"mesh": "a.off"}})");
      document[pointer_to(group)] = value;
      expect_agreement(document);
    }
  const std::vector<std::string> keys = known_scene_keys();
  for (std::size_t i = 0; i < keys.size(); ++i)
    for (std::size_t j = i; j < keys.size(); ++j) {
      const std::string &a = keys[i], &b = keys[j];
      Json document = Json::parse(R"({"object": {"mesh": "a.off"}})");
      for (const std::string& key : {a, b})
        if (key.rfind("contact.mu", 0) == 0 || key == "object.size" || key == "object.scale")
          document[pointer_to(key)] = 0.5;
        else if (key.rfind("tool.path.press", 0) == 0 || key.rfind("object.fixed", 0) == 0)
          document[pointer_to(key)] = Json::array({1, 2});
      expect_agreement(document);
    }
}

TEST(SceneSchema, EveryExplanationIsOneShortLine) {
  constexpr std::size_t kLine = 400;  // the longest lists the known keys of a group
  for (const std::string& key : known_scene_keys())
    for (const Json& value : odd_values()) {
      Json document = Json::parse(R"({"object": {"mesh": "a.off"}})");
      document[pointer_to(key)] = value;
      if (const auto problem = explain_json(document, schema())) {
        EXPECT_EQ(problem->message.find('\n'), std::string::npos);
        EXPECT_LT(problem->message.size(), kLine) << problem->message;
      }
    }
}

TEST(SceneText, DamagedFilesGiveOneLineOrAScene) {
  Scene scene = default_scene();
  scene.object.mesh = "a.off";
  const std::string whole = to_json(scene);
  std::mt19937 random(7);
  for (int round = 0; round < 3000; ++round) {
    std::string damaged = whole;
    for (int i = 0; i < 1 + round % 4; ++i) {
      const std::size_t at = random() % damaged.size();
      if (round % 3 == 0)
        damaged.erase(at, 1 + random() % 9);
      else if (round % 3 == 1)
        damaged[at] = static_cast<char>(random() % 256);
      else
        damaged.insert(at, std::string("{}[],:\"/0-e\n").substr(random() % 13, 1));
    }
    try {
      parse_scene(damaged);
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace kt
