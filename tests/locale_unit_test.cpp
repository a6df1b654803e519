// Nothing of a library reads or writes numbers by the locale of the program that it is part of: the calls that do so
// are not in the sources, and under a locale with a decimal comma texts, files and children stay as they are.
#include <gtest/gtest.h>
#include <unistd.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "io/files/child_process.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/solid/tetrahedralize.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

/// Parts of other programs: the C library, the Python package. The command's own sources run in the C locale.
const std::vector<std::string> kLibraries{"core",    "collision", "self_contact", "models", "io",
                                          "haptics", "api",       "network",      "view",   "python"};

std::string whole_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Locale, IsReadByNoSourceOfALibrary) {
  const std::regex by_locale(
      R"(\b(sto[dfil]|stold|strto(d|f|ld)|atof|[sf]?scanf|is(space|digit|alpha|alnum|upper|lower|xdigit|punct)|to(lower|upper)|put_time|strftime|std::format)\s*\()");
  const std::regex printed(R"(printf\([^;]*%[-+ #0-9.*]*[aefgAEFG])");
  for (const std::string& folder : kLibraries)
    for (const auto& entry : fs::recursive_directory_iterator(KT_SOURCE_DIR "/" + folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".hpp") continue;
      std::ifstream in(entry.path());
      int number = 0;
      for (std::string line; std::getline(in, line);) {
        ++number;
        const std::string code = line.substr(0, line.find("//"));
        EXPECT_FALSE(std::regex_search(code, by_locale) || std::regex_search(code, printed))
            << entry.path() << ':' << number << ": " << line << "\n  core/base/numbers.hpp has what does not";
      }
      const std::string all = whole_text(entry.path());
      const bool writes =
          std::regex_search(all, std::regex(R"(\b(ostringstream|stringstream|ofstream)\s+\w+\s*[;({])"));
      EXPECT_TRUE(!writes || all.find("std::locale::classic()") != std::string::npos ||
                  all.find("classic(") < all.size())
          << entry.path() << ": a stream with the host's locale";
    }
}

struct Grouped : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

/// A locale as of Germany in C and in C++, made here: no machine need have one.
class GermanHost {
 public:
  GermanHost() : before_(std::locale::global(std::locale(std::locale::classic(), new Grouped))) {
    write_file_whole(folder_ / "comma.src",
                     "comment_char %\nescape_char /\nLC_NUMERIC\ndecimal_point \",\"\nthousands_sep \".\"\ngrouping "
                     "3;3\nEND LC_NUMERIC\n");
    const std::string command =
        "localedef -c -i " + (folder_ / "comma.src") + " -f ANSI_X3.4-1968 " + (folder_ / "comma") + " >/dev/null 2>&1";
    static_cast<void>(!std::system(command.c_str()));
    ::setenv("LOCPATH", folder_.path().c_str(), 1);
    ::setenv("LC_ALL", "comma", 1);
    in_c_ = std::setlocale(LC_NUMERIC, "comma") != nullptr;
  }
  ~GermanHost() {
    std::setlocale(LC_NUMERIC, "C");
    ::unsetenv("LOCPATH");
    ::unsetenv("LC_ALL");
    std::locale::global(before_);
  }
  bool in_c() const { return in_c_; }  ///< printf writes a comma

 private:
  PrivateFolder folder_;
  std::locale before_;
  bool in_c_ = false;
};

TEST(Locale, OfTheHostIsNotThatOfTexts) {
  const GermanHost host;
  ASSERT_TRUE(host.in_c()) << "localedef makes no locale here";
  char written[16];
  std::snprintf(written, sizeof written, "%.1f", 1.5);
  ASSERT_STREQ(written, "1,5") << "the host's locale does not count";
  EXPECT_EQ(text(1234567, ' ', 0.5, ' ', 12345.5), "1234567 0.5 12345.5");
  EXPECT_EQ(with_digits(1234.5, 3), "1.23e+03");
  EXPECT_EQ(with_digits(0.00012345, 3), "0.000123");
  EXPECT_EQ(with_decimals(1234.5678, 2), "1234.57");
  EXPECT_EQ(sixteen_digits(0xabcdef), "0000000000abcdef");
  EXPECT_EQ(to_double("1.5"), 1.5);
  EXPECT_EQ(to_double("+1e3"), 1000);
  EXPECT_FALSE(to_double("1,5"));
  EXPECT_FALSE(to_double(" 1"));
  EXPECT_FALSE(to_double(""));
  EXPECT_EQ(leading_number("950000.5 us"), 950000.5);
}

TEST(Locale, OfTheHostIsNotThatOfMeshesAndTheirFilling) {
  const std::string file = KT_SOURCE_DIR "/meshes/pad.off";
  TetrahedralizeOptions options;
  options.max_volume = 4e-7;
  const Mesh surface = load_mesh(file);
#if KT_WITH_TETGEN
  options.backend = "tetgen";
  const Mesh right = tetrahedralize(surface, options);
#endif
  const PrivateFolder folder;
  const GermanHost host;
  EXPECT_EQ(load_mesh(file), surface);
  save_mesh(folder / "again.off", surface);
  EXPECT_EQ(load_mesh(folder / "again.off"), surface);
#if KT_WITH_TETGEN
  EXPECT_EQ(tetrahedralize(surface, options), right);
#endif
}

/// Programs that are started have the C locale, whatever the environment says.
TEST(Locale, OfChildrenIsC) {
  const GermanHost host;
  const PrivateFolder folder;
  EXPECT_TRUE(
      run_program({"sh", "-c", "test \"$(printf %.1f 1.5)\" = 1.5 && test \"$LC_ALL\" = C"}, folder, {}).good());
}

}  // namespace
}  // namespace kt
