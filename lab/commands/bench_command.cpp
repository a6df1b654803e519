// kilotouch bench ccd FILE...: times of impact of recorded queries, against their exact answers and the clock.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/console/words.hpp"
#include "collision/impact/feature_toi.hpp"
#include "core/base/error.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "lab/ccd/ccd_queries.hpp"
#include "lab/commands/laboratory.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

struct BenchArguments {
  std::vector<std::string> files;
  std::string mode = "both", json_file;
};

/// What one mode does with a set of queries.
struct Score {
  long queries = 0, missed = 0, false_hits = 0, late = 0, open = 0, invalid = 0;
  double total_us = 0;
  std::vector<double> early, us;  ///< sorted after `finish`

  void finish() {
    std::ranges::sort(early);
    std::ranges::sort(us);
  }
  void add(const Score& s) {
    queries += s.queries, missed += s.missed, false_hits += s.false_hits, late += s.late, open += s.open;
    invalid += s.invalid, total_us += s.total_us;
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
    out.open += r.is_contact() && !r.is_certain;
    out.invalid += r.status == ToiResult::Status::invalid_input;
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

Json row_json(const std::string& file, const std::string& mode, const Score& s) {
  Json early = Json();
  if (!s.early.empty())
    early = {{"median", quantile(s.early, 0.5)}, {"p95", quantile(s.early, 0.95)}, {"max", s.early.back()}};
  return {{"file", file},
          {"mode", mode},
          {"queries", s.queries},
          {"false_negatives", s.missed},
          {"false_positives", s.false_hits},
          {"late", s.late},
          {"open", s.open},
          {"invalid", s.invalid},
          {"early", early},
          {"us", {{"mean", s.mean_us()}, {"p99", quantile(s.us, 0.99)}, {"max", s.us.empty() ? 0.0 : s.us.back()}}}};
}

void bench_ccd(const BenchArguments& a) {
  std::vector<std::pair<std::string, ToiMode>> modes;
  if (a.mode != "exact") modes.emplace_back("conservative", ToiMode::conservative);
  if (a.mode != "conservative") modes.emplace_back("exact", ToiMode::exact);
  std::vector<CcdQueries> files;
  for (const std::string& file : a.files) files.push_back(load_ccd_queries(file));

  std::printf("%-28s %-12s %8s %5s %5s %5s %29s %26s\n", "", "", "", "", "", "", "early, share of the step",
              "us a query");
  std::printf("%-28s %-12s %8s %5s %5s %5s %9s %9s %9s %8s %8s %8s\n", "file", "mode", "queries", "FN", "FP", "late",
              "median", "p95", "max", "mean", "p99", "max");
  Json out{{"files", Json::array()}, {"all", Json::array()}};
  std::vector<Score> all(modes.size());
  for (std::size_t i = 0; i < files.size(); ++i)
    for (std::size_t k = 0; k < modes.size(); ++k) {
      if (stop_requested()) throw RunError("stopped");
      const Score s = score(files[i], modes[k].second);
      print_row(a.files[i].substr(a.files[i].rfind('/') + 1), modes[k].first, s);
      out["files"].push_back(row_json(a.files[i], modes[k].first, s));
      all[k].add(s);
    }
  for (std::size_t k = 0; k < modes.size(); ++k) {
    print_row("all", modes[k].first, all[k]);
    out["all"].push_back(row_json("all", modes[k].first, all[k]));
  }
  write_json(a.json_file, json_text(out, 2) + "\n");
}

}  // namespace

void add_bench_command(CLI::App& app, int& exit_code) {
  CLI::App* bench = app.add_subcommand("bench", "accuracy and speed of a part of the engine, on recorded input");
  bench->require_subcommand(1);
  auto a = std::make_shared<BenchArguments>();
  CLI::App* ccd = bench->add_subcommand("ccd", "times of impact of vertices with faces and of edges with edges");
  ccd->add_option("FILE", a->files, "queries with exact truths. FILE.oracle beside it adds exact times")->required();
  ccd->add_option("--mode", a->mode, "conservative, exact or both")
      ->check(CLI::IsMember({"conservative", "exact", "both"}))
      ->capture_default_str();
  add_json_option(*ccd, a->json_file, "the table");
  ccd->footer("Example:\n  kilotouch bench ccd cloth-ball-vf.bin cloth-ball-ee.bin --mode exact");
  ccd->callback([a, &exit_code] {
    bench_ccd(*a);
    exit_code = 0;
  });
}

}  // namespace kt
