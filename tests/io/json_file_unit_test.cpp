#include "io/files/json_file.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "io/files/shell_words.hpp"

namespace kt {
namespace {

std::string message_of(const std::string& json) {
  try {
    parse_json_text(json, "x.json");
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

std::string nested(int levels) {
  return std::string(static_cast<std::size_t>(levels), '[') + std::string(static_cast<std::size_t>(levels), ']');
}

TEST(ParseJsonText, SaysWhere) {
  EXPECT_EQ(message_of("{\n  \"a\": nul\n}"), "x.json:2:11: is not JSON from here on");
  EXPECT_EQ(message_of("[1e999]"), "x.json: is not JSON: a number in it is too large");
  EXPECT_EQ(message_of(nested(kDeepestJson)), "");
  EXPECT_EQ(message_of(text("\n", nested(kDeepestJson + 1))),
            "x.json:2: more than 100 levels of [ ] and { } inside one another; at most 100 are read");
  EXPECT_EQ(message_of(nested(1000000)).substr(0, 9), "x.json:1:");
}

TEST(RequireShallowJson, TextsAndCommentsAreNoLevels) {
  const std::string many(500, '[');
  EXPECT_NO_THROW(require_shallow_json(text(R"({"a": "\")", many, "\"}"), "x"));
  EXPECT_NO_THROW(require_shallow_json(text("// ", many, "\n{} /* ", many, " */"), "x"));
  EXPECT_NO_THROW(require_shallow_json(text('"', many), "x"));  // not closed
  EXPECT_NO_THROW(require_shallow_json("\"\\", "x"));
  EXPECT_THROW(require_shallow_json(text('"', many, '"', many), "x"), InputError);
}

TEST(JsonText, NamesThatAreNoUtf8CostNothing) {
  EXPECT_EQ(json_text(nlohmann::json("a\xff")), "\"a\xef\xbf\xbd\"");
  EXPECT_EQ(shown_json(nlohmann::ordered_json(std::string(100, 'x'))).size(), 63u);
}

TEST(ShellWords, QuotesWhatAShellWouldRead) {
  EXPECT_EQ(shell_words({"kilotouch", "run", "a/b-1.json", "--set", "contact.mu=0.8"}),
            "kilotouch run a/b-1.json --set contact.mu=0.8");
  EXPECT_EQ(shell_words({"it's", "a b", "$(x)", "", "\\"}), "'it'\\''s' 'a b' '$(x)' '' '\\'");
  EXPECT_EQ(shell_words({"L\xc3\xa4sion"}), "'L\xc3\xa4sion'");
  EXPECT_EQ(shell_words({"b\xff'\\\n"}), "$'b\\xff\\'\\\\\\x0a'");
}

}  // namespace
}  // namespace kt
