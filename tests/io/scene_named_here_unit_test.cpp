// Who may name a library or an address: one rule, door by door.
#include "io/scene/named_here.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

class NamedHere : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "kt_named_XXXXXX").string();
    folder_ = mkdtemp(name.data());
    std::ofstream(folder_ / "x.so") << "no library";
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string scene_file(const std::string& device, const std::string& tool = "tool") const {
    const std::string first = tool == "tool" ? "" : R"("tool": {}, )";
    std::ofstream(folder_ / "a.json") << R"({"object": {"mesh": "a.off"}, )" << first << '"' << tool
                                      << R"(": {"path": {"device": )" << device << "}}}";
    return (folder_ / "a.json").string();
  }
  std::string refusal(const std::string& device, SceneDoor door = SceneDoor::file,
                      const std::vector<std::string>& typed = {}, const std::string& tool = "tool") const {
    const std::string file = scene_file(device, tool);
    return message([&] { load_scene(file, typed, door); });
  }
  static std::string library(const std::string& file) {
    return R"({"name": "openhaptics", "library": ")" + file + "\"}";
  }
  static std::string address(const std::string& where) { return R"({"name": "haply", "address": ")" + where + "\"}"; }

  fs::path folder_;
};

constexpr const char* kAccepted = "no InputError";

TEST_F(NamedHere, ASceneFileNamesNoLibraryByARelativePath) {
  for (const char* file : {"../x.so", "./x.so", "sub/x.so", "x/../x.so", "/proc/self/cwd/x.so", "/dev/fd/3",
                           "/usr/../proc/self/cwd/x.so", "//proc/self/cwd/x.so"})
    for (const char* tool : {"tool", "second_tool"}) {
      const std::string said = refusal(library(file), SceneDoor::file, {}, tool);
      EXPECT_NE(said.find(std::string(tool) + ".path.device.library is \""), std::string::npos) << file << ": " << said;
      EXPECT_NE(said.find("--set"), std::string::npos) << said;
    }
}

TEST_F(NamedHere, ASceneFileMayNameWhatIsInstalled) {
  EXPECT_EQ(refusal(library("libdhd.so.3")), kAccepted);
  EXPECT_EQ(refusal(library("/opt/nowhere/libdhd.so")), kAccepted);  // the driver tells that it is not there
  EXPECT_EQ(refusal(library((folder_ / "x.so").string())), kAccepted);
  ASSERT_EQ(chmod((folder_ / "x.so").c_str(), 0666), 0);
  EXPECT_NE(refusal(library((folder_ / "x.so").string())).find("cannot write"), std::string::npos);
  ASSERT_EQ(chmod((folder_ / "x.so").c_str(), 0644), 0);
  ASSERT_EQ(chmod(folder_.c_str(), 0777), 0);
  EXPECT_NE(refusal(library((folder_ / "x.so").string())).find("cannot write"), std::string::npos);
}

TEST_F(NamedHere, ASceneFileNamesAddressesOfThisComputer) {
  for (const char* where : {"ws://localhost:10001", "ws://127.0.0.1:1", "ws://[::1]:9", "/run/spnav.sock"})
    EXPECT_EQ(refusal(address(where)), kAccepted) << where;
  for (const char* where : {"ws://evil.example:1", "ws://127.0.0.1.evil.example:1", "ws://192.0.2.1:10001",
                            "ws://localhost@evil.example:1", "./spnav.sock", "spnav.sock"})
    EXPECT_NE(refusal(address(where)).find("address of this computer"), std::string::npos) << where;
}

TEST_F(NamedHere, TheCommandLineNamesAny) {
  const std::string named = (fs::current_path() / "y.so").string();
  const Scene scene = load_scene(scene_file(library("../x.so")), {"tool.path.device.library=./y.so"});
  EXPECT_EQ(scene.tool.path.device->library, named);  // the same file from any folder
  EXPECT_EQ(load_scene(scene_file("{\"name\": \"haply\"}"), {"tool.path.device.address=ws://192.0.2.1:1"})
                .tool.path.device->address,
            "ws://192.0.2.1:1");
  EXPECT_EQ(refusal(library("../x.so"), SceneDoor::file, {R"(tool.path.device={"name":"haply"})"}), kAccepted);
  EXPECT_NE(refusal(library("../x.so"), SceneDoor::file, {"tool.path.device.max_force=1"}), kAccepted);
}

TEST_F(NamedHere, OthersNameNeither) {
  for (const char* file : {"../x.so", "libdhd.so.3", "/usr/lib/libdhd.so"})
    EXPECT_NE(refusal(library(file), SceneDoor::others).find("is code"), std::string::npos) << file;
  for (const char* where : {"ws://localhost:10001", "/run/spnav.sock"})
    EXPECT_NE(refusal(address(where), SceneDoor::others).find("this computer alone"), std::string::npos) << where;
  EXPECT_EQ(refusal(library("../x.so"), SceneDoor::others, {"tool.path.device.library=/a.so"}), kAccepted);
}

TEST_F(NamedHere, FilesOfOthersLieBesideTheirScene) {
  const auto said = [&](const std::string& keys) {
    std::ofstream(folder_ / "a.json") << "{" << keys << "}";
    return message([&] { load_scene((folder_ / "a.json").string(), {}, SceneDoor::others); });
  };
  EXPECT_EQ(said(R"("object": {"mesh": "a.off"})"), kAccepted);
  for (const char* file : {"/etc/passwd", "../a.off", "sub/a.off", ".."}) {
    EXPECT_NE(said(text(R"("object": {"mesh": ")", file, "\"}")).find("object.mesh is \""), std::string::npos) << file;
    EXPECT_NE(said(text(R"("object": {"mesh": "a.off"}, "tool": {"path": {"recording": ")", file, "\"}}"))
                  .find("tool.path.recording"),
              std::string::npos);
    EXPECT_NE(said(text(R"("object": {"mesh": "a.off"}, "second_tool": {"shape": "mesh", "mesh": ")", file, "\"}"))
                  .find("second_tool.mesh"),
              std::string::npos);
  }
}

// A page: what the scene's writer has named stays, all else is refused.
TEST_F(NamedHere, APageKeepsWhatIsNamedAlready) {
  Scene own = load_scene(scene_file(library("/opt/a.so")));
  Scene other = own;
  EXPECT_EQ(message([&] { require_named_here(other, own, SceneDoor::others, "page"); }), kAccepted);
  other.second_tool = other.tool;
  EXPECT_EQ(message([&] { require_named_here(other, own, SceneDoor::others, "page"); }), kAccepted);
  other.second_tool->path.device->library = "/opt/b.so";
  EXPECT_NE(message([&] { require_named_here(other, own, SceneDoor::others, "page"); }).find("second_tool"),
            std::string::npos);
  other.second_tool->path.device->library.clear();
  other.second_tool->path.device->address = "/opt/a.so";  // a library's name is no address's
  EXPECT_NE(message([&] { require_named_here(other, own, SceneDoor::others, "page"); }), kAccepted);
}

}  // namespace
}  // namespace kt
