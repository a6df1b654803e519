#include "io/files/output_file.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "core/base/error.hpp"
#include "io/files/child_process.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

std::string content(const std::string& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

std::size_t entries(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::string message_of(const std::string& path) {
  try {
    write_file_whole(path, "new");
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

TEST(WriteFileWhole, NewAndOldFilesAreReplacedAndNothingElseIsLeft) {
  const PrivateFolder folder;
  write_file_whole(folder / "a", "first");
  ::chmod((folder / "a").c_str(), 0640);
  write_file_whole(folder / "a", "second");
  EXPECT_EQ(content(folder / "a"), "second");
  struct stat found {};
  ::stat((folder / "a").c_str(), &found);
  EXPECT_EQ(found.st_mode & 0777, 0640u);
  EXPECT_EQ(entries(folder.path()), 1u);
}

TEST(WriteFileWhole, PartsAreWrittenInTheirOrder) {
  const PrivateFolder folder;
  std::string expected;
  int i = 0;
  write_file_whole(folder / "a", [&](std::string& part) {
    part = i < 3 ? std::string(static_cast<std::size_t>(i) * 100000, static_cast<char>('a' + i)) : "";
    expected += part;
    return i++ < 3;
  });
  EXPECT_EQ(content(folder / "a"), expected);
  EXPECT_EQ(expected.size(), 300000u);
  EXPECT_THROW(write_file_whole(folder / "a", [](std::string&) -> bool { throw RunError("half"); }), RunError);
  EXPECT_EQ(content(folder / "a"), expected);
  EXPECT_EQ(entries(folder.path()), 1u);
}

TEST(WriteFileWhole, ALinkIsWrittenThrough) {
  const PrivateFolder folder;
  fs::create_directory(folder / "deep");
  fs::create_symlink("deep/new", folder / "dangling");
  write_file_whole(folder / "dangling", "x");
  EXPECT_TRUE(fs::is_symlink(folder / "dangling"));
  EXPECT_EQ(content(folder / "deep/new"), "x");
  fs::create_symlink("loop", folder / "loop");
  EXPECT_NE(message_of(folder / "loop").find("cannot be written"), std::string::npos);
}

TEST(WriteFileWhole, APipeIsWrittenTo) {
  const PrivateFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = content(folder / "pipe"); });
  write_file_whole(folder / "pipe", "through");
  reader.join();
  EXPECT_EQ(got, "through");
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST(WriteFileWhole, AFailureLeavesTheOldFile) {
  const PrivateFolder folder;
  EXPECT_NE(message_of(folder.path()).find("is a directory"), std::string::npos);
  EXPECT_NE(message_of(folder / "none/a").find("none/a"), std::string::npos);
  write_file_whole(folder / "a", "old");
  // A file may hold three bytes in this child.
  const ChildResult child = run_forked(
      [&] {
        const rlimit three{3, 3};
        ::setrlimit(RLIMIT_FSIZE, &three);
        ::signal(SIGXFSZ, SIG_IGN);
        write_file_whole(folder / "a", "much longer");
      },
      folder, {.seconds = 10});
  EXPECT_EQ(child.exit_code, 3);
  EXPECT_EQ(content(folder / "a"), "old");
  EXPECT_EQ(entries(folder.path()), 2u);  // and the child's log
}

TEST(RequireFolderOf, NamesWhatCannotBeWritten) {
  const PrivateFolder folder;
  EXPECT_NO_THROW(require_folder_of(folder / "a"));
  EXPECT_NO_THROW(require_folder_of(""));
  EXPECT_THROW(require_folder_of(folder / "none/a"), InputError);
  EXPECT_THROW(require_folder_of(folder.path()), InputError);
}

}  // namespace
}  // namespace kt
