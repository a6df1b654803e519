#include "io/files/json_batch.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "core/base/error.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

/// Writes {"value": n} and one more line to `log`, so that a test sees how often it ran.
BatchJob counted(const std::string& key, int n, const std::string& log) {
  return {key,
          {"sh", "-c", "echo " + key + " >>" + log + "; echo '{\"value\": " + std::to_string(n) + "}' >$0", "{json}"}};
}

int lines_of(const std::string& file) {
  std::ifstream in(file);
  int n = 0;
  for (std::string line; std::getline(in, line);) ++n;
  return n;
}

TEST(Batch, RowsComeInTheOrderOfTheJobs) {
  const PrivateFolder folder;
  std::vector<BatchJob> jobs;
  for (int i = 0; i < 12; ++i) jobs.push_back(counted("job" + std::to_string(i), i, folder / "log"));
  double share = 0;
  const auto rows =
      run_batch(jobs, {.file = folder / "rows", .jobs = 3, .limits = {}, .progress = [&](double s) { share = s; }});
  ASSERT_EQ(rows.size(), 12u);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(rows[i]["key"], jobs[i].key);
    EXPECT_EQ(rows[i]["outcome"], "done");
    EXPECT_EQ(rows[i]["result"]["value"], i);
  }
  EXPECT_EQ(share, 1);
  EXPECT_EQ(lines_of(folder / "rows"), 12);
}

/// Of a file: as `counted`.
BatchJob of_file(const std::string& key, const std::string& file, const std::string& log) {
  BatchJob out{key, {"sh", "-c", "echo $1 >>" + log + "; wc -c <$1 >$0", "{json}", file}};
  out.inputs = {file};
  return out;
}

void write(const std::string& file, const std::string& content) { std::ofstream(file) << content; }

TEST(Batch, ARowHoldsWhileItsInputsAreTheSame) {
  const PrivateFolder folder;
  const std::string log = folder / "log", rows = folder / "rows";
  const BatchOptions options{.file = rows, .resume = true, .limits = {}};
  write(folder / "a.off", "12345");
  write(folder / "b.off", "1234567");
  std::vector<BatchJob> jobs{of_file("a", folder / "a.off", log), of_file("b", folder / "b.off", log)};
  run_batch(jobs, options);
  run_batch(jobs, options);
  EXPECT_EQ(lines_of(log), 2);           // none twice
  write(folder / "a.off", "123456789");  // mended
  const auto mended = run_batch(jobs, options);
  EXPECT_EQ(mended[0]["result"], 9);
  EXPECT_EQ(mended[1]["result"], 7);
  EXPECT_EQ(lines_of(log), 3);
  EXPECT_EQ(lines_of(rows), 2);  // the old row is gone
}

TEST(Batch, ARenamedInputKeepsItsRow) {
  const PrivateFolder folder;
  const std::string log = folder / "log", rows = folder / "rows";
  const BatchOptions options{.file = rows, .resume = true, .limits = {}};
  write(folder / "a.off", "12345");
  write(folder / "b.off", "1234567");
  run_batch({of_file("a", folder / "a.off", log), of_file("b", folder / "b.off", log)}, options);
  std::filesystem::rename(folder / "b.off", folder / "c.off");
  std::filesystem::copy(folder / "a.off", folder / "copy.off");
  const auto out = run_batch({of_file("a", folder / "a.off", log), of_file("c", folder / "c.off", log),
                              of_file("copy", folder / "copy.off", log)},
                             options);
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(out[1]["result"], 7);
  EXPECT_EQ(lines_of(log), 3);  // the copy is a mesh of its own; the renamed one is not made again
  EXPECT_EQ(lines_of(rows), 3);
  // Two that change places keep their rows, too; another ending is read in another way.
  std::filesystem::rename(folder / "a.off", folder / "x");
  std::filesystem::rename(folder / "c.off", folder / "a.off");
  std::filesystem::rename(folder / "x", folder / "c.off");
  std::filesystem::rename(folder / "copy.off", folder / "copy.stl");
  const auto swapped = run_batch({of_file("a", folder / "a.off", log), of_file("c", folder / "c.off", log),
                                  of_file("copy", folder / "copy.stl", log)},
                                 options);
  EXPECT_EQ(swapped[0]["result"], 7);
  EXPECT_EQ(swapped[1]["result"], 5);
  EXPECT_EQ(lines_of(log), 4);
}

TEST(Batch, OtherWordsMakeAnotherRow) {
  const PrivateFolder folder;
  const std::string log = folder / "log";
  const BatchOptions options{.file = folder / "rows", .resume = true, .limits = {}};
  write(folder / "a.off", "12345");
  BatchJob job = of_file("a", folder / "a.off", log);
  run_batch({job}, options);
  job.arguments.emplace_back("--finer");
  run_batch({job}, options);
  EXPECT_EQ(lines_of(log), 2);
}

