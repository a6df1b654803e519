// Every backend of tetrahedralizer.def over the project's meshes, and what is said about surfaces that cannot be
// filled.
#include "io/solid/tetrahedralize.hpp"

#include "io/solid/tetrahedra_quality.hpp"
#include "io/surface/mesh_doctor.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

std::vector<std::string> available() {
  std::vector<std::string> out;
  for (const BackendInfo& b : tetrahedralizers())
    if (b.available) out.push_back(b.name);
  return out;
}

TEST(Tetrahedralize, FillsEveryOwnMeshAndKeepsItsSurface) {
  constexpr double kRoundoff = 1e-9;  // relative, sums of 1e4 volumes
  for (const std::string& backend : available())
    for (const std::string& f : own_meshes()) {
      if (file_name(f) == "slab_fine.off" && backend != "tetgen") continue;  // seconds, and nothing new
      const Mesh surface = load_mesh(f);
      const Mesh solid = tetrahedralize(surface, {.backend = backend});
      const std::string what = backend + " " + file_name(f);
      ASSERT_FALSE(solid.tetrahedra.empty()) << what;
      const TetrahedraQuality q = tetrahedra_quality(solid);
      EXPECT_GT(q.volume_min, 0) << what;
      EXPECT_EQ(sorted_triangles(boundary_triangles(solid.tetrahedra)), sorted_triangles(solid.triangles)) << what;
      EXPECT_NEAR(enclosed_volume(solid), q.volume, kRoundoff * q.volume) << what;
      if (backend == "cgal") {
        EXPECT_NEAR(q.volume, enclosed_volume(surface), 0.05 * q.volume) << what;
        continue;
      }
      EXPECT_NEAR(q.volume, enclosed_volume(surface), kRoundoff * q.volume) << what;
      EXPECT_EQ(solid.triangles, surface.triangles) << what;
      EXPECT_TRUE(solid.x.head(surface.x.size()) == surface.x) << what;
    }
}

TEST(Tetrahedralize, KeepsTheSurfaceOfRealMeshes) {
  if (!KT_WITH_CGAL) GTEST_SKIP() << "nothing here tells which of the meshes intersect themselves";
  if (real_meshes().empty()) GTEST_SKIP() << kNoMeshes;
  for (const std::string& f : real_meshes()) {
    const std::string name = file_name(f);
    if (!(name.starts_with("clean") || name.starts_with("organ") || name.starts_with("thin"))) continue;
    const Mesh surface = load_mesh(f);
    if (surface.num_nodes() > 6000 || !examine(surface).self_intersections.empty() || available().empty()) continue;
    if (!examine(surface, {.self_intersections = false}).closed()) continue;
    const Mesh solid = tetrahedralize(surface);
    const double volume = enclosed_volume(surface);
    EXPECT_NEAR(tetrahedra_quality(solid).volume, volume, 1e-9 * volume) << f;
    EXPECT_EQ(solid.triangles.size(), surface.triangles.size()) << f;
  }
}

TEST(Tetrahedralize, MaxVolumeHoldsAwayFromTheSurfaceButForAFew) {
  const Mesh sphere = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  constexpr double kMax = 2e-9;  // m^3, half of what the surface's edges suggest
  for (const std::string& backend : available()) {
    if (backend != "tetgen") continue;  // for the others it is a target
    const Mesh solid = tetrahedralize(sphere, {.backend = backend, .max_volume = kMax});
    int inner = 0, larger = 0;
    for (const Tetrahedron& t : solid.tetrahedra)
      if (*std::min_element(t.begin(), t.end()) >= sphere.num_nodes()) {  // the surface may not be split
        larger += tetrahedron_volume(solid.x, t) > kMax * (1 + 1e-9);
        ++inner;
      }
    EXPECT_GT(inner, 1000);
    EXPECT_LT(larger, inner / 100);  // whose split point would fall too near the surface
  }
}

