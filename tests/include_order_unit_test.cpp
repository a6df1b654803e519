// The dependency order of docs/architecture.md, and third-party headers where they belong, over every #include.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

namespace kt {
namespace {

namespace fs = std::filesystem;

/// Folders with code; `examples` is a project of its own.
const std::vector<std::string> kFolders{"core",    "collision", "self_contact", "models", "io",    "haptics", "api",
                                        "network", "view",      "apps",         "lab",    "bench", "tests"};
const std::vector<std::string> kBottom{"core"}, kMiddle{"core", "collision", "models", "io"};

/// The rooms of a folder from the ground up, siblings on one line: a file includes from its own room and from lines
/// below.
const std::map<std::string, std::vector<std::vector<std::string>>> kRooms{
    {"core", {{"base"}, {"linear"}, {"body"}, {"global", "local"}, {"contact_surface", "fine"}}},
    {"collision", {{"shape"}, {"broad", "impact"}, {"held"}}},
    {"io", {{"files"}, {"mesh", "scene"}, {"surface"}, {"solid"}}},
    {"haptics",
     {{"options", "contact", "device", "link"},
      {"safety", "machine", "tick"},
      {"cost", "touched"},
      {"refresh", "driver"},
      {"guard", "body"},
      {"halves"},
      {"remote", "watch"},
      {"touch"},
      {"setup"},
      {"cells"},
      {"predict"},
      {"session"},
      {"findings"}}},
    {"lab", {{"methods", "study"}, {"advise", "chart", "check", "stability"}, {"commands"}, {""}}},
    {"network", {{"channel"}, {"control", "message"}, {""}}}};

bool is_in(const std::string& file, const std::string& folder) { return file.rfind(folder + "/", 0) == 0; }

bool is_in_any(const std::string& file, const std::vector<std::string>& folders) {
  return std::any_of(folders.begin(), folders.end(), [&](const std::string& f) { return is_in(file, f); });
}

/// "core/local/reducers/wall.cpp" -> "core", "local"
std::pair<std::string, std::string> room_of(const std::string& file) {
  const std::size_t folder = file.find('/'), room = file.find('/', folder + 1);
  return {file.substr(0, folder), room == std::string::npos ? "" : file.substr(folder + 1, room - folder - 1)};
}

/// The line of a room in kRooms; -1: there is no such room.
int floor_of(const std::string& folder, const std::string& room) {
  const auto& floors = kRooms.at(folder);
  for (std::size_t i = 0; i < floors.size(); ++i)
    if (std::ranges::find(floors[i], room) != floors[i].end()) return static_cast<int>(i);
  return -1;
}

/// For files of one folder that has rooms.
bool goes_down(const std::string& from, const std::string& to) {
  const auto [folder, room] = room_of(from);
  const std::string other = room_of(to).second;
  return room == other || floor_of(folder, other) < floor_of(folder, room);
}

/// May `from` include `to`? Paths from the root of the repository. A folder includes itself and what is below it;
/// siblings never include each other. models/*.hpp is the face of all models, and what carries a surface in the cells
/// of any: models/msd includes them too.
bool may_include(const std::string& from, const std::string& to) {
  const std::string own = room_of(from).first;
  if (kRooms.count(own) && is_in(to, own)) return goes_down(from, to);
  for (const char* leaf : {"haptics/options", "haptics/contact", "haptics/device", "haptics/link"})
    if (is_in(from, leaf)) return is_in_any(to, kMiddle);
  for (const char* leaf : {"models/msd", "models/fem"})
    if (is_in(from, leaf))
      return is_in(to, leaf) || is_in(to, "core") || to == "models/model.hpp" || to == "models/embedded_model.hpp";
  if (is_in(from, "self_contact")) return is_in_any(to, {"self_contact", "collision", "core"});
  for (const char* folder : {"core", "collision", "models", "io"})
    if (is_in(from, folder)) return is_in(to, folder) || is_in(to, "core");
  if (is_in(from, "haptics")) return is_in(to, "self_contact") || is_in_any(to, kMiddle);
  if (is_in(from, "api")) return is_in_any(to, {"api", "haptics"}) || is_in_any(to, kMiddle);
  if (is_in(from, "network")) return is_in_any(to, {"network", "haptics", "self_contact"}) || is_in_any(to, kMiddle);
  if (is_in(from, "view")) return is_in_any(to, {"view", "haptics", "self_contact"}) || is_in_any(to, kMiddle);
  if (is_in(from, "tests")) return true;
  if (is_in_any(from, {"bench", "lab/check"}) && is_in_any(to, {"tests/support", "tests/fakes"}))
    return true;  // the same truths
  if (is_in(to, "lab")) return is_in(from, "bench");
  if (is_in(from, "lab/commands") && is_in(to, "apps")) return true;
  if (is_in(from, "apps") && is_in_any(to, {"view", "network"})) return true;
  if (is_in(from, "bench") && is_in(to, "network")) return true;
  for (const char* leaf : {"apps", "lab", "bench"})
    if (is_in(from, leaf))
      return is_in(to, leaf) || is_in_any(to, {"haptics", "self_contact"}) || is_in_any(to, kMiddle);
  return false;
}

struct Home {
  std::string header;  ///< how the included path begins
  std::string files;   ///< who may include it (regular expression)
};

/// Besides these only the standard library, POSIX and Eigen.
const std::vector<Home> kHomes{
    {"cholmod", "core/linear/cholmod\\.cpp"},
    {"embree", "collision/broad/embree\\.cpp|bench/broad_phase_bench\\.cpp"},
    {"OpenMesh/", "io/surface/[a-z_]*openmesh\\.cpp"},
    {"CGAL/", "io/[a-z]+/[a-z_]*cgal\\.cpp"},
    {"nglib", "io/solid/tetrahedralize_netgen\\.cpp"},
    {"nlohmann/",
     "io/(files|scene)/(json|scene)[a-z_]*\\.[ch]pp|apps/.*|view/(server/)?page_[a-z]+\\.cpp|lab/.*|"
     "haptics/driver/haply/haply_messages\\.cpp|tests/(fakes|haptics)/haply_[a-z_]*\\.cpp"},
    {"valijson/", "io/scene/json_schema\\.cpp"},
    {"zlib.h", "io/mesh/format/inflate_zlib\\.cpp"},
    {"CLI/", "(apps|lab/commands|bench)/.*"},
    {"benchmark/", "bench/.*"},
    {"gtest/", "tests/.*"},
    {"gmock/", "tests/.*"},
    {"boost/", "view/server/server\\.cpp|haptics/driver/haply/haply[a-z_]*\\.cpp|tests/fakes/haply_service\\.cpp"},
    {"zmq", "network/control/[a-z_]+\\.[ch]pp|bench/channel_tcp_table\\.cpp"},
    {"sodium", "network/(channel|control)/[a-z_]+\\.cpp"},
    {"isa-l", "network/channel/[a-z_]+\\.cpp"},
    {"flatbuffers", "network/message/[a-z_]+\\.[ch]pp"},
    {"wire_generated", "network/message/[a-z_]+\\.[ch]pp"},
    {"tbb/", "core/base/parallel\\.cpp"},
};

struct Include {
  std::string from, to;
  bool quoted = false;
};

std::vector<Include> all_includes() {
  const std::regex line("\\s*#\\s*include\\s*([\"<])([^\">]+)[\">].*");
  std::vector<Include> out;
  for (const std::string& folder : kFolders) {
    const fs::path root = KT_SOURCE_DIR;
    if (!fs::is_directory(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string file = fs::relative(entry.path(), root).generic_string();
      if (!std::regex_match(file, std::regex(".*\\.([ch]pp|def|cpp\\.in)"))) continue;
      std::ifstream in(entry.path());
      std::smatch found;
      for (std::string text; std::getline(in, text);)
        if (std::regex_match(text, found, line)) out.push_back({file, found[2], found[1] == "\""});
    }
  }
  return out;
}

TEST(IncludeOrder, TheRuleAllowsDownAndForbidsUpAndSideways) {
  EXPECT_TRUE(may_include("core/local/reducers/wall.cpp", "core/local/reducer.hpp"));
  EXPECT_TRUE(may_include("models/msd/msd_model.cpp", "models/model.hpp"));
  EXPECT_TRUE(may_include("haptics/device/press_drag.hpp", "collision/shape/contact.hpp"));
  EXPECT_TRUE(may_include("haptics/session/session.cpp", "haptics/link/mailbox.hpp"));
  EXPECT_TRUE(may_include("haptics/refresh/refresher.hpp", "self_contact/touching_euler.hpp"));
  EXPECT_FALSE(may_include("self_contact/touching_euler.hpp", "haptics/refresh/refresher.hpp"));
  EXPECT_FALSE(may_include("haptics/contact/coulomb.cpp", "self_contact/barrier.hpp"));
  EXPECT_TRUE(may_include("tests/support/allocations.hpp", "apps/console/allocation_counter.hpp"));
  for (const char* above :
       {"collision/impact/tool_impact.hpp", "models/model.hpp", "io/scene/scene.hpp", "haptics/session/session.hpp"})
    EXPECT_FALSE(may_include("core/body/mesh.cpp", above)) << above;
  EXPECT_FALSE(may_include("collision/impact/tool_impact.cpp", "io/mesh/mesh_io.hpp"));
  EXPECT_FALSE(may_include("models/fem/fem_model.cpp", "models/msd/springs.hpp"));
  EXPECT_FALSE(may_include("haptics/contact/coulomb.cpp", "haptics/device/haptic_device.hpp"));
  EXPECT_FALSE(may_include("haptics/link/ring.hpp", "haptics/session/session.hpp"));
  EXPECT_FALSE(may_include("io/scene/scene.cpp", "haptics/session/session.hpp"));
  EXPECT_TRUE(may_include("view/live_run.cpp", "haptics/session/session.hpp"));
  EXPECT_FALSE(may_include("haptics/session/session.cpp", "view/live_run.hpp"));
  EXPECT_TRUE(may_include("lab/check/stages/shots.cpp", "tests/support/shooting.hpp"));
  EXPECT_FALSE(may_include("apps/main.cpp", "tests/support/shooting.hpp"));
  EXPECT_FALSE(may_include("apps/main.cpp", "bench/table.hpp"));
  EXPECT_FALSE(may_include("haptics/session/session.cpp", "tests/support/meshes.hpp"));
}

TEST(IncludeOrder, RoomsOfAFolderIncludeWhatIsBelowThem) {
  EXPECT_TRUE(may_include("core/body/check_model.cpp", "core/linear/sparse_solver.hpp"));
  EXPECT_FALSE(may_include("core/linear/sparse_solver.hpp", "core/body/mesh.hpp"));
  EXPECT_FALSE(may_include("core/global/newton.hpp", "core/local/reducer.hpp"));  // siblings
  EXPECT_FALSE(may_include("core/local/reducer.hpp", "core/global/newton.hpp"));
  EXPECT_FALSE(may_include("collision/impact/hull_impact.cpp", "collision/held/pair_distance.hpp"));
  EXPECT_TRUE(may_include("io/solid/tetrahedralize.cpp", "io/files/child_process.hpp"));
  EXPECT_FALSE(may_include("io/scene/scene.cpp", "io/mesh/mesh_io.hpp"));
  EXPECT_FALSE(may_include("haptics/predict/predict.hpp", "haptics/session/session.hpp"));
  for (const char* engine : {"haptics/tick/haptic_method.cpp", "haptics/session/session.cpp", "api/c_api.cpp",
                             "view/live_run.cpp", "network/hand_link.cpp", "apps/outputs/run_summary.cpp"})
    EXPECT_FALSE(may_include(engine, "lab/study/reference.hpp")) << engine;
  EXPECT_FALSE(may_include("apps/main.cpp", "lab/commands/laboratory.hpp"));
  EXPECT_TRUE(may_include("lab/advise/advise.cpp", "lab/study/reference.hpp"));
  EXPECT_FALSE(may_include("lab/study/reference.cpp", "lab/advise/advise.hpp"));
  EXPECT_FALSE(may_include("lab/study/reference.cpp", "apps/run/run_session.hpp"));
}

TEST(IncludeOrder, EveryFileLiesInARoomOfTheList) {
  for (const auto& [folder, floors] : kRooms)
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(KT_SOURCE_DIR) / folder)) {
      if (!entry.is_regular_file()) continue;
      const std::string file = fs::relative(entry.path(), KT_SOURCE_DIR).generic_string();
      EXPECT_GE(floor_of(folder, room_of(file).second), 0) << file;
    }
}

TEST(IncludeOrder, AFolderHasAtMostTwentyFiles) {
  // Those that have more; they may shrink.
  const std::map<std::string, int> larger{{"haptics/tick", 43}, {"core/local", 30}, {"haptics/refresh", 34},
                                          {"core/base", 26},    {"core/fine", 26},  {"core/body", 23}};
  std::map<std::string, int> count;
  for (const std::string& folder : kFolders)
    if (folder != "tests" && folder != "bench")
      for (const auto& entry : fs::recursive_directory_iterator(fs::path(KT_SOURCE_DIR) / folder))
        if (entry.is_regular_file()) ++count[fs::relative(entry.path().parent_path(), KT_SOURCE_DIR).generic_string()];
  for (const auto& [folder, files] : count)
    EXPECT_LE(files, larger.contains(folder) ? larger.at(folder) : 20) << folder << ": make rooms of it";
}

TEST(IncludeOrder, EveryFileIncludesOnlyItsOwnFolderAndWhatIsBelow) {
  const std::vector<Include> includes = all_includes();
  EXPECT_GE(includes.size(), 300u);  // the files were found
  for (const Include& i : includes)
    if (i.quoted) {
      EXPECT_TRUE(may_include(i.from, i.to)) << i.from << " includes " << i.to;
      EXPECT_TRUE(fs::exists(fs::path(KT_SOURCE_DIR) / i.to)) << i.from << ": paths start at the root: " << i.to;
    }
}

std::string folder_of(const std::string& file) { return file.substr(0, file.rfind('/')); }

/// Every folder that includes, by way of others, from itself.
std::set<std::string> folders_in_circles(const std::vector<Include>& includes) {
  std::map<std::string, std::set<std::string>> reached;
  for (const Include& i : includes)
    if (i.quoted && folder_of(i.from) != folder_of(i.to)) reached[folder_of(i.from)].insert(folder_of(i.to));
  for (bool grows = true; grows;) {
    grows = false;
    for (auto& [from, all] : reached)
      for (const std::string& via : std::set<std::string>(all))
        if (reached.contains(via))
          for (const std::string& to : reached.at(via)) grows |= all.insert(to).second;
  }
  std::set<std::string> out;
  for (const auto& [from, all] : reached)
    if (all.contains(from)) out.insert(from);
  return out;
}

TEST(IncludeOrder, NoFolderIncludesFromItselfByWayOfOthers) {
  EXPECT_EQ(folders_in_circles({{"a/x.cpp", "b/y.hpp", true},
                                {"b/y.hpp", "c/z.hpp", true},
                                {"c/z.hpp", "a/x.hpp", true},
                                {"d/w.cpp", "a/x.hpp", true}}),
            (std::set<std::string>{"a", "b", "c"}));
  std::vector<Include> includes = all_includes();
  std::erase_if(includes, [](const Include& i) { return is_in(i.from, "tests"); });
  EXPECT_EQ(folders_in_circles(includes), std::set<std::string>{});
}

TEST(IncludeOrder, ThirdPartyHeadersStayInTheirFiles) {
  for (const Include& i : all_includes()) {
    if (i.quoted) continue;
    for (const Home& home : kHomes) {
      if (i.to.rfind(home.header, 0) != 0 || is_in(i.from, "tests")) continue;  // a test may ask the library itself
      EXPECT_TRUE(std::regex_match(i.from, std::regex(home.files))) << i.from << " includes <" << i.to << ">";
    }
  }
}

TEST(IncludeOrder, OurHeadersShowOnlyEigenAndTheStandardLibrary) {
  for (const Include& i : all_includes()) {
    if (i.quoted || !std::regex_match(i.from, std::regex("(core|collision|models|io|haptics)/.*\\.hpp"))) continue;
    const bool json =
        std::regex_match(i.from, std::regex("io/(files|scene)/(json|scene)_[a-z_]*\\.hpp"));  // inside io only
    EXPECT_TRUE(i.to.rfind("Eigen/", 0) == 0 || i.to.find_first_of("./") == std::string::npos ||
                (json && i.to.rfind("nlohmann/", 0) == 0))
        << i.from << " includes <" << i.to << ">";
  }
}

}  // namespace
}  // namespace kt
