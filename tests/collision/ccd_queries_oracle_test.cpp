// The vertex-face queries of the continuous-collision benchmark (Wang et al. 2021), whose answers are exact.
//
// Our impacts are one-sided, theirs are not: a query collides for us when it does from either side of its face. A
// vertex that touches at the start and comes nearer to neither side is no hit, by promise. A vertex that starts a
// little inside counts as resting on the surface, by promise: such answers are left out here, the other side must
// answer.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "collision/impact/tool_impact.hpp"
#include "io/files/child_process.hpp"
#include "tests/support/collision_oracle.hpp"
#include "tests/support/test_data.hpp"

namespace kt {
namespace {

struct ExactAnswer {
  std::int32_t result, padding;  // 1: there is a time of impact
  double toi;                    // rounded down
};

struct Queries {
  std::vector<CollisionQuery> queries;
  std::vector<char> collides;
  std::vector<ExactAnswer> answers;
};

template <class T>
void read(std::ifstream& file, T* out, std::size_t n = 1) {
  file.read(reinterpret_cast<char*>(out), static_cast<std::streamsize>(n * sizeof(T)));
}

Queries load_queries(const std::string& path) {
  std::ifstream file(path, std::ios::binary), oracle(path + ".oracle", std::ios::binary);
  std::int64_t n = 0, type = -1;
  read(file, &n);
  read(file, &type);
  if (type != 0) return {};
  Queries out;
  const auto count = static_cast<std::size_t>(n);
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 p[8];
    for (Vec3& v : p) read(file, v.data(), 3);
    out.queries.push_back({p[0], {p[1], p[2], p[3]}, p[4], {p[5], p[6], p[7]}});
  }
  out.collides.resize(count);
  out.answers.resize(count);
  read(file, out.collides.data(), count);
  read(oracle, out.answers.data(), count);
  EXPECT_TRUE(file.good() && oracle.good()) << path;
  return out;
}

/// The earliest hit from either side.
double toi_of(const CollisionQuery& q) {
  double first = std::numeric_limits<double>::infinity();
  for (const CollisionQuery& side : {q, reversed(q)})
    if (const auto hit = find_triangle_impact({}, {side.tool_t0, side.tool_t1}, side.triangle_t0, side.triangle_t1))
      if (hit->gap >= 0) first = std::min(first, hit->toi);
  return first;
}

struct Count {
  int queries = 0, collisions = 0, touching_at_start = 0, missed = 0, late = 0, false_positives = 0;
  double earliest = 0, largest_gap = 0;
};

Count count(const Queries& all) {
  Count out;
  for (std::size_t i = 0; i < all.queries.size(); ++i) {
    const CollisionQuery& q = all.queries[i];
    const double toi = toi_of(q);
    const bool hit = std::isfinite(toi);
    ++out.queries;
    if (hit) out.largest_gap = std::max(out.largest_gap, exact_distance(q, toi));
    if (!all.collides[i]) {
      out.false_positives += hit;
      continue;
    }
    ++out.collisions;
    if (!hit) ++(exact_distance(q, 0) == 0 ? out.touching_at_start : out.missed);
    if (!hit || all.answers[i].result != 1) continue;
    out.late += toi > std::nextafter(all.answers[i].toi, 2.0);
    out.earliest = std::max(out.earliest, all.answers[i].toi - toi);
  }
  return out;
}

class Benchmark : public testing::TestWithParam<const char*> {};

TEST_P(Benchmark, NoVertexFaceCollisionIsMissedOrLate) {
  const std::string archive = test_data() + "/ccd/ccd-" + GetParam() + ".tar.xz";
  if (!std::filesystem::exists(archive)) GTEST_SKIP() << "no " << archive;
  const PrivateFolder folder;
  const ChildLimits limits;
  const ChildResult unpacked = run_program({"tar", "-xJf", archive, "-C", folder.path()}, folder, limits);
  ASSERT_TRUE(unpacked.good()) << unpacked.trouble(limits);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "bin")) {
    if (!entry.path().string().ends_with("-vf.bin")) continue;
    ++files;
    const std::string name = entry.path().stem().string();
    const Count c = count(load_queries(entry.path().string()));
    std::printf(
        "%s: %d queries, %d collisions (%d touch at the start only), %d missed, %d late, %d false, "
        "earliest %.2g of the step, at most %.2g apart\n",
        name.c_str(), c.queries, c.collisions, c.touching_at_start, c.missed, c.late, c.false_positives, c.earliest,
        c.largest_gap);
    EXPECT_GT(c.queries, 0) << name;
    EXPECT_EQ(c.missed, 0) << name;
    EXPECT_EQ(c.late, 0) << name;
    EXPECT_LT(c.largest_gap, 1e-12) << name;  // 1e-14 of coordinates up to a few tens, and one resolution
  }
  EXPECT_GT(files, 0);
}

INSTANTIATE_TEST_SUITE_P(Archives, Benchmark, testing::Values("handcrafted", "simulation"),
                         [](const auto& archive) { return std::string(archive.param); });

}  // namespace
}  // namespace kt
