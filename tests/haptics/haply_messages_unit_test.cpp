// Messages of the Inverse Service as its documentation shows them, old and new, cut short, and with what is no number.
#include "haptics/driver/haply_messages.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace kt {
namespace {

const char* const kInventory = R"({"session_id": 4,
  "inverse3": [
    {"device_id": "049D", "config": {"device_info": {"model": "Inverse3", "major_version": 3}},
     "state": {"cursor_position": {"x": 0.01, "y": -0.12, "z": 0.15}, "cursor_velocity": {"x": 0, "y": 0.5, "z": 0},
               "current_cursor_force": {"x": 0, "y": 0, "z": 1.25}, "control_mode": "idle"},
     "status": {"calibrated": true, "ready": true}},
    {"device_id": "0512", "state": {"cursor_position": {"x": 1, "y": 2, "z": 3}}, "status": {"calibrated": false}}],
  "wireless_verse_grip": [{"device_id": "61",
     "state": {"orientation": {"w": 0.5, "x": 0.5, "y": 0.5, "z": 0.5}, "buttons": {"a": true, "b": false, "c": true}}}],
  "unknown": {"deep": [1, 2]}})";

TEST(HaplyMessages, ReadsTheInventory) {
  const HaplyState s = read_haply_state(kInventory, "049D");
  EXPECT_EQ(s.devices, (std::vector<std::string>{"049D", "0512"}));
  EXPECT_EQ(s.models[0], "Inverse3");
  EXPECT_TRUE(s.is_calibrated);
  ASSERT_TRUE(s.x && s.v && s.force && s.turn);
  EXPECT_EQ(*s.x, Vec3(0.01, -0.12, 0.15));
  EXPECT_EQ(*s.v, Vec3(0, 0.5, 0));
  EXPECT_EQ(*s.force, Vec3(0, 0, 1.25));
  EXPECT_NEAR(s.turn->w(), 0.5, 1e-12);
  EXPECT_EQ(s.buttons, 5u);
  EXPECT_EQ(*read_haply_state(kInventory, "").x, *s.x) << "the first, when none is named";
  const HaplyState second = read_haply_state(kInventory, "0512");
  EXPECT_EQ(*second.x, Vec3(1, 2, 3));
  EXPECT_FALSE(second.is_calibrated);
  EXPECT_FALSE(second.v);
  EXPECT_FALSE(read_haply_state(kInventory, "0000").x);
}

TEST(HaplyMessages, WhatIsMissingOrNoNumberIsNotThere) {
  for (const char* position : {"null", "{}", "{\"x\":0,\"y\":0}", "{\"x\":0,\"y\":0,\"z\":null}",
                               "{\"x\":0,\"y\":0,\"z\":\"0\"}", "{\"x\":0,\"y\":0,\"z\":1e999}", "[0,0,0]", "7"}) {
    const std::string message = text(R"({"inverse3":[{"device_id":"1","state":{"cursor_position":)", position, "}}]}");
    try {
      EXPECT_FALSE(read_haply_state(message, "").x) << position;
    } catch (const InputError&) {
      // 1e999 is no JSON number for some parsers
    }
  }
  for (const char* grip :
       {"null", "{\"w\":0,\"x\":0,\"y\":0,\"z\":0}", "{\"w\":7,\"x\":0,\"y\":0,\"z\":0}", "{\"w\":1}"})
    EXPECT_FALSE(read_haply_state(text(R"({"verse_grip":[{"state":{"orientation":)", grip, "}}]}"), "").turn) << grip;
  for (const char* list : {"null", "7", "[7]", "[null]", "[{}]", "[{\"device_id\":7}]", "{}"})
    EXPECT_TRUE(read_haply_state(text("{\"inverse3\":", list, "}"), "").devices.empty()) << list;
}

TEST(HaplyMessages, EveryCutOfAMessageIsToldOrRead) {
  const std::string whole = kInventory;
  for (std::size_t n = 0; n < whole.size(); ++n)
    EXPECT_THROW(read_haply_state(whole.substr(0, n), ""), InputError) << n;
  for (const char* other : {"", "[]", "7", "\"x\"", "null", "{\"a\":NaN}"})
    EXPECT_THROW(read_haply_state(other, ""), InputError) << other;
}

TEST(HaplyMessages, WritesWhatTheServiceReads) {
  const double force[3] = {0.125, -2, 1e-9};
  const auto told = nlohmann::json::parse(haply_force("049D", force));
  EXPECT_EQ(told["inverse3"][0]["device_id"], "049D");
  EXPECT_EQ(told["inverse3"][0]["commands"]["set_cursor_force"]["values"]["y"], -2.0);
  EXPECT_FALSE(told.contains("session")) << "in the first message only";
  const auto first = nlohmann::json::parse(haply_greeting("049D", 0.25));
  EXPECT_EQ(first["session"]["configure"]["basis"]["permutation"], "XYZ");
  EXPECT_EQ(first["inverse3"][0]["configure"]["damping"]["scalar"], 0.25);
  EXPECT_EQ(first["inverse3"][0]["configure"]["force_gate"]["gain"], 0.0);
  EXPECT_EQ(first["inverse3"][0]["commands"]["set_cursor_force"]["values"]["x"], 0.0);
  EXPECT_TRUE(nlohmann::json::parse(haply_question())["session"]["force_render_full_state"].is_object());
}

}  // namespace
}  // namespace kt
