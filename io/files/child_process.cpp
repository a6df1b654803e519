#include "io/files/child_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <locale>
#include <string_view>
#include <thread>
#include <utility>

#include "core/base/temporary_folder.hpp"

namespace kt {
namespace {

constexpr const char* kLog = "child.log";

thread_local const std::atomic<bool>* stop_of_thread = nullptr;

bool is_stopped(const ChildLimits& limits) {
  return (limits.stop && limits.stop->load()) || (stop_of_thread && stop_of_thread->load());
}

void set_limit(decltype(RLIMIT_AS) what, rlim_t soft, rlim_t hard) {
  const rlimit limit{soft, hard};
  ::setrlimit(what, &limit);
}

/// First thing in the child: own process group, dies with the parent, limits, output into the log file.
void enter_child(const std::string& log, [[maybe_unused]] const ChildLimits& limits, pid_t parent) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(126);  // the parent died before the line above
  for (const int s : {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL})
    ::signal(s, SIG_DFL);
  sigset_t none;  // the parent's threads may block some, and a child inherits that
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  // No RLIMIT_CPU: wait_for() watches the time, and under that limit Linux rounds the child's clock of CPU time, by
  // which the chart measures a refresh, to scheduler ticks (4 ms).
  set_limit(RLIMIT_CORE, 0, 0);
  set_limit(RLIMIT_FSIZE, rlim_t{2} << 30, rlim_t{2} << 30);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers reserve terabytes of address space
  set_limit(RLIMIT_AS, limits.memory_bytes, limits.memory_bytes);
#endif
  const int in = ::open("/dev/null", O_RDONLY);
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND, 0600);
  if (in >= 0) ::dup2(in, 0);
  if (out >= 0) {
    ::dup2(out, 1);
    ::dup2(out, 2);
  }
}

std::string tail_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return {};
  const std::streamoff size = in.tellg();
  const std::streamoff length = std::min<std::streamoff>(size, 4096);
  std::string out(static_cast<std::size_t>(length), '\0');
  in.seekg(size - length);
  in.read(out.data(), length);
  return out;
}

ChildResult wait_for(pid_t child, const std::string& log, const ChildLimits& limits) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(limits.seconds);
  const LiveChild alive(child);
  ChildResult result;
  int status = 0;
  auto pause = std::chrono::microseconds(500);
  for (;;) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child || (ended < 0 && errno != EINTR)) break;
    const bool stopped = is_stopped(limits);
    if (stopped || Clock::now() > deadline) {
      result.timed_out = !stopped;
      ::kill(-child, SIGKILL);
      ::kill(child, SIGKILL);  // in case it has not yet made its own group
      while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
      }
      if (stopped) throw ChildStopped();
      break;
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, std::chrono::microseconds(20000));
  }
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  result.output = tail_of(log);
  return result;
}

/// What the C++ runtime says when it gives up: it names a type, where a person needs a reason.
bool is_of_the_runtime(std::string_view line) {
  return line.starts_with("terminate called") || line.starts_with("  what():  std::") ||
         line.starts_with("pure virtual method called");
}

/// The last lines of a log on one line.
std::string last_words(const std::string& log) {
  std::string line;
  for (std::size_t at = 0; at < log.size();) {
    const std::size_t end = std::min(log.find('\n', at), log.size());
    const std::string_view words = std::string_view(log).substr(at, end - at);
    at = end + 1;
    if (is_of_the_runtime(words)) continue;
    for (const char c : words) line += c == '\t' ? ' ' : (c >= ' ' && c < 127) ? c : '?';
    line += ' ';
  }
  const std::size_t begin = line.find_first_not_of(' ');
  if (begin == std::string::npos) return {};
  line = line.substr(begin, line.find_last_not_of(' ') + 1 - begin);
  constexpr std::size_t kLongest = 300;
  return line.size() > kLongest ? "..." + line.substr(line.size() - kLongest) : line;
}

}  // namespace

