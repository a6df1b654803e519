// Keys in files.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "network/control/curve_keys.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

class CurveKeys : public testing::Test {
 protected:
  void SetUp() override { fs::remove_all(dir_); }
  void TearDown() override { fs::remove_all(fs::path(dir_).parent_path()); }
  static std::string content(const std::string& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::string written(const std::string& text) const {
    fs::create_directories(dir_);
    std::ofstream(dir_ + "/list") << text;
    return dir_ + "/list";
  }
  const std::string dir_ =
      testing::TempDir() + "kt_curve_keys_" + std::to_string(::getpid()) + "/deep";  // tests run beside each other
};

TEST_F(CurveKeys, AreWrittenOnceAndRead) {
  make_key(dir_);
  struct stat secret {};
  ASSERT_EQ(::stat((dir_ + "/secret.key").c_str(), &secret), 0);
  EXPECT_EQ(secret.st_mode & 0777, 0600u);
  const CurveKey key = read_key(dir_);
  EXPECT_TRUE(is_curve_key(key.public_key));
  EXPECT_EQ(content(dir_ + "/public.key"), key.public_key + "\n");
  EXPECT_EQ(content(dir_ + "/secret.key"), key.secret_key + "\n");
  const std::string again = message([&] { make_key(dir_); });
  EXPECT_NE(again.find("is there already"), std::string::npos) << again;
  EXPECT_EQ(read_key(dir_).public_key, key.public_key);
  fs::remove(dir_ + "/public.key");
  EXPECT_NE(message([&] { make_key(dir_); }).find("is there already"), std::string::npos);
  EXPECT_EQ(content(dir_ + "/secret.key"), key.secret_key + "\n");
}

TEST_F(CurveKeys, WhereOthersMayWriteTheyAreNoKeys) {
  make_key(dir_);
  struct stat folder {};
  ASSERT_EQ(::stat(dir_.c_str(), &folder), 0);
  EXPECT_EQ(folder.st_mode & 0777, 0700u);
  const std::string list = written(content(dir_ + "/public.key"));
  for (const std::string& place : {dir_, dir_ + "/public.key", list}) {
    ASSERT_EQ(::stat(place.c_str(), &folder), 0);
    for (const unsigned mode : {0002u, 0020u}) {
      ::chmod(place.c_str(), (folder.st_mode & 0777) | mode);
      const std::string said = message([&] { place == list ? (void)read_authorized(list) : (void)read_key(dir_); });
      EXPECT_TRUE(said.starts_with(place + ": others may write there")) << said;
    }
    ::chmod(place.c_str(), folder.st_mode & 0777);
  }
  ::chmod(list.c_str(), 0666);
  EXPECT_NE(message([&] { read_public_key(list, "--server-key"); }).find("others may write"), std::string::npos);
  ::chmod(list.c_str(), 0644);
  EXPECT_EQ(read_authorized(list).size(), 1u);
  EXPECT_EQ(read_public_key(list, "--server-key"), read_key(dir_).public_key);
  ::chmod(dir_.c_str(), 0777);
  EXPECT_NE(message([&] { make_key(dir_); }).find("others may write"), std::string::npos);
  ::chmod(dir_.c_str(), 0700);
}

TEST_F(CurveKeys, WrongOnesAreSaid) {
  EXPECT_NE(message([&] { read_key(dir_); }).find("make a key with: kilotouch key new"), std::string::npos);
  make_key(dir_);
  ::chmod((dir_ + "/secret.key").c_str(), 0640);
  EXPECT_NE(message([&] { read_key(dir_); }).find("others may read"), std::string::npos);
  ::chmod((dir_ + "/secret.key").c_str(), 0600);
  std::ofstream(dir_ + "/public.key") << new_curve_key().public_key;
  EXPECT_NE(message([&] { read_key(dir_); }).find("not a pair"), std::string::npos);
  std::ofstream(dir_ + "/public.key") << "short";
  EXPECT_NE(message([&] { read_key(dir_); }).find("public.key: no key"), std::string::npos);
}

TEST_F(CurveKeys, FortyCharactersOfZ85) {
  EXPECT_TRUE(is_curve_key("rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7"));  // zmq_curve(7)'s example
  EXPECT_FALSE(is_curve_key("rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf"));
  EXPECT_FALSE(is_curve_key("rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7a"));
  EXPECT_FALSE(is_curve_key("rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]y\"7"));
  EXPECT_FALSE(is_curve_key(""));
}

TEST_F(CurveKeys, OfTheServerAsTextOrFile) {
  const std::string key = new_curve_key().public_key;
  EXPECT_EQ(read_public_key(key, "--server-key"), key);
  EXPECT_EQ(read_public_key(written(key + "\n"), "--server-key"), key);
  EXPECT_NE(message([&] { read_public_key("nothing", "--server-key"); }).find("--server-key: nothing is neither"),
            std::string::npos);
  EXPECT_NE(message([&] { read_public_key(written("some text"), "--server-key"); }).find("no key"), std::string::npos);
}

TEST_F(CurveKeys, ListOfThoseWhoMayConnect) {
  const std::string a = new_curve_key().public_key, b = new_curve_key().public_key;
  const std::string text = "# the lab\n\n  " + a + "  the bench\r\n#" + a + "\n" + b;
  EXPECT_EQ(read_authorized(written(text)), (std::vector<std::string>{a, b}));
  EXPECT_TRUE(read_authorized(written("# nobody\n")).empty());
  EXPECT_NE(message([&] { read_authorized(written(a + "\nwrong\n")); }).find("list:2: no key"), std::string::npos);
  EXPECT_NE(message([&] { read_authorized(dir_ + "/none"); }).find("cannot be read"), std::string::npos);
}

}  // namespace
}  // namespace kt
