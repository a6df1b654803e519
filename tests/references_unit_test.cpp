// What comments, messages and pages refer to: every page, every heading of a page and every file named exists.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

namespace kt {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = KT_SOURCE_DIR;

/// "8 What is `measured`?" -> "8-what-is-measured", as web pages of repositories name a heading.
std::string anchor_of(const std::string& heading) {
  std::string out;
  for (const unsigned char c : heading) {
    if (std::isalnum(c) || c == '-' || c == '_') out += static_cast<char>(std::tolower(c));
    if (c == ' ') out += '-';
  }
  return out;
}

std::set<std::string> anchors_in(const fs::path& page) {
  std::set<std::string> out;
  std::ifstream in(page);
  for (std::string line; std::getline(in, line);)
    if (const auto at = line.find_first_not_of('#'); at > 0 && at < line.size() && line[at] == ' ')
      out.insert(anchor_of(line.substr(at + 1)));
  return out;
}

struct Place {
  std::string file, text;
  int line = 0;
};

/// The lines of our texts that name a page. The change log tells of pages as they were.
std::vector<Place> lines_with_pages() {
  std::vector<Place> out;
  const std::regex ours(".*\\.([ch]pp|def|py|md|cmake)");
  for (auto at = fs::recursive_directory_iterator(kRoot); at != fs::recursive_directory_iterator(); ++at) {
    const std::string file = fs::relative(at->path(), kRoot).generic_string();
    if (at->is_directory()) {
      if (file.front() == '.' || file == "build" || file == "out") at.disable_recursion_pending();
      continue;
    }
    if (!std::regex_match(file, ours) || file == "CHANGELOG.md" || file == "tests/references_unit_test.cpp") continue;
    std::ifstream in(at->path());
    Place place{file, "", 0};
    while (std::getline(in, place.text)) {
      ++place.line;
      if (place.text.find(".md") != std::string::npos) out.push_back(place);
    }
  }
  return out;
}

/// Beside the file that names it, from the root, or in docs/; empty when there is no such page.
fs::path find_page(const std::string& from, const std::string& name) {
  for (const fs::path& folder : {(kRoot / from).parent_path(), kRoot, kRoot / "docs"})
    if (fs::exists(folder / name)) return folder / name;
  return {};
}

TEST(References, AnchorsAreThoseOfTheirHeadings) {
  EXPECT_EQ(anchor_of("8 What is measured"), "8-what-is-measured");
  EXPECT_EQ(anchor_of("3 Linearization (3)\u2013(4)"), "3-linearization-34");
  EXPECT_EQ(anchor_of("Measures in `summary.json`"), "measures-in-summaryjson");
}

TEST(References, EveryPageAndHeadingExists) {
  const std::regex reference("([A-Za-z0-9_.][A-Za-z0-9_./-]*[A-Za-z0-9_]\\.md)(#([A-Za-z0-9_-]+))?");
  std::map<fs::path, std::set<std::string>> anchors;
  int found = 0;
  for (const Place& p : lines_with_pages())
    for (std::sregex_iterator m(p.text.begin(), p.text.end(), reference), end; m != end; ++m, ++found) {
      const fs::path page = find_page(p.file, (*m)[1]);
      EXPECT_FALSE(page.empty()) << p.file << ":" << p.line << ": there is no page " << (*m)[1];
      if (page.empty() || !(*m)[3].matched) continue;
      if (!anchors.count(page)) anchors[page] = anchors_in(page);
      EXPECT_TRUE(anchors[page].count((*m)[3]))
          << p.file << ":" << p.line << ": " << (*m)[1] << " has no heading #" << (*m)[3];
    }
  EXPECT_GT(found, 100);  // the files were read
}

/// Links as a reader of a page follows them: from the page's own folder, to a file that is there and a heading of it.
TEST(References, EveryLinkOfAPageLeadsSomewhere) {
  const std::regex link("\\]\\(([^()#\\s]*)(#([^()\\s]+))?\\)|src=\"([^\"]+)\"");
  int found = 0;
  for (auto at = fs::recursive_directory_iterator(kRoot); at != fs::recursive_directory_iterator(); ++at) {
    const std::string file = fs::relative(at->path(), kRoot).generic_string();
    if (at->is_directory() && (file.front() == '.' || file == "build" || file == "out")) at.disable_recursion_pending();
    if (at->path().extension() != ".md") continue;
    std::ifstream in(at->path());
    bool is_code = false;
    int number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      if (line.starts_with("```")) is_code = !is_code;
      if (is_code || line.starts_with("    ")) continue;
      for (std::sregex_iterator m(line.begin(), line.end(), link), end; m != end; ++m) {
        const std::string target = (*m)[4].matched ? (*m)[4].str() : (*m)[1].str();
        if (target.find(':') != std::string::npos) continue;  // on the web
        ++found;
        const fs::path to = target.empty() ? at->path() : at->path().parent_path() / target;
        EXPECT_TRUE(fs::exists(to)) << file << ":" << number << ": there is no " << target;
        if ((*m)[3].matched && to.extension() == ".md" && fs::exists(to)) {
          EXPECT_TRUE(anchors_in(to).count((*m)[3]))
              << file << ":" << number << ": " << to.filename() << " has no heading #" << (*m)[3];
        }
      }
    }
  }
  EXPECT_GT(found, 100);
}

