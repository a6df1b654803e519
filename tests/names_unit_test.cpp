// One name, one type: two types of one name in namespace kt may be in one program, and the linker would take the
// functions of either for both.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>

namespace kt {
namespace {

namespace fs = std::filesystem;

TEST(Names, NoTwoHeadersDefineATypeOfTheSameName) {
  const std::regex definition("(struct|class|enum class|enum) ([A-Za-z0-9_]+)[^;(]*\\{.*");
  const std::regex opening("namespace ([A-Za-z0-9_:]+) \\{");
  std::map<std::string, std::string> home;
  for (const char* folder : {"core", "collision", "self_contact", "models", "io", "haptics", "apps", "lab"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(KT_SOURCE_DIR) / folder)) {
      if (entry.path().extension() != ".hpp") continue;
      const std::string file = fs::relative(entry.path(), KT_SOURCE_DIR).generic_string();
      std::ifstream in(entry.path());
      std::smatch found;
      std::vector<std::string> inside;
      for (std::string line; std::getline(in, line);)
        if (std::regex_match(line, found, opening)) {
          inside.push_back((inside.empty() ? "" : inside.back() + "::") + found.str(1));
        } else if (line.starts_with("}  // namespace")) {
          if (!inside.empty()) inside.pop_back();
        } else if (std::regex_match(line, found, definition)) {
          const std::string name = (inside.empty() ? "" : inside.back() + "::") + found.str(2);
          const auto [at, is_new] = home.emplace(name, file);
          EXPECT_TRUE(is_new) << name << ": in " << at->second << " and in " << file;
        }
    }
  EXPECT_GT(home.size(), 200u);  // the headers were found
}

}  // namespace
}  // namespace kt
