// What stands in the way of ticks on time: from files as real machines have them.
#include "haptics/machine/machine_test.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"

namespace kt {
namespace {

const std::string kLimits =
    "Limit                     Soft Limit           Hard Limit           Units     \n"
    "Max locked memory         8388608              8388608              bytes     \n"
    "Max realtime priority     0                    0                    \n";

/// A laptop as it comes from the shop.
MachineFiles laptop() {
  return {{"/proc/cpuinfo", "processor\t: 0\nflags\t\t: fpu vme ht\nprocessor\t: 1\nprocessor\t: 2\nprocessor\t: 3\n"},
          {"/proc/version",
           "Linux version 6.1.0-18-amd64 (debian-kernel@lists.debian.org) #1 SMP PREEMPT_DYNAMIC Debian 6.1.76\n"},
          {"/proc/self/limits", kLimits},
          {"/proc/self/status", "Name:\tx\nCapEff:\t0000000000000000\n"},
          {"/proc/1/cgroup", "0::/init.scope\n"},
          {"/proc/sys/kernel/sched_rt_runtime_us", "950000\n"},
          {"/proc/sys/kernel/sched_rt_period_us", "1000000\n"},
          {"/sys/devices/system/cpu/smt/active", "1\n"},
          {"/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n"},
          {"/sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n"},
          {"/sys/devices/system/cpu/cpu2/cpufreq/scaling_governor", "powersave\n"},
          {"/sys/devices/system/cpu/cpu0/cpuidle/state1/latency", "2\n"},
          {"/sys/devices/system/cpu/cpu0/cpuidle/state1/name", "C1\n"},
          {"/sys/devices/system/cpu/cpu0/cpuidle/state3/latency", "133\n"},
          {"/sys/devices/system/cpu/cpu0/cpuidle/state3/name", "C6\n"},
          {"/sys/devices/system/cpu/cpu0/cpuidle/state3/disable", "0\n"},
          {"/sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n"}};
}

/// The same, as it is to be.
MachineFiles set_up() {
  MachineFiles out = laptop();
  out["/proc/version"] = "Linux version 6.1.0-18-rt-amd64 (x) #1 SMP PREEMPT_RT Debian 6.1.76\n";
  out["/sys/kernel/realtime"] = "1\n";
  out["/proc/self/limits"] =
      "Max locked memory         unlimited            unlimited            bytes     \n"
      "Max realtime priority     95                   95                   \n";
  out["/sys/devices/system/cpu/smt/active"] = "0\n";
  for (const char* cpu : {"cpu0", "cpu2"})
    out[std::string("/sys/devices/system/cpu/") + cpu + "/cpufreq/scaling_governor"] = "performance\n";
  out["/sys/devices/system/cpu/cpu0/cpuidle/state3/disable"] = "1\n";
  out["/sys/devices/system/clocksource/clocksource0/current_clocksource"] = "tsc\n";
  return out;
}

const MachineFinding* of(const std::vector<MachineFinding>& all, const std::string& where) {
  for (const MachineFinding& f : all)
    if (f.where == where) return &f;
  return nullptr;
}

TEST(MachineFindings, NameFileValueAndCureOfEachThingInTheWay) {
  const auto found = find_hindrances(laptop());
  struct Row {
    std::string where, value, cure;
  };
  for (const Row& row :
       {Row{"/proc/version", "Linux version 6.1.0-18-amd64, PREEMPT_DYNAMIC", "linux-image-rt-amd64"},
        Row{"/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave (2 of 3 cores)", "cpupower"},
        Row{"/sys/devices/system/cpu/cpu0/cpuidle/state3/latency", "C6, 133 us", "max_cstate"},
        Row{"/sys/devices/system/cpu/smt/active", "1", "smt/control"},
        Row{"/sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet", "clocksource=tsc"}}) {
    const MachineFinding* f = of(found, row.where);
    ASSERT_NE(f, nullptr) << row.where;
    EXPECT_EQ(f->value, row.value);
    EXPECT_NE(f->cure.find(row.cure), std::string::npos) << f->cure;
  }
  EXPECT_EQ(found[0].value, "Max realtime priority 0");
  EXPECT_NE(found[0].cure.find("rtprio 95"), std::string::npos);
  EXPECT_EQ(found[1].value, "Max locked memory 8388608 bytes");
  EXPECT_NE(found[1].cure.find("memlock unlimited"), std::string::npos);
  EXPECT_EQ(found.size(), 7u);
  for (const MachineFinding& f : found) EXPECT_FALSE(f.what.empty() || f.cure.empty()) << f.where;
}

TEST(MachineFindings, AreNoneOfAMachineThatIsSetUpAndOfFilesThatAreNotThere) {
  for (const MachineFinding& f : find_hindrances(set_up())) ADD_FAILURE() << f.where << ": " << f.value;
  EXPECT_TRUE(find_hindrances({}).empty());
  for (const auto& [path, content] : laptop()) {
    MachineFiles files = laptop();
    files.erase(path);
    find_hindrances(files);
    files[path] = "";
    find_hindrances(files);
  }
}

TEST(MachineFindings, RightsStandForLimits) {
  MachineFiles files = set_up();
  files["/proc/self/limits"] = kLimits;
  files["/proc/self/status"] = "CapEff:\t0000000000804000\n";  // CAP_SYS_NICE and CAP_IPC_LOCK
  EXPECT_TRUE(find_hindrances(files).empty());
}

TEST(MachineFindings, KnowVirtualMachinesContainersFewCoresAndThrottling) {
  MachineFiles files = set_up();
  files["/proc/cpuinfo"] =
      "processor\t: 0\nflags\t\t: fpu hypervisor lahf_lm\nprocessor\t: 1\nflags\t\t: fpu hypervisor\n";
  files["/.dockerenv"] = "";
  files["/proc/sys/kernel/sched_rt_runtime_us"] = "500000\n";
  auto found = find_hindrances(files);
  ASSERT_EQ(found.size(), 4u);
  EXPECT_NE(of(found, "/.dockerenv")->cure.find("--cap-add SYS_NICE"), std::string::npos);
  EXPECT_NE(of(found, "/proc/sys/kernel/sched_rt_runtime_us")->cure.find("sysctl"), std::string::npos);
  files.erase("/.dockerenv");
  files["/proc/1/cgroup"] = "0::/kubepods/besteffort/pod1\n";
  files["/proc/sys/kernel/sched_rt_runtime_us"] = "-1\n";
  found = find_hindrances(files);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(of(found, "/proc/1/cgroup")->value, "kubepods");
}

TEST(WakeUps, AreJudgedByThePeriod) {
  std::vector<double> late(10000, 5.0);
  EXPECT_EQ(judge_wake_ups(8000, late).kept, RateKept::yes);
  for (int i = 0; i < 20; ++i) late[static_cast<std::size_t>(i)] = 60;  // 2 of 1000
  EXPECT_EQ(judge_wake_ups(8000, late).kept, RateKept::just_about);     // of 125 us
  EXPECT_EQ(judge_wake_ups(4000, late).kept, RateKept::yes);
  for (int i = 0; i < 20; ++i) late[static_cast<std::size_t>(i)] = 200;
  const WakeUps w = judge_wake_ups(8000, late);
  EXPECT_EQ(w.kept, RateKept::no);
  EXPECT_EQ(w.over_period, 20);
  EXPECT_EQ(w.max_us, 200);
  EXPECT_EQ(w.p50_us, 5);
  EXPECT_EQ(w.count, 10000);
  std::vector<double> once(10000, 5.0);
  once[77] = 1500;  // one in ten thousand, but a whole period
  EXPECT_EQ(judge_wake_ups(1000, once).kept, RateKept::just_about);
  EXPECT_EQ(judge_wake_ups(1000, {}).kept, RateKept::no);
}

TEST(MachineTest, CountsWhatWasAskedFor) {
  const MachineReport r = test_machine({.rates_hz = {1000, 8000}, .seconds = 0.05});
  ASSERT_EQ(r.rates.size(), 2u);
  EXPECT_EQ(r.rates[0].count, 50);
  EXPECT_EQ(r.rates[1].count, 400);
  for (const WakeUps& w : r.rates) {
    EXPECT_GE(w.p50_us, 0);
    EXPECT_LE(w.p50_us, w.p99_us);
    EXPECT_LE(w.p99_us, w.p999_us);
    EXPECT_LE(w.p999_us, w.max_us);
  }
  EXPECT_THROW(test_machine({.rates_hz = {0}}), InputError);
  EXPECT_THROW(test_machine({.seconds = 0}), InputError);
  std::atomic<bool> stop{true};
  EXPECT_TRUE(test_machine({.stop = &stop}).rates.empty());
}

}  // namespace
}  // namespace kt
