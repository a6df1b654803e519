#include "io/files/file_claim.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.hpp"
#include "io/files/child_process.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

TEST(FileClaim, IsOfOneAtATimeByWhateverWay) {
  const PrivateFolder folder;
  const std::string file = folder / "a.json", link = folder / "link.json";
  ASSERT_EQ(::symlink("a.json", link.c_str()), 0);
  {
    const FileClaim first(file, "--json a.json");
    for (const std::string& name :
         {file, link, folder.path() + "/../" + folder.path().substr(folder.path().rfind('/') + 1) + "/a.json"})
      EXPECT_EQ(message([&] { FileClaim(name, "--json x"); }),
                "--json x: another kilotouch is writing to it; wait for its end, or give another file")
          << name;
    const FileClaim other(folder / "b.json", "");
  }
  const FileClaim again(link, "");
  EXPECT_NE(::access(file.c_str(), F_OK), 0) << "nothing is made";
}

TEST(FileClaim, PipesAndStandardOutputAreShared) {
  const PrivateFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& name : {pipe, std::string("-"), std::string(), std::string("/dev/null")}) {
    const FileClaim first(name, "");
    const FileClaim second(name, "");
  }
}

}  // namespace
}  // namespace kt
