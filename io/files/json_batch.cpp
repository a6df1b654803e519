#include "io/files/json_batch.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>

#include "core/base/error.hpp"
#include "core/body/state.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/text_reader.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

/// The file of the rows: open, and no other batch's as long as this lives.
class RowFile {
 public:
  explicit RowFile(const std::string& path)
      : path_(path),
        file_(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC, 0644)) {
    if (file_ < 0)
      throw InputError(text(path, errno == ELOOP ? ": is a link, where a file of the results goes; remove it"
                                                 : text(": cannot be written: ", std::strerror(errno))));
    struct stat kind {};
    if (::fstat(file_, &kind) != 0 || !S_ISREG(kind.st_mode)) {
      ::close(file_);
      throw InputError(text(path, ": is not a regular file; rows are kept in one"));
    }
    if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return;
    ::close(file_);
    throw InputError(text(path, ": another run is writing to it"));
  }
  ~RowFile() { ::close(file_); }
  RowFile(const RowFile&) = delete;
  RowFile& operator=(const RowFile&) = delete;

  /// Only the first `bytes` stay.
  void cut(std::uintmax_t bytes) {
    if (::ftruncate(file_, static_cast<off_t>(bytes)) != 0) fail();
  }

  /// In one write, so that a kill leaves at most the last line short; read_batch() leaves that one out.
  void append(const Json& row) {
    // A result may hold a mesh's name in any encoding; what is not UTF-8 in it must not cost the row.
    const std::string line = json_text(row) + "\n";
    std::size_t done = 0;
    while (done < line.size()) {
      const ssize_t n = ::write(file_, line.data() + done, line.size() - done);
      if (n < 0 && errno != EINTR) fail();
      if (n > 0) done += static_cast<std::size_t>(n);
    }
  }

 private:
  [[noreturn]] void fail() { throw InputError(text(path_, ": cannot be written: ", std::strerror(errno))); }
  std::string path_;
  int file_;
};

/// What every row has that run_job() has written; empty: all of it.
std::string row_problem(const Json& row) {
  if (!row.is_object()) return "not a JSON object";
  const auto is = [&](const char* key, bool (Json::*kind)() const noexcept) {
    return row.contains(key) && (row[key].*kind)();
  };
  for (const char* key : {"key", "outcome", "trouble"})
    if (!is(key, &Json::is_string)) return text("\"", key, "\" is missing or no text");
  if (!is("seconds", &Json::is_number)) return "\"seconds\" is missing or no number";
  if (!row.contains("result")) return "\"result\" is missing";
  return {};
}

/// @param bytes  of the whole lines
std::vector<Json> read_rows(const std::string& file, std::uintmax_t& bytes) {
  std::vector<Json> rows;
  bytes = 0;
  std::error_code none;
  if (std::filesystem::is_regular_file(file, none) && std::filesystem::file_size(file, none) == 0) return rows;
  std::istringstream in(read_whole_file(file));
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (in.eof()) break;  // no line end: cut off
    require_shallow_json(line, text(file, ", line ", number));
    Json row = Json::parse(line, nullptr, false);
    if (const std::string why = row_problem(row); !why.empty())
      throw InputError(text(file, ", line ", number, ": not a row of a batch: ", why));
    rows.push_back(std::move(row));
    bytes += line.size() + 1;
  }
  return rows;
}

/// What the program wrote; null when it wrote nothing, or only a part.
Json read_result(const std::string& file) {
  try {
    return read_json_file(file);
  } catch (const InputError&) {
    return {};
  }
}

std::string outcome_of(const ChildResult& child, const std::string& trouble) {
  if (child.good()) return "done";
  if (child.timed_out) return "timeout";
  if (trouble.starts_with("needed more")) return "memory";
  return child.signal != 0 ? "crash" : "error";
}

/// Of what a result depends on: the words but for the program and the names of the inputs, and the inputs' extensions
/// and content. Empty for a job without inputs, or of one that cannot be read.
std::string inputs_hash(const BatchJob& job) {
  StateHash hash;
  for (std::size_t i = 1; i < job.arguments.size(); ++i)
    if (std::ranges::find(job.inputs, job.arguments[i]) == job.inputs.end())
      hash.add(job.arguments[i].c_str(), job.arguments[i].size() + 1);
  std::vector<char> part(std::size_t{1} << 20);
  for (const std::string& file : job.inputs) {
    const std::string extension = std::filesystem::path(file).extension().string();
    std::error_code none;
    std::ifstream in;
    if (std::filesystem::is_regular_file(file, none)) in.open(file, std::ios::binary);
    if (!in.is_open()) return {};
    hash.add(extension.c_str(), extension.size() + 1);
    double bytes = 0;
    while (in.read(part.data(), static_cast<std::streamsize>(part.size())) || in.gcount() > 0) {
      hash.add(part.data(), static_cast<std::size_t>(in.gcount()));
      bytes += static_cast<double>(in.gcount());
    }
    hash.add(bytes);  // where one file ends
  }
  return job.inputs.empty() ? "" : text(std::hex, hash.value());
}

std::string inputs_of(const Json& row) {
  return row.contains("inputs") && row["inputs"].is_string() ? row["inputs"].get<std::string>() : "";
}

