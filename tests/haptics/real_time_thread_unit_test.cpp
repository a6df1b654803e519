// What a thread may have, and what is said where it may not. Rights are those of the machine: granted or not, it says
// which.
#include "apps/console/allocation_counter.hpp"
#include "haptics/machine/real_time_thread.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <thread>

namespace kt {
namespace {

TEST(RealTimeLimits, ReadCapabilities) {
  const std::string all = "Name:\tx\nCapPrm:\t0\nCapEff:\t000001ffffffffff\nSeccomp:\t0\n";
  EXPECT_TRUE(has_capability(all, 14));  // CAP_IPC_LOCK
  EXPECT_TRUE(has_capability(all, 23));  // CAP_SYS_NICE
  EXPECT_TRUE(has_capability("CapEff:\t0000000000800000\n", 23));
  EXPECT_FALSE(has_capability("CapEff:\t0000000000800000\n", 14));
  EXPECT_FALSE(has_capability("CapEff:\t0000000000000000\n", 23));
  EXPECT_FALSE(has_capability("", 23));
}

TEST(RealTimeLimits, SayWhyAndWhatGrants) {
  RealTimeLimits none{.most_priority = 0, .most_locked = 8 << 20, .mapped = 1 << 28, .memory = 1LL << 33};
  EXPECT_NE(why_no_priority(none).find("rtprio"), std::string::npos);
  EXPECT_NE(why_no_lock(none).find("8192 kB"), std::string::npos);
  EXPECT_NE(why_no_lock(none).find("memlock unlimited"), std::string::npos);
  none.most_priority = 95;
  none.most_locked = -1;
  EXPECT_EQ(why_no_priority(none), "");
  EXPECT_EQ(why_no_lock(none), "");
  none.mapped = 5LL << 30;
  EXPECT_NE(why_no_lock(none).find("half"), std::string::npos)
      << "a process that maps most of the memory is left alone";
  RealTimeLimits root{.may_schedule = true, .may_lock = true, .most_locked = 8 << 20, .mapped = 1, .memory = 1LL << 33};
  EXPECT_EQ(why_no_priority(root) + why_no_lock(root), "");
}

TEST(RealTimeThread, HasWhatItSaysOrSaysWhyNot) {
  RealTimeGrant grant;
  int policy = -1;
  std::thread([&] {
    RealTimeThread thread;
    sched_param param{};
    pthread_getschedparam(pthread_self(), &policy, &param);
    thread.start();
    thread.stop();
    grant = thread.grant();
  }).join();
  EXPECT_EQ(policy == SCHED_FIFO, grant.priority > 0);
  EXPECT_EQ(grant.scheduler(), policy == SCHED_FIFO ? "SCHED_FIFO" : "SCHED_OTHER");
  EXPECT_EQ(grant.why_not.size(), (grant.priority == 0) + (grant.locked ? 0u : 1u)) << grant.told();
  EXPECT_EQ(grant.page_faults, 0) << "nothing was done";
  EXPECT_NE(grant.told().find(grant.locked ? "memory locked" : "memory not locked"), std::string::npos);
  EXPECT_NE(grant.told().find("0 page faults"), std::string::npos);
}

/// Pages that nobody has touched yet, one fault each: known before.
TEST(RealTimeThread, CountsPageFaults) {
  constexpr std::size_t kPages = 64, kPage = 4096;
  RealTimeGrant grant;
  std::thread([&] {
    RealTimeThread thread({.locks_memory = false});
    void* memory = mmap(nullptr, kPages * kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    madvise(memory, kPages * kPage, MADV_NOHUGEPAGE);
    thread.start();
    for (std::size_t i = 0; i < kPages; ++i) static_cast<volatile char*>(memory)[i * kPage] = 1;
    thread.stop();
    munmap(memory, kPages * kPage);
    grant = thread.grant();
  }).join();
  EXPECT_GE(grant.page_faults, 64);
#ifdef __SANITIZE_THREAD__
  const int of_shadow = kPages + 1;  // a page of its own for each byte that was written
#else
  const int of_shadow = thread_allocations() < 0 ? 8 + 1 : 0;  // a sanitizer's, an eighth of the memory
#endif
  EXPECT_LE(grant.page_faults, 72 + of_shadow);
  EXPECT_EQ(grant.major_page_faults, 0);
}

TEST(RealTimeThread, StaysOnItsCoreAndNamesOneThatIsNotThere) {
  std::thread([] {
    cpu_set_t allowed;
    sched_getaffinity(0, sizeof allowed, &allowed);
    int core = 0;
    while (!CPU_ISSET(core, &allowed)) ++core;
    RealTimeThread thread({.locks_memory = false, .core = core});
    EXPECT_EQ(thread.grant().core, core);
    EXPECT_EQ(sched_getcpu(), core);
  }).join();
  std::thread([] {
    RealTimeThread thread({.locks_memory = false, .core = 1023});
    EXPECT_EQ(thread.grant().core, -1);
    EXPECT_NE(thread.grant().told().find("core 1023 is not granted"), std::string::npos);
  }).join();
}

}  // namespace
}  // namespace kt
