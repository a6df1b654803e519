// Messages of the Inverse Service as its documentation shows them, old and new, cut short, and with what is no number.
#include "haptics/driver/haply/haply_messages.hpp"

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
  ASSERT_EQ(s.devices.size(), 2u);
  EXPECT_EQ(s.devices[0].id + s.devices[1].id, "049D0512");
  EXPECT_EQ(s.devices[0].type, "Inverse3");
  EXPECT_TRUE(s.status && s.status->is_calibrated && s.is_full);
  EXPECT_EQ(s.key, HaplyKey::values) << "an old service: no type, mount, preset, basis";
  ASSERT_TRUE(s.x && s.v && s.force && s.turn);
  EXPECT_EQ(*s.x, Vec3(0.01, -0.12, 0.15));
  EXPECT_EQ(*s.v, Vec3(0, 0.5, 0));
  EXPECT_EQ(*s.force, Vec3(0, 0, 1.25));
  EXPECT_NEAR(s.turn->w(), 0.5, 1e-12);
  EXPECT_EQ(s.buttons, 5u);
  EXPECT_EQ(*read_haply_state(kInventory, "").x, *s.x) << "the first, when none is named";
  const HaplyState second = read_haply_state(kInventory, "0512");
  EXPECT_EQ(*second.x, Vec3(1, 2, 3));
  EXPECT_TRUE(second.status && !second.status->is_calibrated);
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
  const auto told = nlohmann::json::parse(haply_force("049D", force, HaplyKey::values));
  EXPECT_EQ(told["inverse3"][0]["device_id"], "049D");
  EXPECT_EQ(told["inverse3"][0]["commands"]["set_cursor_force"]["values"]["y"], -2.0);
  const auto newer = nlohmann::json::parse(haply_force("049D", force, HaplyKey::vector));
  EXPECT_EQ(newer["inverse3"][0]["commands"]["set_cursor_force"]["vector"]["y"], -2.0);
  EXPECT_FALSE(newer["inverse3"][0]["commands"]["set_cursor_force"].contains("values"));
  EXPECT_FALSE(told.contains("session")) << "in the first message only";
  const auto first = nlohmann::json::parse(haply_greeting("049D", 0.25, HaplyKey::values));
  EXPECT_EQ(first["session"]["configure"]["basis"]["permutation"], "XYZ");
  EXPECT_EQ(first["inverse3"][0]["configure"]["damping"]["scalar"], 0.25);
  EXPECT_EQ(first["inverse3"][0]["configure"]["force_gate"]["gain"], 0.0);
  EXPECT_EQ(first["inverse3"][0]["commands"]["set_cursor_force"]["values"]["x"], 0.0);
  EXPECT_EQ(first["inverse3"][0]["configure"]["preset"]["preset"], "defaults");
  EXPECT_FALSE(first["inverse3"][0]["configure"].contains("mount")) << "a service refuses both in one message";
  const auto second = nlohmann::json::parse(haply_identities("049D", 0.25));
  EXPECT_FALSE(second["inverse3"][0]["configure"].contains("preset"));
  EXPECT_EQ(second["inverse3"][0]["configure"]["mount"]["transform"]["scale"]["x"], 1.0);
  EXPECT_EQ(second["inverse3"][0]["commands"]["set_transform"]["transform"]["rotation"]["w"], 1.0);
  EXPECT_FALSE(second["inverse3"][0]["commands"].contains("set_cursor_force"));
  EXPECT_TRUE(nlohmann::json::parse(haply_question("", true))["session"]["force_render_full_state"].is_object());
  const auto question = nlohmann::json::parse(haply_question("049D", false));
  EXPECT_TRUE(question["inverse3"][0]["commands"]["probe_position"].is_object());
  EXPECT_FALSE(question.contains("session") || question["inverse3"][0]["commands"].contains("set_cursor_force"));
}

/// The inventory of the maker's page, 3.5, with one part of it another.
std::string inventory(const std::string& part, const std::string& instead) {
  std::string out =
      R"({"session_id": 7, "inverse3": [{"device_id": "049D", "config": {"type": "inverse3", "port": "COM12",
    "device_info": {"major_version": 7, "device_type": 4}, "preset": "defaults", "basis": {"permutation": "XYZ"},
    "mount": {"position": {"x": 0, "y": 0, "z": 0}, "rotation": {"w": 1, "x": 0, "y": 0, "z": 0}, "scale": {"x": 1, "y": 1, "z": 1}},
    "filters": {"force_gate": {"gain": 0.0}, "damping": {"scalar": 0.0}}},
    "state": {"cursor_position": {"x": 0.0, "y": -0.12, "z": 0.15}, "transform": {"scale": {"x": 1.0, "y": 1.0, "z": 1.0}}},
    "status": {"calibrated": true, "power_supply": true, "ready": true, "started": true, "in_use": false}}],
    "verse_grip": [{"device_id": "A"}], "wireless_verse_grip": [{"device_id": "B"}]})";
  if (const auto at = out.find(part); at != std::string::npos) out.replace(at, part.size(), instead);
  return out;
}

