#include "view/server/page_message.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/error.hpp"

namespace kt {
namespace {

using Kind = PageMessage::Kind;

std::string error_of(const std::string& message) {
  try {
    parse_page_message(message);
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(PageMessage, ReadsWhatThePageSends) {
  const PageMessage target = parse_page_message(R"({"type":"target","x":[0.01,-0.02,0.03],"number":7,"stamp":1234.5})");
  EXPECT_EQ(target.kind, Kind::target);
  EXPECT_EQ(target.x, Vec3(0.01, -0.02, 0.03));
  EXPECT_EQ(target.number, 7u);
  EXPECT_EQ(target.stamp, 1234.5);
  EXPECT_EQ(parse_page_message(R"({"type":"set","settings":["contact.mu=0.8"]})").settings,
            std::vector<std::string>{"contact.mu=0.8"});
  EXPECT_TRUE(parse_page_message(R"({"type":"pause","on":true})").on);
  EXPECT_EQ(parse_page_message(R"({"type":"open","name":"organ_drag"})").name, "organ_drag");
  EXPECT_EQ(parse_page_message(R"({"type":"seek","time":0.25})").stamp, 0.25);
  EXPECT_EQ(parse_page_message(R"({"type":"reset"})").kind, Kind::reset);
  EXPECT_EQ(parse_page_message(R"({"type":"cancel"})").kind, Kind::cancel);
}

TEST(PageMessage, TellsWhatIsWrongInOneLine) {
  EXPECT_NE(error_of("hello"), "");
  EXPECT_EQ(error_of("[1]"), "page: a message must be a group { }");
  EXPECT_EQ(error_of("{}"), "page: type is missing");
  EXPECT_NE(error_of(R"({"type":"fly"})").find("fly"), std::string::npos);
  EXPECT_NE(error_of(R"({"type":"target","x":[1,2],"number":0,"stamp":0})").find("three numbers"), std::string::npos);
  EXPECT_NE(error_of(R"({"type":"target","x":[1,2,1e7],"number":0,"stamp":0})").find("x[2]"), std::string::npos);
  EXPECT_NE(error_of(R"({"type":"target","x":[1,2,null],"number":0,"stamp":0})").find("x[2]"), std::string::npos);
  EXPECT_NE(error_of(R"({"type":"target","x":[1,2,3],"number":-1,"stamp":0})").find("number"), std::string::npos);
  EXPECT_NE(error_of(R"({"type":"pause","on":1})").find("true or false"), std::string::npos);
  EXPECT_NE(error_of(R"({"type":"set","settings":[]})").find("settings"), std::string::npos);
  EXPECT_NE(error_of(std::string(kLongestMessage + 1, ' ')).find("at most"), std::string::npos);
  EXPECT_NE(error_of(std::string(60000, '[')), "");
}

// Whatever arrives: a message, or InputError; places are finite.
TEST(PageMessage, SurvivesAnything) {
  const std::vector<std::string> seeds = {R"({"type":"target","x":[0.01,-0.02,0.03],"number":7,"stamp":1234.5})",
                                          R"({"type":"set","settings":["contact.mu=0.8","a=b"]})",
                                          R"({"type":"open","name":"organ_drag"})", R"({"type":"pause","on":true})",
                                          R"({"type":"seek","time":0.25})"};
  std::mt19937 random(1);
  const std::string parts = "{}[]\",:0123456789.eE+-nulltrefasx\\\xff\x01";
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string message = seeds[random() % seeds.size()];
    for (unsigned k = 0; k < 1 + random() % 4; ++k) {
      const std::size_t at = random() % message.size();
      switch (random() % 3) {
        case 0:
          message[at] = parts[random() % parts.size()];
          break;
        case 1:
          message.insert(at, 1, parts[random() % parts.size()]);
          break;
        default:
          message.erase(at, 1 + random() % 3);
      }
      if (message.empty()) message = "{}";
    }
    try {
      const PageMessage m = parse_page_message(message);
      EXPECT_TRUE(m.x.allFinite() && std::isfinite(m.stamp)) << message;
      ++read;
    } catch (const InputError&) {
    }
  }
  EXPECT_GT(read, 500);  // the mutations are not all nonsense
}

}  // namespace
}  // namespace kt
