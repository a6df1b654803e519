// Times of impact of recorded queries, against their exact answers and the clock:
//   ccd_table FILE...
// FILE: queries with exact truths, in the format of the continuous-collision benchmark; FILE.oracle beside it adds
// exact times. `early`: share of the step.
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "collision/impact/feature_toi.hpp"
#include "core/base/error.hpp"
#include "tests/support/ccd_queries.hpp"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;

/// What one mode does with a set of queries.
struct Score {
  long queries = 0, missed = 0, false_hits = 0, late = 0;
  double total_us = 0;
  std::vector<double> early, us;  ///< sorted after `finish`

  void finish() {
    std::ranges::sort(early);
    std::ranges::sort(us);
  }
  void add(const Score& s) {
    queries += s.queries, missed += s.missed, false_hits += s.false_hits, late += s.late, total_us += s.total_us;
    early.insert(early.end(), s.early.begin(), s.early.end());
    us.insert(us.end(), s.us.begin(), s.us.end());
    finish();
  }
  double mean_us() const { return queries > 0 ? total_us / static_cast<double>(queries) : 0; }
};

double quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

struct Query {
  Vec3 x_t0[4], x_t1[4];
};

ToiResult answer(const Query& q, CcdQueries::Kind kind, ToiMode mode) {
  return kind == CcdQueries::Kind::vertex_face ? vertex_face_toi(q.x_t0, q.x_t1, mode)
                                               : edge_edge_toi(q.x_t0, q.x_t1, mode);
}

double microseconds(Clock::time_point from) {
  return std::chrono::duration<double, std::micro>(Clock::now() - from).count();
}

/// Least time per call over `batches` batches of `calls` calls; `sum` keeps the calls from being left out.
double least_us(const Query& q, CcdQueries::Kind kind, ToiMode mode, int batches, int calls, double& sum) {
  double least = 1e300;
  for (int b = 0; b < batches; ++b) {
    const auto start = Clock::now();
    for (int i = 0; i < calls; ++i) sum += answer(q, kind, mode).toi;
    least = std::min(least, microseconds(start) / calls);
  }
  return least;
}

/// Other programs take the processor away at times: of every call, and of every block of calls in a row, the least of
/// several times counts.
void measure(const std::vector<Query>& queries, CcdQueries::Kind kind, ToiMode mode, Score& out) {
  constexpr int kPasses = 5, kBatches = 3, kCalls = 4, kBatchesOfSlow = 30;
  constexpr double kSlow = 2;  // [us]
  constexpr std::size_t kBlock = 256;
  double sum = 0;
  for (std::size_t first = 0; first < queries.size(); first += kBlock) {
    const std::size_t last = std::min(first + kBlock, queries.size());
    double least = 1e300;
    for (int pass = 0; pass < kPasses; ++pass) {
      const auto start = Clock::now();
      for (std::size_t i = first; i < last; ++i) sum += answer(queries[i], kind, mode).toi;
      least = std::min(least, microseconds(start));
    }
    out.total_us += least;
  }
  for (const Query& q : queries) {
    double us = least_us(q, kind, mode, kBatches, kCalls, sum);
    if (us > kSlow) us = std::min(us, least_us(q, kind, mode, kBatchesOfSlow, 1, sum));
    out.us.push_back(us);
  }
  volatile double keep = sum;
  static_cast<void>(keep);
}

Score score(const CcdQueries& all, ToiMode mode) {
  std::vector<Query> queries(all.points.size());
  for (std::size_t i = 0; i < queries.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      queries[i].x_t0[k] = all.points[i][k];
      queries[i].x_t1[k] = all.points[i][4 + k];
    }
  Score out;
  out.queries = static_cast<long>(queries.size());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    const ToiResult r = answer(queries[i], all.kind, mode);
    out.missed += all.collides[i] && !r.is_contact();
    out.false_hits += !all.collides[i] && r.is_contact();
    if (!r.is_contact() || !all.collides[i] || all.times.empty() || !all.times[i].is_known) continue;
    out.late += r.toi > all.times[i].toi;
    out.early.push_back(all.times[i].toi - r.toi);
  }
  measure(queries, all.kind, mode, out);
  out.finish();
  return out;
}

void print_row(const std::string& name, const std::string& mode, const Score& s) {
  std::printf("%-28s %-12s %8ld %5ld %5ld %5ld", name.c_str(), mode.c_str(), s.queries, s.missed, s.false_hits, s.late);
  if (s.early.empty())
    std::printf(" %9s %9s %9s", "-", "-", "-");
  else
    std::printf(" %9.2g %9.2g %9.2g", quantile(s.early, 0.5), quantile(s.early, 0.95), s.early.back());
  std::printf(" %8.3f %8.2f %8.2f\n", s.mean_us(), quantile(s.us, 0.99), s.us.empty() ? 0.0 : s.us.back());
  std::fflush(stdout);
}

void print_table(const std::vector<std::string>& names) {
  constexpr std::pair<const char*, ToiMode> kModes[] = {{"conservative", ToiMode::conservative},
                                                        {"exact", ToiMode::exact}};
  std::printf("%-28s %-12s %8s %5s %5s %5s %29s %26s\n", "", "", "", "", "", "", "early, share of the step",
              "us a query");
  std::printf("%-28s %-12s %8s %5s %5s %5s %9s %9s %9s %8s %8s %8s\n", "file", "mode", "queries", "FN", "FP", "late",
              "median", "p95", "max", "mean", "p99", "max");
  Score all[std::size(kModes)];
  for (const std::string& name : names) {
    const CcdQueries queries = load_ccd_queries(name);
    for (std::size_t k = 0; k < std::size(kModes); ++k) {
      const Score s = score(queries, kModes[k].second);
      print_row(name.substr(name.rfind('/') + 1), kModes[k].first, s);
      all[k].add(s);
    }
  }
  for (std::size_t k = 0; k < std::size(kModes); ++k) print_row("all", kModes[k].first, all[k]);
}

}  // namespace
}  // namespace kt

int main(int count, char** words) {
  try {
    kt::print_table({words + 1, words + count});
  } catch (const kt::InputError& e) {
    std::fprintf(stderr, "ccd_table: %s\n", e.what());
    return 2;
  }
  return 0;
}