TEST(HaplyMessages, WhatASessionAltersIsNamed) {
  const auto altered = [](const std::string& part, const std::string& instead) {
    const HaplyState s = read_haply_state(inventory(part, instead), "");
    EXPECT_TRUE(s.is_full && s.key == HaplyKey::vector);
    return s.altered;
  };
  EXPECT_EQ(altered("", ""), "");
  EXPECT_EQ(altered(R"("scale": {"x": 1, "y")", R"("scale": {"x": 2, "y")"), "mount.scale 2 1 1");
  EXPECT_EQ(altered(R"("rotation": {"w": 1, "x": 0)", R"("rotation": {"w": 0, "x": 1)"), "mount.rotation 0 1 0 0");
  EXPECT_EQ(altered(R"("position": {"x": 0, "y": 0, "z": 0})", R"("position": {"x": 0, "y": 0, "z": 0.1})"),
            "mount.position 0 0 0.1");
  EXPECT_EQ(altered(R"("scale": {"x": 1.0)", R"("scale": {"x": 3.0)"), "transform.scale 3 1 1");
  EXPECT_EQ(altered(R"("XYZ")", R"("XZ-Y")"), "basis XZ-Y");
  EXPECT_EQ(altered(R"("XYZ")", R"("+X+Y+Z")"), "");
  EXPECT_EQ(altered(R"("preset": "defaults")", R"("preset": "led_front")"), "preset led_front");
  EXPECT_EQ(altered(R"("preset": "defaults")", R"("preset": "custom")"), "") << "a mount that was set, as ours";
  EXPECT_EQ(altered(R"("gain": 0.0)", R"("gain": 0.3)"), "filters.force_gate.gain 0.3");
}

TEST(HaplyMessages, StatusIsRead) {
  const auto status = [](const char* part, const char* instead) {
    return *read_haply_state(inventory(part, instead), "").status;
  };
  const HaplyStatus well = status("", "");
  EXPECT_TRUE(well.has_power && well.is_calibrated && well.is_ready && well.is_started && !well.is_in_use);
  EXPECT_FALSE(status(R"("power_supply": true)", R"("power_supply": false)").has_power);
  EXPECT_FALSE(status(R"("ready": true)", R"("ready": false)").is_ready);
  EXPECT_FALSE(status(R"("started": true)", R"("started": false)").is_started);
  EXPECT_TRUE(status(R"("in_use": false)", R"("in_use": true)").is_in_use);
}

TEST(HaplyMessages, OfSeveralGripsThePairedOneIsTaken) {
  const auto grip = [](const char* part, const char* instead) {
    return read_haply_state(inventory(part, instead), "").grip;
  };
  EXPECT_EQ(grip("", ""), "") << "two, and none says that it is ours";
  EXPECT_EQ(grip(R"(, "wireless_verse_grip": [{"device_id": "B"}])", ""), "verse_grip A") << "the only one";
  EXPECT_EQ(grip(R"({"device_id": "B"})", R"({"device_id": "B", "config": {"paired_inverse3": "049D"}})"),
            "wireless_verse_grip B");
  EXPECT_EQ(grip(R"("port": "COM12")", R"("paired_grip_id": "B")"), "wireless_verse_grip B");
  EXPECT_EQ(grip(R"({"device_id": "B"})", R"({"device_id": "B", "config": {"paired_inverse3": "0512"}})"), "");
}

TEST(HaplyMessages, NamesAndReachAreThoseOfTheType) {
  EXPECT_EQ(haply_name("inverse3") + haply_name("inverse3x") + haply_name("minverse"), "Inverse3Inverse3xMinverse");
  EXPECT_EQ(haply_reach("inverse3"), 0.1);
  EXPECT_EQ(haply_reach("minverse"), 0.04);
}

TEST(HaplyMessages, ASettingIsFoundInEveryShape) {
  const char* const key = "devices/force_scale";
  for (const char* answer :
       {R"({"ok": true, "data": 0.5})", R"({"ok": true, "data": {"value": 0.5}})", "0.5",
        R"({"ok": true, "data": {"devices/force_scale": 0.5, "other": 2}})",
        R"({"data": {"devices/force_scale": {"value": 0.5, "type_hint": "FLOAT"}}})",
        R"({"data": [{"key": "other", "value": 2}, {"key": "devices/force_scale", "value": 0.5}]})",
        R"({"devices": {"other": 2, "force_scale": 0.5}})"})
    EXPECT_EQ(read_haply_setting(answer, key), 0.5) << answer;
  for (const char* answer : {"", "{}", "[]", "<html>", R"({"ok": false, "error": "unknown"})", R"({"data": "0.5"})"})
    EXPECT_FALSE(read_haply_setting(answer, key)) << answer;
  EXPECT_FALSE(read_haply_setting(std::string(100000, '['), key));
  std::string deep;
  for (int i = 0; i < 50000; ++i) deep += R"({"a":)";
  EXPECT_FALSE(read_haply_setting(deep + "1" + std::string(50000, '}'), key)) << "no end of the stack";
}

TEST(HaplyMessages, AnEventIsRead) {
  const HaplyEvent e = read_haply_event(
      R"({"name": "device-safety-triggered", "category": "device", "level": "error",
          "data": {"device_id": "049D", "safety_type": "ebrake_triggered"}, "message": "brake"})");
  EXPECT_EQ(e.name + " " + e.level + " " + e.device + " " + e.kind + " " + e.message,
            "device-safety-triggered error 049D ebrake_triggered brake");
  EXPECT_THROW(read_haply_event("[]"), InputError);
}

}  // namespace
}  // namespace kt
