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
#include "io/files/output_folder.hpp"
#include "io/files/result_files.hpp"

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

TEST(WriteFileWhole, ALinkIsReplacedAndNotFollowed) {
  const PrivateFolder folder;
  write_file_whole(folder / "of_somebody", "theirs");
  fs::create_symlink("of_somebody", folder / "trace.csv");
  fs::create_symlink("nowhere", folder / "dangling");
  for (const char* name : {"trace.csv", "dangling"}) {
    write_file_whole(folder / name, "ours");
    EXPECT_FALSE(fs::is_symlink(folder / name));
    EXPECT_EQ(content(folder / name), "ours");
  }
  EXPECT_EQ(content(folder / "of_somebody"), "theirs");
  EXPECT_FALSE(fs::exists(folder / "nowhere"));
}

TEST(WriteFileWhole, AHardLinkLosesItsNameAndKeepsItsContent) {
  const PrivateFolder folder;
  write_file_whole(folder / "of_somebody", "theirs");
  fs::create_hard_link(folder / "of_somebody", folder / "trace.csv");
  write_file_whole(folder / "trace.csv", "ours");
  EXPECT_EQ(content(folder / "of_somebody"), "theirs");
}

TEST(WriteFileWhole, APipeInItsPlaceIsRefused) {
  const PrivateFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_NE(message_of(folder / "pipe").find("is a pipe"), std::string::npos);
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST(WriteNamedFile, ALinkIsWrittenThrough) {
  const PrivateFolder folder;
  fs::create_directory(folder / "deep");
  fs::create_symlink("deep/new", folder / "dangling");
  write_named_file(folder / "dangling", "x");
  EXPECT_TRUE(fs::is_symlink(folder / "dangling"));
  EXPECT_EQ(content(folder / "deep/new"), "x");
  fs::create_symlink("loop", folder / "loop");
  EXPECT_THROW(write_named_file(folder / "loop", "x"), InputError);
}

TEST(WriteNamedFile, APipeIsWrittenTo) {
  const PrivateFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = content(folder / "pipe"); });
  write_named_file(folder / "pipe", "through");
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

/// Says 3 where `act` throws InputError in a process whose files may not grow beyond `most` bytes, as on a full disk.
int code_with_small_files(rlim_t most, const std::function<void()>& act) {
  const PrivateFolder log;
  return run_forked(
             [&] {
               const rlimit limit{most, most};
               ::setrlimit(RLIMIT_FSIZE, &limit);
               ::signal(SIGXFSZ, SIG_IGN);
               act();
             },
             log, {.seconds = 10})
      .exit_code;
}

TEST(ResultFiles, AllTakeTheirPlacesOrNone) {
  const PrivateFolder folder;
  write_file_whole(folder / "summary.json", "old summary");
  write_file_whole(folder / "trace.csv", "old trace");
  write_file_whole(folder / "second.csv", "old second");
  const auto write = [&] {
    ResultFiles files(folder.path());
    files.add("summary.json", "new");
    files.drop("second.csv");
    files.add("trace.csv", std::string(1000, 'x'));
    files.commit();
  };
  EXPECT_EQ(code_with_small_files(100, write), 3);
  EXPECT_EQ(content(folder / "summary.json"), "old summary");
  EXPECT_EQ(content(folder / "second.csv"), "old second");
  EXPECT_EQ(entries(folder.path()), 3u);
  write();
  EXPECT_EQ(content(folder / "summary.json"), "new");
  EXPECT_EQ(content(folder / "trace.csv").size(), 1000u);
  EXPECT_EQ(entries(folder.path()), 2u);
}

TEST(RequireWritable, NamesWhatCannotBeWritten) {
  const PrivateFolder folder;
  EXPECT_NO_THROW(require_writable(folder / "a"));
  EXPECT_NO_THROW(require_writable(""));
  EXPECT_NO_THROW(require_writable("-"));
  EXPECT_THROW(require_writable(folder / "none/a"), InputError);
  EXPECT_THROW(require_writable(folder.path()), InputError);
  EXPECT_THROW(require_writable("/proc/kilotouch"), InputError);  // also of root, who may write to all
  write_file_whole(folder / "file", "");
  EXPECT_THROW(require_writable(folder / "file/a"), InputError);
  EXPECT_EQ(code_with_small_files(0, [&] { require_writable(folder / "a"); }), 3);
  EXPECT_EQ(entries(folder.path()), 1u);  // nothing is left of the trial
}

TEST(OutputFolder, IsRefusedBeforeTheWork) {
  const PrivateFolder folder;
  write_file_whole(folder / "file", "");
  for (const std::string& place : {folder / "file", folder / "file/deep", std::string("/proc/kilotouch/deep")})
    EXPECT_THROW(OutputFolder(place, "--out " + place), InputError) << place;
  EXPECT_EQ(code_with_small_files(0, [&] { const OutputFolder full(folder / "o", "--out o"); }), 3);
  fs::create_directories(folder / "taken/trace.csv");
  EXPECT_THROW(OutputFolder(folder / "taken", "--out taken", {"trace.csv"}), InputError);
  EXPECT_NO_THROW(OutputFolder(folder / "taken", "--out taken", {"summary.json"}));
}

TEST(OutputFolder, WhatItMadeAndNothingWasWrittenToIsRemoved) {
  const PrivateFolder folder;
  fs::create_directory(folder / "mine");
  for (const char* place : {"a/b/c", "a/b/c/", "mine/d", "mine"}) {
    const OutputFolder made(folder / place, "--out");
    EXPECT_TRUE(fs::is_directory(folder / place));
  }
  EXPECT_FALSE(fs::exists(folder / "a"));
  EXPECT_TRUE(fs::is_empty(folder / "mine"));
  {
    const OutputFolder made(folder / "a/b", "--out");
    write_file_whole(folder / "a/b/file", "x");
  }
  EXPECT_EQ(content(folder / "a/b/file"), "x");
}

TEST(OutputFolder, IsOneProcesssAlone) {
  const PrivateFolder folder;
  {
    const OutputFolder first(folder / "o", "--out o");
    EXPECT_THROW(OutputFolder(folder / "o", "--out o"), InputError);
    EXPECT_THROW(OutputFolder(folder / "o", "--out o", {}, FolderUse::shared), InputError);
  }
  const OutputFolder shared(folder / "o", "--out o", {}, FolderUse::shared);
  EXPECT_NO_THROW(OutputFolder(folder / "o", "--out o", {}, FolderUse::shared));
  EXPECT_THROW(OutputFolder(folder / "o", "--out o"), InputError);
}

TEST(InnerFolder, IsMadeOnceAndNeverALink) {
  const PrivateFolder folder;
  make_inner_folder(folder / "session");
  EXPECT_NO_THROW(make_inner_folder(folder / "session"));
  fs::create_directory(folder / "of_somebody");
  fs::create_symlink("of_somebody", folder / "link");
  write_file_whole(folder / "file", "");
  EXPECT_THROW(make_inner_folder(folder / "link"), InputError);
  EXPECT_THROW(make_inner_folder(folder / "file"), InputError);
}

}  // namespace
}  // namespace kt
