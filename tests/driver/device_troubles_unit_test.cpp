// What `kilotouch device test` says of what stands in the way: each cause once, and none that is not there.
#include "haptics/guard/device_troubles.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

DeviceTest good() {
  DeviceTest out;
  out.ticks = 10000;
  out.there = 10;
  out.readings_per_s = 1000;
  out.lateness.assign(100, 1e-5);
  out.deepest = 5e-3;
  out.ripple = 0.01;
  out.safety.most_force = 1;
  return out;
}

std::string all(const DeviceTest& t) {
  std::string out;
  for (const std::string& one : lines(find_troubles("haply", {}, t, 1000))) out += one + "\n";
  return out;
}

void shut(DeviceTest& t, GateReason reason, int ticks, bool is_last) {
  t.safety.by_reason[static_cast<std::size_t>(reason)] = ticks;
  if (is_last) t.gate = reason;
}

TEST(DeviceTroubles, AGoodDeviceHasNone) {
  DeviceTest t = good();
  shut(t, GateReason::no_model, 50, false);
  EXPECT_EQ(all(t), "");
}

TEST(DeviceTroubles, ADeviceThatWasGoneForThreeSecondsWasGone) {
  DeviceTest t = good();
  shut(t, GateReason::gone, 3000, false);
  t.there = 7;
  EXPECT_EQ(all(t),
            "no force at times, for 3 s: the device is gone; see to its cable, its power, and the maker's service\n");
}

TEST(DeviceTroubles, AnUncalibratedDeviceIsNotToBePressedDown) {
  DeviceTest t = good();
  shut(t, GateReason::uncalibrated, 10000, true);
  t.there = t.deepest = t.readings_per_s = 0;
  EXPECT_EQ(all(t),
            "no force at the end, for 10 s: the device is not calibrated; put its grip on the inkwell and wait until "
            "its light is steady\n");
}

TEST(DeviceTroubles, WhatTheServiceMakesSmallerIsTold) {
  DeviceTest t = good();
  t.safety.most_echoed = 0.5;
  EXPECT_EQ(all(t), "of a force of 1 N the service repeats 0.5 N: something on the way makes it smaller\n");
  t.safety.most_echoed = 0.99;
  EXPECT_EQ(all(t), "");
}

TEST(DeviceTroubles, EachReasonThatIsNotThePersonsHasAName) {
  for (std::size_t i = 0; i < kGateReasons; ++i) EXPECT_STRNE(name_of(static_cast<GateReason>(i)), "") << i;
}

}  // namespace
}  // namespace kt
