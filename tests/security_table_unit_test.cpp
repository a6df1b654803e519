// SECURITY.md has the rights by door. Each row names the tests that try it.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>

namespace kt {
namespace {

std::string content(const std::string& file) {
  std::ifstream in(KT_SOURCE_DIR "/" + file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(SecurityTable, NamesTestsThatAreThere) {
  std::istringstream page(content("SECURITY.md"));
  int rows = 0;
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| ") || line.starts_with("| door")) continue;
    ++rows;
    const std::size_t end = line.rfind(" |");
    const std::size_t begin = line.rfind(" | ", end - 1) + 3;
    std::istringstream tests(std::regex_replace(line.substr(begin, end - begin), std::regex("<br>"), ";"));
    for (std::string group; std::getline(tests, group, ';');) {
      static const std::regex kGroup(R"(\s*`(tests/\S+)` (.+))");
      std::smatch parts;
      ASSERT_TRUE(std::regex_match(group, parts, kGroup)) << line;
      const std::string file = content(parts[1]);
      EXPECT_FALSE(file.empty()) << parts[1];
      std::istringstream names(parts[2]);
      for (std::string name; names >> name;) {
        if (name.ends_with(',')) name.pop_back();
        EXPECT_NE(file.find(name), std::string::npos) << parts[1] << " has no " << name;
      }
    }
  }
  EXPECT_GE(rows, 15);
}

}  // namespace
}  // namespace kt
