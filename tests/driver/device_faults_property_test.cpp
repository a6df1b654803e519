// What a device gets when something breaks under the hand: finite, within its limit, and zero in time. The table of all
// figures: bench/device_fault_table.cpp.
#include <gtest/gtest.h>

#include "tests/fakes/fault_run.hpp"

namespace kt {
namespace {

using fake::FaultCase;
using fake::Ours;

class DeviceFault : public testing::TestWithParam<std::tuple<std::string, FaultCase>> {};
INSTANTIATE_TEST_SUITE_P(All, DeviceFault,
                         testing::Combine(testing::Values("openhaptics", "forcedimension"),
                                          testing::ValuesIn(fake::kFaultCases)),
                         [](const auto& of) {
                           std::string name = std::get<0>(of.param) + "_" + std::get<1>(of.param).name;
                           std::ranges::replace(name, ' ', '_');
                           return name;
                         });

TEST_P(DeviceFault, LeavesTheHandInPeace) {
  const auto [backend, c] = GetParam();
  const fake::FaultResult r = fake::run_fault(backend, c, {.before = 0, .fault = 0.05, .force = 0.2});
  EXPECT_TRUE(r.was_finite);
  EXPECT_GT(r.most_force, 0.2) << "or nothing was tried";
  EXPECT_LE(r.most_force, 3) << "the chain's limit for a device whose user names none";
  EXPECT_TRUE(r.were_zeros_last);
  EXPECT_EQ(std::isfinite(r.back_ms), c.ours != Ours::closed) << "it works again";
  if (!c.shuts_for(backend)) return;
  // A silent device holds what it has, and another program's work delays everybody; a period and a tick to spare.
  const double noticed = c.fault == fake::Fault::uncalibrated ? 10 : 0;  // it is not asked for in every period
  EXPECT_LE(r.zero_ms, noticed + SafetyChain::kZeroWithin * 1e3 + r.late_ms + r.silent_ms + 2);
}

}  // namespace
}  // namespace kt
