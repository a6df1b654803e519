// Both kinds of queries of the continuous-collision benchmark (Wang et al. 2021), whose answers are exact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "collision/impact/feature_toi.hpp"
#include "io/files/child_process.hpp"
#include "tests/support/ccd_queries.hpp"
#include "tests/support/test_data.hpp"

namespace kt {
namespace {

struct Count {
  long queries = 0, missed = 0, false_hits = 0, late = 0, too_low = 0;
  std::vector<double> early;

  double early_at(double share) {
    std::ranges::sort(early);
    return early.empty() ? 0 : early[static_cast<std::size_t>(share * static_cast<double>(early.size() - 1))];
  }
};

void count(const CcdQueries& all, ToiMode mode, Count& out) {
  for (std::size_t i = 0; i < all.points.size(); ++i) {
    const auto& p = all.points[i];
    const Vec3 t0[4] = {p[0], p[1], p[2], p[3]}, t1[4] = {p[4], p[5], p[6], p[7]};
    const ToiResult r =
        all.kind == CcdQueries::Kind::vertex_face ? vertex_face_toi(t0, t1, mode) : edge_edge_toi(t0, t1, mode);
    ++out.queries;
    out.missed += all.collides[i] && !r.is_contact();
    out.false_hits += !all.collides[i] && r.is_contact();
    EXPECT_FALSE(!all.collides[i] && r.is_contact() && r.is_certain);
    if (!r.is_contact() || !all.collides[i] || !all.times[i].is_known) continue;
    out.late += r.toi > all.times[i].toi;
    out.too_low += r.toi_upper < all.times[i].toi;
    out.early.push_back(all.times[i].toi - r.toi);
  }
}

struct Archive {
  const char* name;
  long false_hits_conservative, false_hits_exact;  // at most
};

class ToiBenchmark : public testing::TestWithParam<Archive> {};

TEST_P(ToiBenchmark, NoCollisionIsMissedOrLate) {
  const std::string archive = test_data() + "/ccd/ccd-" + GetParam().name + ".tar.xz";
  if (!std::filesystem::exists(archive)) GTEST_SKIP() << "no " << archive;
  const PrivateFolder folder;
  const ChildLimits limits;
  const ChildResult unpacked = run_program({"tar", "-xJf", archive, "-C", folder.path()}, folder, limits);
  ASSERT_TRUE(unpacked.good()) << unpacked.trouble(limits);
  Count conservative, exact;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "bin")) {
    if (entry.path().extension() != ".bin") continue;
    const CcdQueries all = load_ccd_queries(entry.path().string());
    ASSERT_EQ(all.times.size(), all.points.size());
    count(all, ToiMode::conservative, conservative);
    count(all, ToiMode::exact, exact);
  }
  for (auto& [mode, c] : {std::pair<const char*, Count&>("conservative", conservative), {"exact", exact}}) {
    std::printf("%s, %s: %ld queries, %ld missed, %ld late, %ld false, early median %.2g, p95 %.2g, largest %.2g\n",
                GetParam().name, mode, c.queries, c.missed, c.late, c.false_hits, c.early_at(0.5), c.early_at(0.95),
                c.early_at(1));
    EXPECT_GT(c.queries, 0);
    EXPECT_EQ(c.missed, 0);
    EXPECT_EQ(c.late, 0);
    EXPECT_EQ(c.too_low, 0);
    EXPECT_LE(c.early_at(0.5), 1e-12);
    EXPECT_LE(c.early_at(0.95), 1e-8);
  }
  EXPECT_LE(conservative.false_hits, GetParam().false_hits_conservative);
  EXPECT_LE(exact.false_hits, GetParam().false_hits_exact);
  EXPECT_LE(exact.early_at(1), 1e-10);
}

// The hand-made ones pass within 1e-16 of each other by the dozen.
INSTANTIATE_TEST_SUITE_P(Archives, ToiBenchmark,
                         testing::Values(Archive{"handcrafted", 150, 0}, Archive{"simulation", 15, 2}),
                         [](const auto& archive) { return std::string(archive.param.name); });

}  // namespace
}  // namespace kt
