// The doctor against the manifest of the real meshes, which was made with other programs.
#include <map>
#include <sstream>

#include "io/surface/mesh_doctor.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

/// Column name -> value for every file.
std::map<std::string, std::map<std::string, std::string>> manifest() {
  std::map<std::string, std::map<std::string, std::string>> out;
  std::ifstream in(test_data() + "/meshes/manifest.csv");
  std::vector<std::string> names;
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string> cells(1);
    bool in_quotes = false;
    for (const char c : line) {
      if (c == '"')
        in_quotes = !in_quotes;
      else if (c == ',' && !in_quotes)
        cells.emplace_back();
      else if (c != '\r')
        cells.back() += c;
    }
    if (names.empty())
      names = cells;
    else
      for (std::size_t i = 0; i < std::min(names.size(), cells.size()); ++i) out[cells[0]][names[i]] = cells[i];
  }
  return out;
}

// Rows in which the manifest and the doctor mean different things, each for one reason.
const std::map<std::string, std::string> kOtherMeaning = {
    {"malformed_whitespace.off", "the manifest's reader got nothing out of a legal file"},
    {"malformed_polygonfaces.obj", "the manifest is empty: its reader failed"},
    {"degenerate_capsule.obj", "the manifest joined equal nodes before it looked"},
    {"nonmanifold_dragon.obj", "the manifest counts pieces after cutting non-manifold edges apart"},
    {"organ_skull_and_teeth_coarse.obj", "the same"}};

TEST(MeshDoctor, AgreesWithTheManifest) {
  if (real_meshes().empty()) GTEST_SKIP() << kNoMeshes;
  const auto rows = manifest();
  int compared = 0;
  for (const std::string& f : real_meshes()) {
    const auto found = rows.find(file_name(f));
    if (found == rows.end() || kOtherMeaning.count(file_name(f))) continue;
    const auto& row = found->second;
    const auto number = [&](const char* name) { return std::stoi(row.at(name)); };
    const Mesh mesh = load_mesh(f);
    const MeshReport r = examine(mesh);
    EXPECT_EQ(r.nodes, number("V")) << f;
    EXPECT_GE(r.triangles, number("F")) << f;  // more where there were polygons
    EXPECT_EQ(r.closed(), number("closed") == 1) << f;
    EXPECT_EQ(r.manifold(), row.at("manifold") == "True") << f;
    EXPECT_EQ(r.components, number("components")) << f;
    EXPECT_EQ(r.euler, number("chi")) << f;
    EXPECT_EQ(static_cast<int>(r.degenerate.size()), number("degenerate")) << f;
    EXPECT_EQ(static_cast<int>(r.duplicates.size()), number("duplicate")) << f;
    EXPECT_EQ(static_cast<int>(r.open_edges.size()), number("boundary_edges")) << f;
    // The manifest also counts degenerate triangles and, of equal nodes that are not joined, those that only touch.
    if (r.self_intersections_checked && r.coincident_nodes.empty()) {
      EXPECT_EQ(static_cast<int>(r.self_intersections.size() + r.degenerate.size()), number("self_intersecting_pairs"))
          << f;
    }
    ++compared;
  }
  EXPECT_GE(compared, 28);
}

TEST(MeshDoctor, EveryRealMeshCanBeExamined) {
  if (real_meshes().empty()) GTEST_SKIP() << kNoMeshes;
  for (const std::string& f : real_meshes()) {
    const MeshReport r = examine(load_mesh(f, {.lenient = true}), {.self_intersections = false});
    EXPECT_GT(r.triangles, 0) << f;
    if (r.closed() && r.manifold() && r.one_sided.empty()) {
      EXPECT_EQ(2 * r.components - 2 * r.genus.value(), r.euler) << f;
    }
  }
}

}  // namespace
}  // namespace kt
