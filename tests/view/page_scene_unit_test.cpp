// What a page may make of a scene: attacks by every key that names a file, a library, an address or a device.
#include "view/page_scene.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

class PageScene : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "kt_page_XXXXXX").string();
    top_ = fs::canonical(mkdtemp(name.data()));
    folder_ = top_ / "scenes";
    fs::create_directories(folder_ / "sub");
    fs::create_directories(folder_ / ".ssh");
    for (const char* file : {"scenes/a.off", "scenes/sub/b.off", "scenes/way.csv", "scenes/.ssh/key.off", "secret.off",
                             "secret.csv", "scenes/notes"})
      std::ofstream(top_ / file) << "secret-word";
    fs::create_symlink(top_ / "secret.off", folder_ / "link.off");
    fs::create_symlink(top_, folder_ / "up");
    scene_.object.mesh = (top_ / "secret.off").string();  // as its writer has named it: stays
  }
  void TearDown() override { fs::remove_all(top_); }

  Scene with(const std::vector<std::string>& settings) const { return page_scene(scene_, settings, folder_.string()); }
  std::string refusal(const std::string& setting) const {
    return message([&] { with({setting}); });
  }

  fs::path top_, folder_;
  Scene scene_;
};

TEST_F(PageScene, WordsOfAFileStayHere) {
  Scene scene = scene_;
  scene.object.mesh = "/a/body.off";
  scene.tool.path.recording = "/a/notes.txt";
  const auto told = [&](const std::string& error, const std::string& own = "") {
    return without_words_of_files(error, scene, own);
  };
  for (const std::string error :
       {"/a/notes.txt:12: no column is named t among \"secret\"", "x: /a/notes.txt:12: \"secret\""}) {
    EXPECT_EQ(told(error).find("secret"), std::string::npos);
    EXPECT_NE(told(error).find("/a/notes.txt:12: is no recording that can be read"), std::string::npos) << told(error);
  }
  EXPECT_EQ(told("/a/body.off:3: \"secret\"").find("secret"), std::string::npos);
  EXPECT_NE(told("/a/body.off:3: \"its own\"", "/a/").find("its own"), std::string::npos);  // the page has sent it
  EXPECT_EQ(told("/a/body.off: the surface is open in 3 places"), "/a/body.off: the surface is open in 3 places");
}

TEST_F(PageScene, ChangesWhatNamesNothing) {
  const Scene out = with({"contact.mu=0.2", "tool.radius=0.006"});
  EXPECT_EQ(out.contact.mu_static, 0.2);
  EXPECT_EQ(out.object.mesh, scene_.object.mesh);
}

TEST_F(PageScene, NamesFilesOfTheScenesFolder) {
  EXPECT_EQ(with({"object.mesh=a.off"}).object.mesh, (folder_ / "a.off").string());
  EXPECT_EQ(with({"object.mesh=sub/b.off"}).object.mesh, (folder_ / "sub/b.off").string());
  EXPECT_EQ(with({"object.mesh=" + (folder_ / "a.off").string()}).object.mesh, (folder_ / "a.off").string());
  EXPECT_EQ(*with({"tool.path.recording=way.csv"}).tool.path.recording, (folder_ / "way.csv").string());
  EXPECT_EQ(with({R"(second_tool={"shape":"mesh","mesh":"sub/../a.off"})"}).second_tool->mesh,
            (folder_ / "a.off").string());
}

TEST_F(PageScene, NamesNoOtherFileByAnyKey) {
  const std::vector<std::string> meshes = {"/etc/passwd", "../secret.off",      "sub/../../secret.off",
                                           "link.off",    "up/secret.off",      ".ssh/key.off",
                                           "notes",       "/proc/self/environ", ".",
                                           "/dev/stdin",  "../nothing.off",     (top_ / "secret.off").string() + "x"};
  for (const std::string& file : meshes)
    for (const std::string& setting :
         {"object.mesh=" + file, R"(tool={"shape":"mesh","mesh":")" + file + "\"}",
          R"(second_tool={"shape":"mesh","mesh":")" + file + "\"}", "tool.path.recording=" + file,
          R"(second_tool={"path":{"recording":")" + file + "\"}}"}) {
      const std::string said = refusal(setting);
      EXPECT_NE(said.find("in the scene's folder"), std::string::npos) << setting << ": " << said;
      EXPECT_EQ(said.find("secret-word"), std::string::npos);
    }
}