TEST(Batch, EachOutcomeHasItsWord) {
  const PrivateFolder folder;
  const std::vector<BatchJob> jobs = {
      {"error", {"sh", "-c", "echo '{\"stage\": 2}' >$0; echo no such mesh; exit 2", "{json}"}},
      {"crash", {"sh", "-c", "kill -SEGV $$"}},
      {"hang", {"sleep", "100"}},
      {"silent", {"true"}},
      {"half", {"sh", "-c", "echo '{\"value\":' >$0", "{json}"}}};
  const auto rows = run_batch(jobs, {.file = folder / "rows", .limits = {.seconds = 0.5}});
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[0]["outcome"], "error");
  EXPECT_EQ(rows[0]["exit_code"], 2);
  EXPECT_EQ(rows[0]["trouble"], "ended with exit code 2: no such mesh");
  EXPECT_EQ(rows[0]["result"]["stage"], 2);  // what it got to
  EXPECT_EQ(rows[1]["outcome"], "crash");
  EXPECT_EQ(rows[2]["outcome"], "timeout");
  EXPECT_EQ(rows[3]["outcome"], "done");
  EXPECT_TRUE(rows[3]["result"].is_null());
  EXPECT_TRUE(rows[4]["result"].is_null());
}

TEST(Batch, GoesOnWhereItWasKilled) {
  const PrivateFolder folder;
  std::vector<BatchJob> jobs;
  for (int i = 0; i < 4; ++i) jobs.push_back(counted("job" + std::to_string(i), i, folder / "log"));
  const BatchOptions options{.file = folder / "rows", .resume = true, .limits = {}};
  run_batch({jobs[2], jobs[0]}, options);
  std::ofstream(folder / "rows", std::ios::app) << "{\"key\": \"job1\", \"outc";  // killed while it wrote
  const auto rows = run_batch(jobs, options);
  ASSERT_EQ(rows.size(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(rows[i]["result"]["value"], i);
  EXPECT_EQ(lines_of(folder / "log"), 4);  // none twice
  EXPECT_EQ(read_batch(folder / "rows").size(), 4u);
  run_batch(jobs, {.file = folder / "rows", .limits = {}});  // anew
  EXPECT_EQ(lines_of(folder / "log"), 8);
}

TEST(Batch, StopKeepsWhatIsDone) {
  const PrivateFolder folder;
  std::atomic<bool> stop{false};
  std::vector<BatchJob> jobs = {counted("first", 1, folder / "log"), {"endless", {"sleep", "100"}}};
  const auto rows =
      run_batch(jobs, {.file = folder / "rows", .limits = {.stop = &stop}, .progress = [&](double) { stop = true; }});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0]["key"], "first");
}

TEST(Batch, AJobWaitsForThoseBeforeIt) {
  const PrivateFolder folder;
  const auto says = [&](const std::string& key, const std::string& wait, std::vector<std::string> after) {
    return BatchJob{key, {"sh", "-c", "sleep $2; echo $0 >>$1", key, folder / "log", wait}, std::move(after)};
  };
  // "late" may begin only when "slow" and "bad" have ended; "free" need not wait for anything.
  BatchJob bad = says("bad", "0.2", {});
  bad.arguments[2] += "; exit 1";
  const std::vector<BatchJob> jobs = {says("slow", "0.6", {}), bad, says("late", "0", {"slow", "bad"}),
                                      says("free", "0", {})};
  const auto rows = run_batch(jobs, {.file = folder / "rows", .jobs = 3, .limits = {}});
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[2]["outcome"], "done");
  std::ifstream log(folder / "log");
  const std::vector<std::string> order{std::istream_iterator<std::string>(log), {}};
  EXPECT_EQ(order, (std::vector<std::string>{"free", "bad", "slow", "late"}));
}

TEST(Batch, RefusesWhatCannotBe) {
  const PrivateFolder folder;
  const BatchJob job{"one", {"true"}};
  EXPECT_THROW(run_batch({{"early", {"true"}, {"one"}}, job}, {.file = folder / "rows", .limits = {}}), InputError);
  EXPECT_THROW(run_batch({job, job}, {.file = folder / "rows", .limits = {}}), InputError);
  EXPECT_THROW(run_batch({job}, {.file = folder / "none/rows", .limits = {}}), InputError);
  std::ofstream(folder / "other") << "t,x,y\n";
  EXPECT_THROW(run_batch({job}, {.file = folder / "other", .resume = true, .limits = {}}), InputError);
  EXPECT_EQ(lines_of(folder / "other"), 1);  // not touched
  EXPECT_THROW(read_batch(folder / "nothing"), InputError);

  const BatchJob inner{"inner", {"sleep", "1"}};
  std::jthread first([&] { run_batch({inner}, {.file = folder / "busy", .limits = {}}); });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_THROW(run_batch({job}, {.file = folder / "busy", .resume = true, .limits = {}}), InputError);
}

}  // namespace
}  // namespace kt
