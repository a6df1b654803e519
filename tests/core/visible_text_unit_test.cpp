#include "core/base/visible_text.hpp"

#include <gtest/gtest.h>

#include <random>

namespace kt {
namespace {

TEST(VisibleText, PlainTextStays) {
  for (const char* text : {"", "a b", "C:\\meshes\\x.off", "Läsion 肝臓 🫀.off", "100 µm – 5 %"})
    EXPECT_EQ(visible(text), text);
}

TEST(VisibleText, WhatSteersATerminalIsSeen) {
  EXPECT_EQ(visible("a\nb\r\tc"), "a\\nb\\r\\tc");
  EXPECT_EQ(visible("\x1b[2J\x7f"), "\\x1b[2J\\x7f");
  EXPECT_EQ(visible("\xc2\x9b"
                    "31m"),
            "\\u009b31m");  // C1: control sequence introducer
  EXPECT_EQ(visible("a\xe2\x80\xa8"
                    "b\xe2\x80\xa9"),
            "a\\u2028b\\u2029");  // line, paragraph separator
  EXPECT_EQ(visible("\xe2\x80\xae"
                    "gpj.off"),
            "\\u202egpj.off");  // right to left from here on
  EXPECT_EQ(visible("\xe2\x81\xa6\xe2\x80\x8b\xef\xbb\xbf"), "\\u2066\\u200b\\ufeff");
  EXPECT_EQ(visible_lines("a\n\tb\x1b"), "a\n\tb\\x1b");
}

TEST(VisibleText, WhatIsNotUtf8IsSeen) {
  EXPECT_EQ(visible("b\xff"
                    "d"),
            "b\\xffd");
  EXPECT_EQ(visible("\xc0\xaf"), "\\xc0\\xaf");                    // longer than it must be
  EXPECT_EQ(visible("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // half of a surrogate pair
  EXPECT_EQ(visible("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond Unicode
  EXPECT_EQ(visible("\xe2\x82"), "\\xe2\\x82");                    // cut off
}

TEST(VisibleText, NamesKeepTheirBytes) {
  EXPECT_EQ(escape_bytes("b\xff"
                         "d.off"),
            "b\\xffd.off");
  EXPECT_EQ(escape_bytes("Läsion\\x.off"), "Läsion\\x.off");
  EXPECT_EQ(escape_bytes("b\\xffd.off"), "b\\x5cxffd.off");  // a name that looks like an escape is none
  std::mt19937 random(7);
  const std::string letters = "\\x5cf0\xff\xc3\xa4\xe2";
  for (int k = 0; k < 20000; ++k) {
    std::string name;
    for (auto n = random() % 12; n > 0; --n) name += letters[random() % letters.size()];
    ASSERT_EQ(unescape_bytes(escape_bytes(name)), name);
    ASSERT_EQ(visible(escape_bytes(name)), escape_bytes(name));  // UTF-8
  }
}

}  // namespace
}  // namespace kt
