#include "core/base/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

/// $TMPDIR for one test; the old one comes back.
class Named {
 public:
  explicit Named(const char* folder) {
    if (const char* const old = std::getenv("TMPDIR")) old_ = old;
    ::setenv("TMPDIR", folder, 1);
  }
  ~Named() { old_.empty() ? ::unsetenv("TMPDIR") : ::setenv("TMPDIR", old_.c_str(), 1); }
  Named(const Named&) = delete;
  Named& operator=(const Named&) = delete;

 private:
  std::string old_;
};

TEST(TemporaryFolder, IsTheUsualOneWhereNoneIsNamed) {
  const Named empty("");
  EXPECT_EQ(temporary_folder(), "/tmp");
  EXPECT_EQ(temporary_folder("/var/tmp"), "/var/tmp");
}

TEST(TemporaryFolder, ThatIsNamedAndNotThereIsNamedInTheError) {
  const Named there("/usr");
  EXPECT_EQ(temporary_folder(), "/usr");
  const Named nowhere("/usr/no such folder");
  EXPECT_EQ(message([] { temporary_folder(); }).rfind("TMPDIR is \"/usr/no such folder\", which is no folder", 0), 0u);
}

}  // namespace
}  // namespace kt
