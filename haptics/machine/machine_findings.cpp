#include "haptics/machine/machine_findings.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "haptics/machine/real_time_thread.hpp"

namespace kt {
namespace {

constexpr const char* kCpu = "/sys/devices/system/cpu/";
constexpr int kIpcLock = 14, kSysNice = 23;  // capabilities, linux/capability.h

std::string bare(const std::string& s) {
  const std::size_t begin = s.find_first_not_of(" \t\n"), end = s.find_last_not_of(" \t\n");
  return begin == std::string::npos ? std::string() : s.substr(begin, end - begin + 1);
}

std::optional<std::string> content(const MachineFiles& files, const std::string& path) {
  const auto at = files.find(path);
  if (at == files.end()) return {};
  return bare(at->second);
}

/// The rest of the line that begins so; nothing: there is none.
std::optional<std::string> line_of(const MachineFiles& files, const std::string& path, const std::string& begin) {
  std::istringstream in(content(files, path).value_or(""));
  for (std::string line; std::getline(in, line);)
    if (line.rfind(begin, 0) == 0) return bare(line.substr(begin.size()));
  return {};
}

std::string first_word(const std::string& s) { return s.substr(0, s.find_first_of(" \t\n")); }

using Findings = std::vector<MachineFinding>;

void find_no_priority(const MachineFiles& files, Findings& out) {
  if (has_capability(content(files, "/proc/self/status").value_or(""), kSysNice)) return;
  const auto limit = line_of(files, "/proc/self/limits", "Max realtime priority");
  if (!limit || first_word(*limit) != "0") return;
  out.push_back(
      {"ticks run as an ordinary thread: other programs go first whenever they want to", "/proc/self/limits",
       "Max realtime priority 0",
       "sudo groupadd -f realtime; sudo usermod -aG realtime $USER; put the line \"@realtime - rtprio 95\" into "
       "/etc/security/limits.d/99-realtime.conf; log in again (check: ulimit -r)"});
}

void find_no_locking(const MachineFiles& files, Findings& out) {
  if (has_capability(content(files, "/proc/self/status").value_or(""), kIpcLock)) return;
  const auto limit = line_of(files, "/proc/self/limits", "Max locked memory");
  if (!limit || first_word(*limit) == "unlimited") return;
  out.push_back({"memory cannot be locked: a tick may wait for a page", "/proc/self/limits",
                 text("Max locked memory ", first_word(*limit), " bytes"),
                 "put the line \"@realtime - memlock unlimited\" into /etc/security/limits.d/99-realtime.conf, with "
                 "yourself in the group realtime; log in again (check: ulimit -l)"});
}

void find_throttling(const MachineFiles& files, Findings& out) {
  const std::string path = "/proc/sys/kernel/sched_rt_runtime_us";
  const auto runtime = content(files, path);
  if (!runtime || runtime->empty()) return;
  constexpr double kEnough = 0.9;  // of the time; the usual setting is 0.95
  const double period = leading_number(content(files, "/proc/sys/kernel/sched_rt_period_us").value_or("1000000"));
  const double share = leading_number(*runtime);
  if (share < 0 || share >= kEnough * period) return;
  out.push_back({text("real-time threads are stopped after ", share, " of each ", period, " us"), path, *runtime,
                 "sudo sysctl -w kernel.sched_rt_runtime_us=950000; for good: the line "
                 "\"kernel.sched_rt_runtime_us = 950000\" in /etc/sysctl.d/99-realtime.conf"});
}

void find_slow_clock(const MachineFiles& files, Findings& out) {
  std::string first, value;
  int cores = 0, slow = 0;
  for (const auto& [path, word] : files) {
    if (path.rfind(kCpu, 0) != 0 || !path.ends_with("/cpufreq/scaling_governor")) continue;
    ++cores;
    if (bare(word) == "performance") continue;
    if (slow++ == 0) {
      first = path;
      value = bare(word);
    }
  }
  if (slow > 0)
    out.push_back(
        {"the processor's clock falls when it has little to do, and rises too late for a tick", first,
         text(value, " (", slow, " of ", cores, " cores)"),
         "sudo cpupower frequency-set -g performance (package linux-cpupower), or: echo performance | sudo tee "
         "/sys/devices/system/cpu/cpu*/cpufreq/scaling_governor; until the next start"});
}

void find_deep_sleep(const MachineFiles& files, Findings& out) {
  constexpr double kSoon = 30;  // [us] from which on waking up takes a good part of the period at 8 kHz
  double longest = kSoon;
  std::string where, name;
  for (const auto& [path, word] : files) {
    if (path.rfind(std::string(kCpu) + "cpu0/cpuidle/", 0) != 0 || !path.ends_with("/latency")) continue;
    const std::string state = path.substr(0, path.size() - std::string("latency").size());
    if (leading_number(word) <= longest || content(files, state + "disable").value_or("0") == "1") continue;
    longest = leading_number(word);
    where = path;
    name = content(files, state + "name").value_or("?");
  }
  if (!where.empty())
    out.push_back(
        {text("an idle core sleeps so deeply that it takes ", longest, " us to wake up"), where,
         text(name, ", ", longest, " us"),
         text("sudo cpupower idle-set -D ", kSoon,
              " (package linux-cpupower), until the next start; for good: "
              "the kernel parameters \"intel_idle.max_cstate=1 processor.max_cstate=1\" in GRUB_CMDLINE_LINUX of "
              "/etc/default/grub, then sudo update-grub")});
}

void find_usual_kernel(const MachineFiles& files, Findings& out) {
  const auto version = content(files, "/proc/version");
  if (!version || content(files, "/sys/kernel/realtime").value_or("0") == "1") return;
  if (version->find("PREEMPT_RT") != std::string::npos || version->find("PREEMPT RT") != std::string::npos) return;
  const std::size_t at = version->find("PREEMPT");
  out.push_back(
      {"the kernel is none for real time: its own work can hold a tick up", "/proc/version",
       text(version->substr(0, version->find(" (")), ", ",
            at == std::string::npos ? std::string("no PREEMPT") : first_word(version->substr(at))),
       "Debian: sudo apt install linux-image-rt-amd64; Ubuntu: sudo pro enable realtime-kernel; then start that "
       "kernel (check: uname -v says PREEMPT_RT)"});
}

void find_virtual_machine(const MachineFiles& files, Findings& out) {
  const auto flags = line_of(files, "/proc/cpuinfo", "flags");
  if (!flags || (" " + *flags + " ").find(" hypervisor ") == std::string::npos) return;
  out.push_back({"this is a virtual machine: its host takes the processor away when it likes", "/proc/cpuinfo",
                 "flags: hypervisor", "run it on the computer itself that the device is plugged into"});
}

void find_container(const MachineFiles& files, Findings& out) {
  std::string where, value = "is there";
  for (const char* path : {"/.dockerenv", "/run/.containerenv"})
    if (files.count(path) > 0) where = path;
  const auto cgroup = content(files, "/proc/1/cgroup");
  for (const char* name : {"docker", "kubepods", "lxc", "containerd"})
    if (where.empty() && cgroup && cgroup->find(name) != std::string::npos) {
      where = "/proc/1/cgroup";
      value = name;
    }
  if (where.empty()) return;
  out.push_back({"this is a container: rights and cores are what it was given", where, value,
                 "docker run --cap-add SYS_NICE --cap-add IPC_LOCK --ulimit rtprio=95 --ulimit memlock=-1 ..."});
}

void find_few_cores(const MachineFiles& files, Findings& out) {
  const auto cpuinfo = content(files, "/proc/cpuinfo");
  if (!cpuinfo) return;
  int cores = 0;
  std::istringstream in(*cpuinfo);
  for (std::string line; std::getline(in, line);) cores += line.rfind("processor", 0) == 0;
  if (cores == 0 || cores > 2) return;
  out.push_back({cores == 1 ? "ticks and the body share the only core"
                            : "there are two cores: one for ticks, one for the "
                              "body and all other programs",
                 "/proc/cpuinfo", text("processors: ", cores), "a computer with four cores or more"});
}

void find_shared_cores(const MachineFiles& files, Findings& out) {
  const std::string path = std::string(kCpu) + "smt/active";
  if (content(files, path).value_or("0") != "1") return;
  out.push_back({"two threads share each core: a tick takes longer while its neighbour works", path, "1",
                 "echo off | sudo tee /sys/devices/system/cpu/smt/control; until the next start"});
}

void find_slow_time(const MachineFiles& files, Findings& out) {
  const std::string path = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  const auto clock = content(files, path);
  if (!clock || (*clock != "hpet" && *clock != "acpi_pm" && *clock != "jiffies" && *clock != "refined-jiffies")) return;
  out.push_back({"asking for the time goes to a slow chip and takes microseconds", path, *clock,
                 "the kernel parameter \"clocksource=tsc\" in GRUB_CMDLINE_LINUX of /etc/default/grub, then sudo "
                 "update-grub, where the processor has a steady clock"});
}

}  // namespace

std::vector<MachineFinding> find_hindrances(const MachineFiles& files) {
  Findings out;
  for (const auto& look :
       {find_no_priority, find_no_locking, find_throttling, find_slow_clock, find_deep_sleep, find_usual_kernel,
        find_virtual_machine, find_container, find_few_cores, find_shared_cores, find_slow_time})
    look(files, out);
  return out;
}

MachineFiles read_machine_files() {
  namespace fs = std::filesystem;
  MachineFiles out;
  const auto read = [&](const std::string& path) {
    std::ifstream in(path);
    if (in) out[path] = {std::istreambuf_iterator<char>(in), {}};
  };
  for (const char* path :
       {"/proc/cpuinfo", "/proc/version", "/proc/self/limits", "/proc/self/status", "/proc/1/cgroup",
        "/proc/sys/kernel/sched_rt_runtime_us", "/proc/sys/kernel/sched_rt_period_us", "/sys/kernel/realtime",
        "/sys/devices/system/clocksource/clocksource0/current_clocksource", "/.dockerenv", "/run/.containerenv"})
    read(path);
  read(std::string(kCpu) + "smt/active");
  std::error_code none;
  for (const auto& core : fs::directory_iterator(kCpu, none)) read(core.path().string() + "/cpufreq/scaling_governor");
  for (const auto& state : fs::directory_iterator(std::string(kCpu) + "cpu0/cpuidle", none))
    for (const char* name : {"/latency", "/name", "/disable"}) read(state.path().string() + name);
  return out;
}

}  // namespace kt
