// Messages of the Inverse Service: each is read, or one InputError; whatever is read is finite.
//
//     scripts/fuzz haply_message_fuzz
#include <cmath>
#include <cstdint>
#include <string>

#include "haptics/driver/haply/haply_messages.hpp"
#include "tests/fuzz/require.hpp"

using kt::fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const kt::HaplyState s = kt::read_haply_state(std::string(reinterpret_cast<const char*>(data), size), "049D");
    require(!s.x || s.x->allFinite(), "a place is one");
    require(!s.v || s.v->allFinite(), "a velocity is one");
    require(!s.force || s.force->allFinite(), "a force is one");
    require(!s.turn || std::abs(s.turn->norm() - 1) < 1e-9, "a turn has length one");
    for (const kt::HaplyListed& one : s.devices) require(!one.id.empty(), "each device has an id");
    require(s.is_full || s.altered.empty(), "what is altered is read from a configuration");
  } catch (const kt::InputError&) {
  }
  try {
    kt::read_haply_event(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const kt::InputError&) {
  }
  const auto setting =
      kt::read_haply_setting(std::string(reinterpret_cast<const char*>(data), size), "devices/force_scale");
  require(!setting || std::isfinite(*setting), "a setting is a number");
  return 0;
}