TEST(Tetrahedralize, SurfaceNodesAreKeptToTheLastBit) {
  Mesh surface = load_mesh(KT_SOURCE_DIR "/meshes/genus5.off");
  surface.x = surface.x.array() / 3 + 0.1;  // digits that TetGen's text files cut off
  for (const std::string& backend : available()) {
    if (backend == "cgal") continue;
    const Mesh solid = tetrahedralize(surface, {.backend = backend});
    EXPECT_TRUE(solid.x.head(surface.x.size()) == surface.x) << backend;
  }
}

TEST(Tetrahedralize, ScaleDoesNotMatter) {
  for (const std::string& backend : available()) {
    std::vector<std::size_t> counts;
    for (const double scale : {1.0, 1024.0, 1.0 / 1024}) {
      Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/genus5.off");
      mesh.x *= scale;
      const Mesh solid = tetrahedralize(mesh, {.backend = backend});
      EXPECT_NEAR(tetrahedra_quality(solid).volume, enclosed_volume(mesh), 0.05 * enclosed_volume(mesh))
          << backend << scale;
      counts.push_back(solid.tetrahedra.size());
    }
    if (backend != "cgal") {
      EXPECT_LT(std::abs(static_cast<double>(counts[0]) - static_cast<double>(counts[1])),
                0.2 * static_cast<double>(counts[0]));
    }
  }
}

TEST(Tetrahedralize, CavitiesStayEmpty) {
  Mesh hollow = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  const Mesh outer = hollow;
  const int n = outer.num_nodes();
  hollow.x.conservativeResize(6 * n);
  hollow.x.tail(3 * n) = 0.5 * outer.x;
  for (const Triangle& t : outer.triangles) hollow.triangles.push_back({t[0] + n, t[2] + n, t[1] + n});
  for (const std::string& backend : available()) {
    const Mesh solid = tetrahedralize(hollow, {.backend = backend});
    const double volume = enclosed_volume(outer) * (1 - 0.125);
    EXPECT_NEAR(tetrahedra_quality(solid).volume, volume, (backend == "cgal" ? 0.05 : 1e-9) * volume) << backend;
  }
}

TEST(Tetrahedralize, DropsNodesThatNothingUses) {
  Mesh mesh = tetrahedron_surface();
  mesh.x.conservativeResize(15);
  mesh.x.tail(3).setConstant(7);
  for (const std::string& backend : available()) {
    if (backend == "cgal") continue;
    const Mesh solid = tetrahedralize(mesh, {.backend = backend, .max_volume = 1});
    EXPECT_EQ(solid.x.head(12), mesh.x.head(12));
    EXPECT_LT(bounds(solid).max.maxCoeff(), 1);
  }
}

TEST(Tetrahedralize, ABadSurfaceIsRefusedWithThePlace) {
  if (available().empty()) GTEST_SKIP() << "no backend in this build";
  const PrivateFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"open.off", "tetrahedralize: the surface is open in 3 places: first at (0.02, 0.01, 0), nodes 0 1, triangle 0"},
      {"flipped_face.off",
       "has triangles turned the wrong way in 1 place: at (0, 0.0133333, 0.00666667), nodes 7 6 4, triangle 3"},
      {"inside_out.off", "is inside out in 1 place: at"},
      {"nonmanifold_vertex.off", "has nodes where several fans of triangles touch in 1 place: at (0.02, 0.02, 0.02)"},
      {"duplicate_degenerate.off", "has triangles without area in 2 places"},
      {"nan.off", "has NaN or infinite coordinates in 1 place"}};
  for (const auto& [file, expected] : cases) {
    const Mesh mesh = load_mesh(std::string(KT_SOURCE_DIR "/meshes/broken/") + file, {.lenient = true});
    const std::string what = input_error(folder, [&] { tetrahedralize(mesh); });
    EXPECT_NE(what.find(expected), std::string::npos) << "said: " << what;
  }
}

TEST(Tetrahedralize, ASelfIntersectingSurfaceNeverGivesAResult) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/broken/self_intersecting.off");
  for (const std::string& backend : available()) {
    try {
      tetrahedralize(mesh, {.backend = backend, .timeout = 20});
      ADD_FAILURE() << backend << " filled a self-intersecting surface";
    } catch (const InputError& e) {  // with CGAL, which finds the place
      EXPECT_NE(std::string(e.what()).find("crosses itself in 12 places: first at ("), std::string::npos) << e.what();
    } catch (const RunError&) {  // without: the backend's own failure, caught in its child
    }
  }
}