/// Rewrites the file: a row whose inputs have changed goes, one whose inputs are another job's now gets its key.
void fit_rows(const std::string& file, const std::vector<BatchJob>& jobs) {
  std::uintmax_t bytes = 0;
  if (!std::filesystem::exists(file)) return;
  std::vector<Json> rows = read_rows(file, bytes);
  if (rows.empty()) return;
  std::map<std::string, std::string> hashes;  // of each key
  for (const BatchJob& job : jobs)
    if (!job.inputs.empty()) hashes[job.key] = inputs_hash(job);
  const auto holds = [&](const Json& row) {
    const auto job = hashes.find(row["key"].get<std::string>());
    return job == hashes.end() || (!job->second.empty() && job->second == inputs_of(row));
  };
  std::map<std::string, std::string> without_row;  // key of each hash
  for (const auto& [key, hash] : hashes)
    if (!hash.empty()) without_row[hash] = key;
  for (const Json& row : rows)
    if (hashes.contains(row["key"].get<std::string>()) && holds(row)) without_row.erase(inputs_of(row));
  std::string kept;
  bool is_changed = false;
  for (Json& row : rows) {
    const auto renamed = without_row.find(inputs_of(row));
    is_changed = is_changed || renamed != without_row.end() || !holds(row);
    if (renamed != without_row.end()) {
      row["key"] = renamed->second;
      without_row.erase(renamed);
    } else if (!holds(row)) {
      continue;
    }
    kept += json_text(row) + "\n";
  }
  if (is_changed) write_file_whole(file, kept);
}

/// Folders of jobs lie beside the rows, so that what a kill leaves behind is found by the next run.
std::string work_prefix(const std::string& file) { return std::filesystem::absolute(file).string() + ".work-"; }

void remove_leftovers(const std::string& file) {
  const std::filesystem::path prefix = work_prefix(file);
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(prefix.parent_path(), ignored))
    if (entry.path().filename().string().starts_with(prefix.filename().string()))
      std::filesystem::remove_all(entry.path(), ignored);
}

Json run_job(const BatchJob& job, const ChildLimits& limits, const std::string& rows) {
  const PrivateFolder folder(work_prefix(rows));
  const std::string file = folder / "result.json";
  std::vector<std::string> arguments = job.arguments;
  for (std::string& word : arguments)
    if (word == "{json}") word = file;
  const std::string inputs = inputs_hash(job);  // what changes while it runs is seen by the next batch
  const auto start = std::chrono::steady_clock::now();
  const ChildResult child = run_program(arguments, folder, limits);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  const std::string trouble = child.good() ? "" : child.trouble(limits);
  Json row;
  row["key"] = job.key;
  row["outcome"] = outcome_of(child, trouble);
  row["exit_code"] = child.exit_code;
  row["trouble"] = trouble;
  row["seconds"] = taken.count();
  row["inputs"] = inputs;
  row["result"] = read_result(file);
  return row;
}

/// Jobs that wait for their turn, the first one that may begin first. One thread at a time.
class Queue {
 public:
  explicit Queue(std::vector<const BatchJob*> jobs) : jobs_(std::move(jobs)) {}
  bool empty() const { return jobs_.empty(); }

  /// Null: every one waits for others that are under way.
  const BatchJob* take(const std::map<std::string, Json>& ended) {
    const auto may_begin = [&](const BatchJob* job) {
      return std::ranges::all_of(job->after, [&](const std::string& key) { return ended.contains(key); });
    };
    const auto job = std::ranges::find_if(jobs_, may_begin);
    if (job == jobs_.end()) return nullptr;
    const BatchJob* const taken = *job;
    jobs_.erase(job);
    return taken;
  }

 private:
  std::vector<const BatchJob*> jobs_;
};

}  // namespace

std::vector<Json> read_batch(const std::string& file) {
  std::uintmax_t bytes = 0;
  return read_rows(file, bytes);
}

std::vector<Json> run_batch(const std::vector<BatchJob>& jobs, const BatchOptions& options) {
  if (options.resume) fit_rows(options.file, jobs);
  RowFile out(options.file);
  std::map<std::string, Json> rows;
  std::uintmax_t kept = 0;
  if (options.resume)
    for (const Json& row : read_rows(options.file, kept)) rows[row["key"].get<std::string>()] = row;
  out.cut(kept);
  remove_leftovers(options.file);

  std::vector<const BatchJob*> left;
  std::set<std::string> seen;
  for (const BatchJob& job : jobs) {
    for (const std::string& key : job.after)
      if (!seen.contains(key)) throw InputError(text(job.key, ": waits for ", key, ", which does not come before it"));
    if (!seen.insert(job.key).second) throw InputError(text("two jobs of one name: ", job.key));
    if (!rows.contains(job.key)) left.push_back(&job);
  }
  const std::size_t all = left.size();

  std::mutex mutex;
  std::condition_variable ended;
  Queue queue(std::move(left));
  std::size_t done = 0;
  std::exception_ptr failure;
  const auto is_stopped = [&] { return options.limits.stop && options.limits.stop->load(); };
  bool is_over = false;  // stopped, or a row could not be kept
  const auto work = [&] {
    std::unique_lock lock(mutex);
    for (;;) {
      const BatchJob* job = nullptr;
      ended.wait(lock, [&] { return is_over || is_stopped() || queue.empty() || (job = queue.take(rows)); });
      if (!job) return;
      lock.unlock();
      try {
        Json row = run_job(*job, options.limits, options.file);
        lock.lock();
        out.append(row);
        rows[job->key] = std::move(row);
        if (options.progress) options.progress(static_cast<double>(++done) / static_cast<double>(all));
      } catch (...) {
        if (!lock) lock.lock();
        if (!is_stopped() && !failure) failure = std::current_exception();
        is_over = true;
      }
      ended.notify_all();
    }
  };
  std::vector<std::jthread> workers;
  for (int i = 0; i < std::max(1, options.jobs); ++i) workers.emplace_back(work);
  workers.clear();  // waits
  if (failure) std::rethrow_exception(failure);

  std::vector<Json> ordered;
  for (const BatchJob& job : jobs)
    if (const auto row = rows.find(job.key); row != rows.end()) ordered.push_back(row->second);
  return ordered;
}

}  // namespace kt
