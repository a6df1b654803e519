// Base64 against the examples of RFC 4648, and there and back.
#include "io/mesh/format/base64.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

TEST(Base64, IsThatOfRfc4648) {
  const std::pair<std::string, std::string> kExamples[] = {{"", ""},
                                                           {"f", "Zg=="},
                                                           {"fo", "Zm8="},
                                                           {"foo", "Zm9v"},
                                                           {"foob", "Zm9vYg=="},
                                                           {"fooba", "Zm9vYmE="},
                                                           {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : kExamples) EXPECT_EQ(to_base64(bytes), text);
}

TEST(Base64, ComesBackWhateverTheBytes) {
  std::string bytes;
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(from_base64(to_base64(bytes), bytes.size()), bytes);
    bytes += static_cast<char>(i * 37 + i / 256);
  }
}

}  // namespace
}  // namespace kt