/// With its program away, TetGen fails as it does on a surface that it cannot fill.
TEST(Tetrahedralize, WhereOneFailsAnotherFillsThatKeepsTheSurface) {
  if (!KT_WITH_TETGEN) GTEST_SKIP() << "no TetGen in this build";
  const Mesh surface = load_mesh(KT_SOURCE_DIR "/meshes/sphere.off");
  const PrivateFolder empty;
  const std::string path = std::getenv("PATH") ? std::getenv("PATH") : "";
  setenv("PATH", empty.path().c_str(), 1);
  std::string named, unnamed;
  std::vector<std::string> notes;
  Mesh solid;
  try {
    tetrahedralize(surface, {.backend = "tetgen"});
  } catch (const RunError& e) {
    named = e.what();
  }
  try {
    solid = tetrahedralize(surface, {.notes = &notes});
  } catch (const RunError& e) {
    unnamed = e.what();
  }
  setenv("PATH", path.c_str(), 1);
  EXPECT_NE(named.find("the program is not installed"), std::string::npos) << named;
  const bool has_another = std::ranges::count(available(), std::string("netgen")) > 0;
  EXPECT_EQ(named.find("; another tetrahedralizer may fill it: netgen") != std::string::npos, has_another) << named;
  EXPECT_EQ(unnamed.empty(), has_another) << unnamed;
  if (has_another) {
    EXPECT_EQ(solid.triangles, surface.triangles);
    ASSERT_EQ(notes.size(), 1u) << "another filled it without a word";
    EXPECT_NE(notes[0].find("; filled by netgen"), std::string::npos) << notes[0];
  }
}

TEST(Tetrahedralize, TimeAndMemoryAreLimited) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/slab_fine.off");
  for (const std::string& backend : available())
    EXPECT_THROW(tetrahedralize(mesh, {.backend = backend, .max_volume = 1e-12, .timeout = 0.3, .memory_gb = 64}),
                 RunError)
        << backend;
}

/// Told at once, where a mesher would run for minutes until it has no memory.
TEST(Tetrahedralize, MoreThanMemoryHoldsIsRefused) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/slab_fine.off");
  const PrivateFolder folder;
  for (const double volume : {1e-12, 1e-18, 1e-300}) {
    const std::string said = input_error(folder, [&] { tetrahedralize(mesh, {.name = "slab", .max_volume = volume}); });
    for (const char* word : {"slab: max_volume is 1e-", "must be at least", "usual"})
      EXPECT_NE(said.find(word), std::string::npos) << said;
  }
}

TEST(Tetrahedralize, OneThatIsStoppedIsTriedByNoOther) {
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/slab_fine.off");
  const std::atomic<bool> stop{true};
  if (available().empty()) GTEST_SKIP() << "no backend in this build";
  EXPECT_THROW(tetrahedralize(mesh, {.stop = &stop}), ChildStopped);
  const StopsChildren stops(stop);
  EXPECT_THROW(tetrahedralize(mesh, {}), ChildStopped);
}

TEST(Tetrahedralize, OptionsOutOfRangeAreRefused) {
  const Mesh mesh = tetrahedron_surface();
  EXPECT_THROW(tetrahedralize(mesh, {.max_volume = -1}), InputError);
  EXPECT_THROW(tetrahedralize(mesh, {.max_volume = NAN}), InputError);
  EXPECT_THROW(tetrahedralize(mesh, {.quality = 0.5}), InputError);
  EXPECT_THROW(tetrahedralize(mesh, {.timeout = 0}), InputError);
  const PrivateFolder folder;
  EXPECT_NE(input_error(folder, [&] { tetrahedralize(mesh, {.backend = "tetgn"}); }).find("did you mean \"tetgen\""),
            std::string::npos);
}

}  // namespace
}  // namespace kt
