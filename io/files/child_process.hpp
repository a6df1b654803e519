#pragma once
// Work that may crash, abort or never end runs in a child process: third-party mesh generators do all three on bad
// surfaces. The child has limits on memory, processor time and wall-clock time, a private folder that is removed
// afterwards, and dies with its parent.
#include <atomic>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "io/files/leftovers.hpp"

namespace kt {

struct ChildLimits {
  double seconds = 60;                              ///< wall clock, and of processor time
  std::size_t memory_bytes = std::size_t{4} << 30;  ///< address space
  const std::atomic<bool>* stop = nullptr;          ///< when set and true: the child is ended, ChildStopped
};

/// The child was ended because somebody asked for it: nothing else is to be tried in its place.
class ChildStopped : public RunError {
 public:
  ChildStopped() : RunError("interrupted") {}
};

/// While it lives, what this thread has done by children ends when the flag is set, as by ChildLimits::stop.
class StopsChildren {
 public:
  explicit StopsChildren(const std::atomic<bool>& stop);
  ~StopsChildren();
  StopsChildren(const StopsChildren&) = delete;
  StopsChildren& operator=(const StopsChildren&) = delete;

 private:
  const std::atomic<bool>* before_;
};

struct ChildResult {
  bool timed_out = false;
  int exit_code = 0;   ///< when signal is 0
  int signal = 0;      ///< that ended it
  std::string output;  ///< last 4 kB of its standard output and error
  bool good() const { return !timed_out && signal == 0 && exit_code == 0; }
  /// "ran longer than 60 s", "crashed (SIGSEGV)", "ended with exit code 3" plus its last words on one line.
  std::string trouble(const ChildLimits& limits) const;
};

/// A child that was killed from outside (SIGKILL): by a person, a batch system, the kernel for lack of memory. No
/// std::runtime_error: who has another way to go when a library fails must not take this for its failure.
class ChildKilled : public std::exception {
 public:
  explicit ChildKilled(const std::string& what)
      : what_(what + " was killed (SIGKILL), from outside or by the system") {}
  const char* what() const noexcept override { return what_.c_str(); }

 private:
  std::string what_;
};

/// @throws RunError "`what` crashed (...)`hint`" for a child that is not good, ChildKilled for one that was killed
void require_good(const ChildResult& run, const std::string& what, const ChildLimits& limits,
                  const std::string& hint = {});

/// A folder that only this user can read; removed with all it holds at the end.
class PrivateFolder {
 public:
  PrivateFolder();  ///< under the system's temporary folder. @throws RunError when it cannot be made
  /// @param prefix  path that its name begins with
  explicit PrivateFolder(const std::string& prefix);
  std::string operator/(const std::string& name) const { return path() + "/" + name; }
  const std::string& path() const { return folder_.path(); }

 private:
  Leftover folder_;
};

/// Runs a program (found on PATH) in `folder` and waits for it. A program that is not there: exit code 127.
ChildResult run_program(const std::vector<std::string>& arguments, const PrivateFolder& folder,
                        const ChildLimits& limits);

/// Runs `work` in a forked copy of this process; what it makes it leaves as files in `folder`. An exception ends the
/// child with exit code 3 and its text as the output. `work` must not rely on this process's other threads.
ChildResult run_forked(const std::function<void()>& work, const PrivateFolder& folder, const ChildLimits& limits);

}  // namespace kt