StopsChildren::StopsChildren(const std::atomic<bool>& stop) : before_(std::exchange(stop_of_thread, &stop)) {}
StopsChildren::~StopsChildren() { stop_of_thread = before_; }

std::string ChildResult::trouble(const ChildLimits& limits) const {
  std::string out;
  if (timed_out) {
    out = text("ran longer than ", limits.seconds, " s");
  } else if (signal == SIGABRT && output.find("bad_alloc") != std::string::npos) {
    out = text("needed more than ", limits.memory_bytes >> 20, " MB of memory");
  } else if (signal != 0) {
    out = text("crashed (", ::strsignal(signal), ")");
  } else {
    out = text("ended with exit code ", exit_code);
  }
  const std::string words = last_words(output);
  return words.empty() ? out : out + ": " + words;
}

void require_good(const ChildResult& run, const std::string& what, const ChildLimits& limits, const std::string& hint) {
  if (run.signal == SIGKILL && !run.timed_out) throw ChildKilled(what);
  if (!run.good()) throw RunError(text(what, " ", run.trouble(limits), hint));
}

PrivateFolder::PrivateFolder() : PrivateFolder(temporary_folder() + "/kilotouch-") {}

namespace {

std::string make_private_folder(const std::string& prefix) {
  std::string name = prefix + "XXXXXX";
  if (!::mkdtemp(name.data()))
    throw RunError(text("cannot make a temporary folder ", name, ": ", std::strerror(errno)));
  return name;
}

}  // namespace

PrivateFolder::PrivateFolder(const std::string& prefix) : folder_([&] { return make_private_folder(prefix); }) {}

namespace {

/// As exec takes it; valid as long as the words.
std::vector<char*> pointers(const std::vector<std::string>& words) {
  std::vector<char*> out;
  for (const std::string& word : words) out.push_back(const_cast<char*>(word.c_str()));
  out.push_back(nullptr);
  return out;
}

/// This process's, but for the place of temporary files, as what a killed child leaves goes with its folder; and for
/// the locale: in another one TetGen takes 1,4 for a 1.
std::vector<std::string> child_environment(const PrivateFolder& folder) {
  std::vector<std::string> out{"TMPDIR=" + folder.path(), "LC_ALL=C"};
  for (char** entry = environ; *entry; ++entry) {
    const std::string_view one(*entry);
    if (!one.starts_with("TMPDIR=") && !one.starts_with("LC_") && !one.starts_with("LANG")) out.emplace_back(one);
  }
  return out;
}

}  // namespace

ChildResult run_program(const std::vector<std::string>& arguments, const PrivateFolder& folder,
                        const ChildLimits& limits) {
  const std::vector<char*> argv = pointers(arguments);
  const std::vector<std::string> environment = child_environment(folder);
  const std::vector<char*> envp = pointers(environment);
  const std::string log = folder / kLog;
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw RunError(text("cannot start ", arguments[0], ": ", std::strerror(errno)));
  if (child == 0) {
    enter_child(log, limits, parent);
    if (::chdir(folder.path().c_str()) == 0) ::execvpe(argv[0], argv.data(), envp.data());
    ::_exit(127);
  }
  return wait_for(child, log, limits);
}

ChildResult run_forked(const std::function<void()>& work, const PrivateFolder& folder, const ChildLimits& limits) {
  const std::string log = folder / kLog;
  std::fflush(nullptr);  // or the child would write our buffered text a second time
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) throw RunError(text("cannot start a child process: ", std::strerror(errno)));
  if (child == 0) {
    enter_child(log, limits, parent);
    int code = 0;
    try {
      std::setlocale(LC_ALL, "C");  // for Netgen's and CGAL's numbers
      std::locale::global(std::locale::classic());
      work();
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s\n", e.what());
      code = 3;
    } catch (...) {
      std::fprintf(stderr, "unknown exception\n");
      code = 3;
    }
    std::fflush(nullptr);
    ::_exit(code);  // no destructors and no atexit handlers of the parent's
  }
  return wait_for(child, log, limits);
}

}  // namespace kt
