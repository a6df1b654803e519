// The parts of `kilotouch check` that have an answer known by other means: parts of a library, rows of what a worker
// left, queries by an index that loses triangles, what is held of a body, places to touch.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/base/error.hpp"
#include "io/files/child_process.hpp"
#include "io/solid/tetrahedra_quality.hpp"
#include "io/solid/tetrahedralize.hpp"
#include "io/surface/surface_distance.hpp"
#include "lab/check/contact_spots.hpp"
#include "lab/check/hand_paths.hpp"
#include "lab/check/library.hpp"
#include "lab/check/rows.hpp"
#include "lab/check/runs.hpp"
#include "lab/check/stages/fill.hpp"
#include "lab/check/stages/models.hpp"
#include "lab/check/stages/queries.hpp"
#include "lab/check/verdict.hpp"
#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

Mesh block_surface() {
  const Mesh solid = kuhn_block(4, 4, 4, 0.025);
  return {solid.x, boundary_triangles(solid.tetrahedra), {}};
}

TEST(CheckShards, EachMeshIsInOnePart) {
  std::vector<LibraryMesh> all;
  for (int i = 0; i < 17; ++i) all.push_back({"mesh" + std::to_string(i), ""});
  std::vector<std::string> seen;
  for (int part = 1; part <= 5; ++part)
    for (const LibraryMesh& m : part_of(all, {part, 5})) seen.push_back(m.key);
  std::ranges::sort(seen);
  EXPECT_EQ(seen.size(), 17u);
  EXPECT_EQ(std::ranges::adjacent_find(seen), seen.end());
  for (const char* wrong : {"0/3", "4/3", "1", "1/", "/3", "a/b", "1/3x", "-1/3", ""})
    EXPECT_THROW(parse_shard(wrong), InputError) << wrong;
  EXPECT_EQ(parse_shard("3/8").index, 3);
}

TEST(CheckLibrary, KeysArePathsFromTheFolderAndUnique) {
  const PrivateFolder folder;
  std::filesystem::create_directories(folder / "a/b");
  for (const char* name : {"a/b/one.obj", "a/two.STL", "a/._two.STL", "a/readme.txt", "a/pair.ele", "a/pair.node"})
    std::ofstream(folder / name) << "x";
  const auto found = find_meshes({folder / "a"});
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].key, "b/one.obj");
  EXPECT_EQ(found[1].key, "pair.node");
  EXPECT_EQ(found[2].key, "two.STL");
  EXPECT_EQ(find_meshes({folder / "a/", folder / "a/b/one.obj"}).size(), 4u);
  EXPECT_THROW(find_meshes({folder / "a/two.STL", folder / "a/two.STL"}), InputError);
  EXPECT_THROW(find_meshes({folder / "none"}), InputError);
}

Json batch_row(const std::string& outcome, const std::string& trouble, const Json& result) {
  return {{"key", "m"},         {"outcome", outcome}, {"exit_code", 0},
          {"trouble", trouble}, {"seconds", 1.0},     {"result", result}};
}

TEST(CheckRows, TheWorstStageGivesTheVerdict) {
  StageResult doctor, press;
  doctor.name = "doctor";
  doctor.lower(Verdict::degraded, "3 open edges", Vec3(1, 2, 3));
  press.name = "press";
  EXPECT_EQ(worse(Verdict::skipped, Verdict::pass), Verdict::pass);
  EXPECT_EQ(worse(Verdict::degraded, Verdict::pass), Verdict::degraded);
  Json result{{"stages", {to_json(doctor), to_json(press)}}, {"running", ""}, {"triangles", 7}};
  Json row = report_row(batch_row("done", "", result));
  EXPECT_EQ(row["verdict"], "degraded");
  EXPECT_EQ(row["stage"], "doctor");
  EXPECT_EQ(row["where"][1], 2.0);

  result["running"] = "drag";  // it died there
  row = report_row(batch_row("timeout", "ran longer than 5 s: last words", result));
  EXPECT_EQ(row["verdict"], "fail");
  EXPECT_EQ(row["stage"], "drag");
  EXPECT_EQ(row["why"], "timeout: ran longer than 5 s");
  EXPECT_EQ(row["stages"].size(), 3u);
  row = report_row(batch_row("crash", "crashed (Segmentation fault)", nullptr));
  EXPECT_EQ(row["verdict"], "fail");
  EXPECT_EQ(row["stage"], "start");
  EXPECT_TRUE(was_killed(batch_row("crash", "crashed (Killed)", nullptr)));
  EXPECT_FALSE(was_killed(batch_row("crash", "crashed (Segmentation fault)", nullptr)));
}