// Whether a file is there is not told either.
TEST_F(PageScene, TellsNotWhatIsThere) {
  const auto without_name = [](std::string said, const std::string& name) {
    return said.replace(said.find(name), name.size(), "X");
  };
  EXPECT_EQ(without_name(refusal("object.mesh=../secret.off"), "../secret.off"),
            without_name(refusal("object.mesh=../nothing.off"), "../nothing.off"));
}

TEST_F(PageScene, LeavesDevicesAlone) {
  const std::vector<std::string> settings = {
      R"(tool.path.device={"name":"openhaptics"})", "tool.path.device.name=haply", "tool.path.device.library=/tmp/e.so",
      R"(tool.path={"device":{"name":"haply","address":"ws://evil.example:1"}})",
      R"(second_tool={"path":{"device":{"name":"forcedimension","library":"/tmp/e.so"}}})"};
  for (const std::string& setting : settings) EXPECT_NE(refusal(setting), "no InputError") << setting;
  Scene held = scene_;
  held.tool.path = {.press_drag = {}, .waypoints = {}, .recording = {}, .hand = {}, .device = DeviceSettings{}};
  held.tool.path.device->name = "forcedimension";
  held.tool.path.device->library = "/opt/libdhd.so";
  held.tool.path.device->max_force = 2.5;
  const auto changed = [&](const std::string& setting) { return page_scene(held, {setting}, folder_.string()); };
  EXPECT_EQ(*changed("contact.mu=0.2").tool.path.device, *held.tool.path.device);
  for (const char* setting :
       {"tool.path.device.max_force=40", "tool.path.device.max_slew=100000", "tool.path.device.library=/tmp/e.so",
        "tool.path.device.address=ws://evil.example:1", "tool.path.device.name=haply", "tool.path.device.deadman=none",
        "tool.path.device.id=2"}) {
    if (std::string(setting).ends_with("deadman=none")) held.tool.path.device->deadman = "1";
    EXPECT_NE(message([&] { changed(setting); }).find("is set up on its own computer"), std::string::npos) << setting;
  }
  EXPECT_TRUE(changed("tool.path.press_drag.depth=0.001").tool.path.press_drag);  // put aside: allowed
}

TEST(PageTexts, LeaveTemporaryFoldersOut) {
  const std::string own = (fs::temp_directory_path() / "kilotouch-").string();
  EXPECT_EQ(without_temporary_folders(own + "aB3xyZ/liver.off: line 3"), "liver.off: line 3");
  EXPECT_EQ(without_temporary_folders("in " + own + "aB3xyZ/kilotouch-Q12345/x.off, " + own + "aB3xyZ/y.off"),
            "in x.off, y.off");
  for (const std::string& kept :
       {std::string("plain"), own, own + "short/x", fs::temp_directory_path().string() + "/x.off"})
    EXPECT_EQ(without_temporary_folders(kept), kept);
}

TEST(PageTexts, NamesOfDroppedFilesHaveNoFolder) {
  EXPECT_EQ(dropped_name("liver.off"), "liver.off");
  EXPECT_EQ(dropped_name("../../etc/liver.off"), "liver.off");
  EXPECT_EQ(dropped_name("C:\\organs\\liver.off"), "liver.off");
  EXPECT_EQ(dropped_name("..off"), "dropped.off");
  EXPECT_EQ(dropped_name("a\nb.off"), "dropped.off");
  EXPECT_EQ(dropped_name(std::string(300, 'a') + ".off"), "dropped.off");
}

}  // namespace
}  // namespace kt
