// The table of docs/method.md that names a place in the code for each of the paper's 28 equations.
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

namespace kt {
namespace {

constexpr int kEquations = 28;

std::string read(const std::string& file) {
  std::ifstream in(std::string(KT_SOURCE_DIR "/") + file);
  std::stringstream out;
  out << in.rdbuf();
  return out.str();
}

TEST(PaperEquations, EachHasItsRowInOrderAndANameThatItsFileDefines) {
  std::istringstream page(read("docs/method.md"));
  const std::regex row(R"(\| \((\d+)\) \| .+ \| `(\w+)` \| `([\w/.]+)` \|)");
  int last = 0;
  std::smatch found;
  for (std::string line; std::getline(page, line);) {
    if (!std::regex_match(line, found, row)) continue;
    EXPECT_EQ(std::stoi(found[1]), ++last) << line;
    const std::string code = read(found[3]);
    ASSERT_FALSE(code.empty()) << "no such file: " << line;
    // Named outside of comments: as a function, a type or a member.
    const std::string bare = std::regex_replace(code, std::regex("//[^\n]*"), "");
    EXPECT_TRUE(std::regex_search(bare, std::regex("\\b" + found[2].str() + "\\b"))) << "not there: " << line;
  }
  EXPECT_EQ(last, kEquations);
}

}  // namespace
}  // namespace kt