TEST(CheckRows, OnlyNewFailuresCount) {
  const auto report = [](const std::vector<std::pair<std::string, std::string>>& rows) {
    Json out{{"rows", Json::array()}};
    for (const auto& [path, verdict] : rows) out["rows"].push_back({{"path", path}, {"verdict", verdict}});
    return out;
  };
  const Json old = report({{"a", "fail"}, {"b", "pass"}, {"c", "degraded"}});
  const Json now = report({{"a", "fail"}, {"b", "fail"}, {"c", "degraded"}, {"d", "fail"}});
  EXPECT_EQ(new_failures(now, old), (std::vector<std::string>{"b", "d"}));
  EXPECT_EQ(new_failures(now, Json()), (std::vector<std::string>{"a", "b", "d"}));
}

/// Every candidate but each third.
class Lossy final : public TriangleIndex {
 public:
  void build(std::span<const Triangle> triangles, const VectorX& x) override { whole_->build(triangles, x); }
  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override { whole_->refit(x_t0, x_t1); }
  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    const int found = whole_->candidates(sweep, margin, out);
    const auto end = std::remove_if(out.begin(), out.begin() + found, [](int t) { return t % 3 == 0; });
    return static_cast<int>(end - out.begin());
  }

 private:
  std::unique_ptr<TriangleIndex> whole_ = make_triangle_index("brute_force");
};

TEST(CheckQueries, AgreeForEveryBackendAndTellALossyOne) {
  const Mesh mesh = block_surface();
  const auto truths = true_queries(mesh.triangles, mesh.x, 200, 1);
  for (const BackendInfo& b : triangle_index_backends()) {
    if (!b.available) continue;
    const auto index = make_triangle_index(b.name);
    index->build(mesh.triangles, mesh.x);
    index->refit(mesh.x, mesh.x);
    const QueryCount count = judge_queries(mesh.triangles, mesh.x, *index, truths);
    EXPECT_EQ(count.wrong_points + count.wrong_rays, 0) << b.name;
    EXPECT_GT(count.hits, 100) << b.name;
  }
  Lossy lossy;
  lossy.build(mesh.triangles, mesh.x);
  lossy.refit(mesh.x, mesh.x);
  const QueryCount count = judge_queries(mesh.triangles, mesh.x, lossy, truths);
  EXPECT_GT(count.wrong_points, 20);
  EXPECT_GT(count.wrong_rays, 20);
  EXPECT_TRUE(count.where.has_value());
}

TEST(CheckBody, EachPieceIsHeldAtItsFoot) {
  Mesh two = kuhn_block(4, 4, 4, 0.025);
  const int nodes = two.num_nodes();
  Mesh other = two;
  for (int i = 0; i < nodes; ++i) node(other.x, i) += Vec3(1, 0, 5);
  VectorX x(6 * nodes);
  x << two.x, other.x;
  two.x = x;
  for (Tetrahedron t : other.tetrahedra) {
    for (int& i : t) i += nodes;
    two.tetrahedra.push_back(t);
  }
  EXPECT_EQ(held_nodes(two, false).size(), 50u);  // a layer of 25 each
  const Mesh flat = kuhn_block(10, 10, 1, 0.01);
  EXPECT_EQ(held_nodes(flat, true).size(), 3u * 11 * 2);  // one end, not the whole underside
}

TEST(CheckSpots, LieOnTheSurfaceApartAndFree) {
  const Mesh body = kuhn_block(8, 8, 8, 0.0125);
  const Mesh surface{body.x, boundary_triangles(body.tetrahedra), body.tetrahedra};
  const std::vector<int> held = held_nodes(surface, false);
  const auto spots = find_contact_spots(surface, held, {});
  ASSERT_EQ(spots.size(), 8u);
  for (const ContactSpot& s : spots) {
    const double distance = std::sqrt(nearest_place(surface.triangles, surface.x, s.place).at.distance_sq);
    EXPECT_LT(distance, 1e-12);
    EXPECT_GT(s.place.z(), 0.2 * 0.1);
    EXPECT_NEAR(s.thickness, 0.1, 1e-6);
    EXPECT_NEAR(s.depth, 0.002, 1e-12);
    for (const ContactSpot& other : spots)
      if (&other != &s) {
        EXPECT_GT((other.place - s.place).norm(), 0.02);
      }
  }
  const SurfaceQuery query(surface.triangles, surface.x);
  const auto walk = surface_walk(query, HeldTriangles(surface, held), spots[0], 0.3, 0.015);
  ASSERT_GT(walk.size(), 5u);
  for (const Vec3& p : walk) {
    EXPECT_NEAR(query.distance(p, 0.01), 0.002, 1e-6);  // a sphere of 4 mm, 2 mm deep
    EXPECT_TRUE(query.is_within(p, 0.0021));
    EXPECT_FALSE(query.is_within(p, 0.0019));
  }
}

