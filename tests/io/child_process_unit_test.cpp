#include "io/files/child_process.hpp"

#include <signal.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

TEST(ChildProcess, ReturnsExitCodeAndBothOutputs) {
  const PrivateFolder folder;
  const ChildResult r = run_program({"sh", "-c", "echo out; echo err >&2; exit 3"}, folder, {});
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_FALSE(r.good());
  EXPECT_EQ(r.output, "out\nerr\n");
  EXPECT_EQ(r.trouble({}), "ended with exit code 3: out err");
}

TEST(ChildProcess, AMissingProgramIs127) {
  const PrivateFolder folder;
  EXPECT_EQ(run_program({"no-such-program-here"}, folder, {}).exit_code, 127);
}

TEST(ChildProcess, AnEndlessOneIsKilledWithItsChildren) {
  const PrivateFolder folder;
  const ChildResult r = run_program({"sh", "-c", "sleep 1000 & echo $! > pid; wait"}, folder, {.seconds = 0.3});
  EXPECT_TRUE(r.timed_out);
  EXPECT_EQ(r.trouble({.seconds = 0.3}), "ran longer than 0.3 s");
  int pid = 0;
  std::ifstream(folder / "pid") >> pid;
  ASSERT_GT(pid, 0);
  for (int i = 0; i < 100 && ::kill(pid, 0) == 0; ++i) {  // gone, or a zombie that init has not yet collected
    std::string word, state;
    std::ifstream status(text("/proc/", pid, "/status"));
    while (status >> word && word != "State:") {
    }
    status >> state;
    if (state == "Z" || state.empty()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_NE(::kill(pid, 0), 0);
}

TEST(ChildProcess, ACrashIsNamed) {
  const PrivateFolder folder;
  const ChildResult r = run_forked([] { ::raise(SIGSEGV); }, folder, {});
  EXPECT_EQ(r.signal, SIGSEGV);
  EXPECT_NE(r.trouble({}).find("crashed (Segmentation fault)"), std::string::npos);
}

TEST(ChildProcess, TheWordsOfTheRuntimeAreDropped) {
  const PrivateFolder folder;
  const std::string words =
      "echo reading; echo \"terminate called after throwing an instance of 'std::bad_alloc'\"; echo '  what():  "
      "std::bad_alloc'; kill -SEGV $$";
  EXPECT_EQ(run_program({"sh", "-c", words}, folder, {}).trouble({}), "crashed (Segmentation fault): reading");
}

TEST(ChildProcess, SignalsThatTheParentBlocksReachTheChild) {
  const PrivateFolder folder;
  sigset_t signals, before;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGTERM);
  ::pthread_sigmask(SIG_BLOCK, &signals, &before);
  const ChildResult r = run_program({"sh", "-c", "kill -TERM $$; exit 0"}, folder, {});
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  EXPECT_EQ(r.signal, SIGTERM);
}

TEST(ChildProcess, ItsTemporaryFilesGoWithItsFolder) {
  const PrivateFolder folder;
  EXPECT_EQ(run_program({"sh", "-c", "printf '%s' \"$TMPDIR\""}, folder, {}).output, folder.path());
}

TEST(ChildProcess, AnExceptionComesBackAsText) {
  const PrivateFolder folder;
  const ChildResult r = run_forked([] { throw InputError("bad\nsurface"); }, folder, {});
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_EQ(r.trouble({}), "ended with exit code 3: bad surface");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(ChildProcess, MemoryIsLimited) {
  const PrivateFolder folder;
  const ChildResult r = run_forked([] { const std::string big(std::size_t{3} << 30, 'x'); }, folder,
                                   {.memory_bytes = std::size_t{2} << 30});
  EXPECT_FALSE(r.good());
}
#endif

TEST(ChildProcess, StopEndsIt) {
  const PrivateFolder folder;
  const std::atomic<bool> stop{true};
  EXPECT_THROW(run_program({"sleep", "1000"}, folder, {.seconds = 900, .stop = &stop}), RunError);
}

TEST(ChildProcess, AFlagOfTheThreadEndsItToo) {
  const PrivateFolder folder;
  const std::atomic<bool> stop{true}, go_on{false};
  {
    const StopsChildren stops(stop);
    EXPECT_THROW(run_program({"sleep", "1000"}, folder, {.seconds = 900}), ChildStopped);
    const StopsChildren inner(go_on);
    EXPECT_TRUE(run_program({"true"}, folder, {}).good());
  }
  EXPECT_TRUE(run_program({"true"}, folder, {}).good());
}

TEST(PrivateFolder, IsRemovedWithAllItHolds) {
  std::string path;
  {
    const PrivateFolder folder;
    path = folder.path();
    write_sample(folder, "a.txt", "a");
    EXPECT_EQ(std::filesystem::status(path).permissions(), std::filesystem::perms::owner_all);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace kt