/// A number says nothing when sections move; a heading's name is checked above.
TEST(References, SectionsOfPagesAreNamedByTheirHeadings) {
  const std::regex number("\\.md[`)]*,? +(sections?|notes?) [0-9]+");
  for (const Place& p : lines_with_pages())
    EXPECT_FALSE(std::regex_search(p.text, number)) << p.file << ":" << p.line << ": " << p.text;
}

TEST(References, FilesInPagesExist) {
  const std::regex code(
      "`((core|collision|self_contact|models|io|haptics|apps|lab|bench|scripts|scenes|meshes|tests|cmake)/"
      "[A-Za-z0-9_./-]+\\.[a-z]+)`");
  int found = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "docs")) {
    if (entry.path().extension() != ".md" || entry.path().stem() == "how_to_add") continue;  // files yet to be made
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);)
      for (std::sregex_iterator m(line.begin(), line.end(), code), end; m != end; ++m, ++found)
        EXPECT_TRUE(fs::exists(kRoot / m->str(1)))
            << entry.path().filename() << " names " << m->str(1) << ", which is not there";
  }
  EXPECT_GT(found, 40);
}

/// A file of ours: in no folder that is made, and a source.
std::vector<fs::path> our_sources() {
  std::vector<fs::path> out;
  for (auto at = fs::recursive_directory_iterator(kRoot); at != fs::recursive_directory_iterator(); ++at) {
    const std::string file = fs::relative(at->path(), kRoot).generic_string();
    if (at->is_directory() && (file.front() == '.' || file == "build" || file == "out")) at.disable_recursion_pending();
    if (std::regex_match(file, std::regex(".*\\.([ch]pp|def|h|c|in)"))) out.push_back(at->path());
  }
  return out;
}

/// What comments name that is there no more: "moved.hpp", "gone()".
std::vector<std::string> dead_names(const std::string& comment, const std::set<std::string>& files,
                                    const std::set<std::string>& identifiers) {
  static const std::regex file("[A-Za-z0-9_/.]*[A-Za-z0-9_]\\.([ch]pp|def)\\b"),
      function("([a-z_][A-Za-z0-9_]*)\\(\\)");
  std::vector<std::string> out;
  for (std::sregex_iterator m(comment.begin(), comment.end(), file), end; m != end; ++m) {
    const char before = m->position() > 0 ? comment[static_cast<std::size_t>(m->position()) - 1] : ' ';
    const bool is_part = before == ',' || before == '{' || before == '*' || before == '}';  // "{fem,msd}_model.hpp"
    if (!is_part && !files.contains(fs::path(m->str()).filename())) out.push_back(m->str());
  }
  for (std::sregex_iterator m(comment.begin(), comment.end(), function), end; m != end; ++m)
    if (!identifiers.contains((*m)[1])) out.push_back(m->str());
  return out;
}

TEST(References, FilesAndFunctionsInCommentsExist) {
  const std::set<std::string> files{"here.hpp", "main.cpp"}, identifiers{"step"};
  EXPECT_EQ(dead_names("see core/here.hpp, gone.hpp, step() and moved()", files, identifiers),
            (std::vector<std::string>{"gone.hpp", "moved()"}));
  std::set<std::string> ours{"awaitable.hpp"}, names;  // Boost's
  std::vector<Place> comments;
  for (const fs::path& path : our_sources()) {
    ours.insert(path.filename());
    if (path.filename() == "references_unit_test.cpp") continue;
    std::ifstream in(path);
    Place place{fs::relative(path, kRoot).generic_string(), "", 0};
    for (std::string line; std::getline(in, line);) {
      ++place.line;
      const std::size_t at = line.starts_with("//") ? 0 : line.find(" //");
      for (std::size_t i = 0; i < std::min(at, line.size());) {  // a regular expression takes seconds
        std::size_t end = i;
        while (end < line.size() && (std::isalnum(static_cast<unsigned char>(line[end])) || line[end] == '_')) ++end;
        if (end > i) names.insert(line.substr(i, end - i));
        i = std::max(end, i + 1);
      }
      if (at == std::string::npos) continue;
      place.text = line.substr(at);
      if (place.text.find("pp") != std::string::npos || place.text.find(".def") != std::string::npos ||
          place.text.find("()") != std::string::npos)
        comments.push_back(place);
    }
  }
  for (const Place& p : comments)
    for (const std::string& name : dead_names(p.text, ours, names))
      ADD_FAILURE() << p.file << ":" << p.line << ": there is no " << name;
  EXPECT_GT(comments.size(), 100u);
}

}  // namespace
}  // namespace kt