#if KT_WITH_CGAL && KT_WITH_TETGEN
TEST(CheckFill, DecimatesEvenlyWhereTetrahedraWouldBeFlat) {
  MeshWork work;
  work.options.budget = 200;
  const Mesh fine = thin_disc(66);
  ASSERT_TRUE(is_fillable(examine(fine)));
  StageResult out;
  const Mesh coarse = decimated(fine, work, true, out);
  const auto first = out.figures.at("decimated");
  EXPECT_FALSE(first.contains("evenly"));
  const auto flat = tetrahedralize(coarse, {.name = "disc", .backend = "tetgen"});
  EXPECT_LT(tetrahedra_quality(flat).dihedral_min, 0.5) << "then this test has nothing to show";

  const auto body = filled(coarse, fine, work, out);
  ASSERT_TRUE(body.has_value());
  EXPECT_GT(tetrahedra_quality(*body).dihedral_min, 2);
  EXPECT_TRUE(out.figures.at("decimated").at("evenly"));
  EXPECT_EQ(out.figures.at("tetrahedralizer"), "tetgen");
  EXPECT_EQ(out.verdict, Verdict::pass) << out.why;
  const Mesh skin{body->x, body->triangles, {}};
  EXPECT_NEAR(out.figures.at("decimated").at("distance"), hausdorff_distance(fine, skin, 5e-4), 1e-12);
}
/// Pieces stay when edges collapse, and this many are not stepped: they are wrapped instead.
TEST(CheckFill, WhatDecimationLeavesFarOverTheBudgetIsNotFilled) {
  MeshWork work;
  work.options.body = "mesh";
  work.options.budget = 50;
  constexpr int kPieces = 64;  // of 4 triangles: 256, five times the budget
  work.surface.x.resize(12 * kPieces);
  for (int p = 0; p < kPieces; ++p) {
    const Vec3 at = 0.025 * Vec3(p % 4, p / 4 % 4, p / 16);
    for (int k = 0; k < 4; ++k)
      node(work.surface.x, 4 * p + k) = at + (k == 0 ? Vec3(0, 0, 0) : Vec3(0.01 * Vec3::Unit(k - 1)));
    for (const Triangle& t : {Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{0, 3, 2}, Triangle{1, 2, 3}})
      work.surface.triangles.push_back({4 * p + t[0], 4 * p + t[1], 4 * p + t[2]});
  }
  work.repaired = examine(work.surface);
  ASSERT_TRUE(is_fillable(work.repaired));
  StageResult out;
  check_solid(work, out);
  EXPECT_TRUE(out.figures.contains("wrap")) << out.why;
}

#if KT_WITH_NETGEN
TEST(CheckFill, AsksTheOthersWhereTetrahedraAreFlat) {
  const Mesh disc = thin_disc(36);
  const auto angle = [&](const char* backend) {
    return tetrahedra_quality(tetrahedralize(disc, {.name = "disc", .backend = backend})).dihedral_min;
  };
  ASSERT_LT(angle("tetgen"), 0.5);
  ASSERT_GT(angle("netgen"), angle("tetgen"));
  MeshWork work;  // the disc is not over the budget
  StageResult out;
  const auto body = filled(disc, disc, work, out);
  ASSERT_TRUE(body.has_value());
  EXPECT_EQ(tetrahedra_quality(*body).dihedral_min, angle("netgen"));
  EXPECT_EQ(out.figures.at("tetrahedralizer"), "netgen");
  EXPECT_EQ(out.verdict, Verdict::pass) << out.why;
}
#endif
#endif

double speed_at(const std::vector<TimedPoint>& path, double t) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (path[i].t > t) return (path[i].x - path[i - 1].x).norm() / (path[i].t - path[i - 1].t);
  return 0;
}

const ContactSpot kSpot{.place = Vec3(0, 0, 0.1),
                        .normal = Vec3::UnitZ(),
                        .triangle = 0,
                        .radius = 0.004,
                        .depth = 0.002,
                        .thickness = 0.1};

TEST(CheckLoss, IsExcusedByAWholeBodyThatLeavesToo) {
  EXPECT_EQ(judge_loss({200, 100}), Verdict::pass);
  EXPECT_EQ(judge_loss({201, 100}), Verdict::fail);
  EXPECT_EQ(judge_loss({15, 7}), Verdict::degraded);
  EXPECT_EQ(judge_loss({1, 0}), Verdict::degraded);
  EXPECT_EQ(judge_loss({20, std::nullopt}), Verdict::degraded) << "a light body bounces";
  EXPECT_EQ(judge_loss({21, std::nullopt}), Verdict::fail);
}

/// A tool on the way down may bounce; what counts begins later.
TEST(CheckLoss, BeforeTheTimeThatIsAskedForIsNone) {
  SessionResult run;
  for (int i = 1; i <= 300; ++i) {
    LocalFrame f;
    f.t = 1e-3 * i;
    f.mode = i == 60 || i > 250 ? ContactMode::free : ContactMode::stick;
    run.tools[0].frames.push_back(f);
  }
  EXPECT_EQ(longest_loss({}, run, 0.1, 0.25, nullptr).ticks, 0);
}

TEST(CheckFall, IsTheLargestFromOneDepthToTheNext) {
  const Fall fall = largest_fall(std::vector<double>{0.1, 0.4, 0.36, 0.2});
  EXPECT_NEAR(fall.share, 0.16 / 0.4, 1e-15);
  EXPECT_EQ(fall.to, 3u);
  EXPECT_EQ(largest_fall(std::vector<double>{0.1, 0.2, 0.2, 0.3}).share, 0);
  EXPECT_EQ(largest_fall(std::vector<double>{0, 0, 0, 0}).share, 0);
}

TEST(CheckFall, IsNoFailureWhereTheWholeBodyFallsToo) {
  EXPECT_EQ(judge_fall({0.05, 1}, {}), Verdict::pass) << "ringing";
  EXPECT_EQ(judge_fall({0.06, 1}, {}), Verdict::degraded);
  EXPECT_EQ(judge_fall({0.31, 1}, {}), Verdict::fail) << "nothing to compare with";
  EXPECT_EQ(judge_fall({0.31, 1}, Fall{0.15, 2}), Verdict::fail);
  EXPECT_EQ(judge_fall({0.31, 1}, Fall{0.16, 2}), Verdict::degraded) << "excused, but told";
}

TEST(CheckHand, PressesAndRestsAtFourDepths) {
  const PressPath press = press_path(kSpot);
  ASSERT_EQ(press.rests.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    const auto end = std::ranges::find(press.path, press.rests[i], &TimedPoint::t);
    ASSERT_NE(end, press.path.end());
    EXPECT_NEAR(end->x.z(), 0.1 + 0.004 - 0.0005 * (i + 1), 1e-12);
    EXPECT_EQ((end->x - (end - 1)->x).norm(), 0);  // at rest
    // Halfway through a step of 50 ms: 15/8 of its mean speed (Flash and Hogan 1985); at its ends hardly any.
    const double begin = press.rests[i] - 0.1;
    EXPECT_NEAR(speed_at(press.path, begin + 0.025), 1.875 * 0.0005 / 0.05, 2e-3 * 0.02);
    EXPECT_LT(speed_at(press.path, begin + 0.0005), 0.02 * 0.02);
    EXPECT_LT(speed_at(press.path, begin + 0.0495), 0.02 * 0.02);
  }
  for (std::size_t i = 1; i < press.path.size(); ++i) EXPECT_GT(press.path[i].t, press.path[i - 1].t);
}

TEST(CheckHand, DragsToAndFroAlongTheWay) {
  const std::vector<Vec3> way{Vec3(0, 0, 0.002), Vec3(0.003, 0, 0.002), Vec3(0.004, 0.001, 0.002)};
  const double length = length_of(way);
  EXPECT_NEAR(length, 0.003 + 0.001 * std::sqrt(2.0), 1e-15);
  const auto path = drag_path(kSpot, way, 0.04, 0.6);
  EXPECT_GE(path.back().t, 0.6);
  const double stroke = length / 0.04;  // [s]
  for (const TimedPoint& p : path) {
    if (p.t < kDragPressTime) continue;
    // On one of the two pieces, at the length that the closed form says.
    double gone = std::fmod(p.t - kDragPressTime, 2 * stroke) / stroke;
    if (gone > 1) gone = 2 - gone;
    const double along = length * gone * gone * gone * (10 - 15 * gone + 6 * gone * gone);
    const Vec3 expected =
        along < 0.003 ? Vec3(along, 0, 0.002) : Vec3(way[1] + (along - 0.003) * (way[2] - way[1]).normalized());
    EXPECT_LT((p.x - expected).norm(), 1e-9) << p.t;
  }
}

}  // namespace
}  // namespace kt
