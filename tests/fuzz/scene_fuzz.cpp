// Scene files of whatever text a fuzzer makes up: each is a scene, or one InputError of one line.
//
//     scripts/fuzz scene_fuzz
#include <cstdint>
#include <string>

#include "core/base/error.hpp"
#include "io/scene/scene.hpp"
#include "tests/fuzz/require.hpp"

using kt::fuzz::require;

/// The text up to a NUL is the scene, the rest an override, as of --set.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string all(reinterpret_cast<const char*>(data), size);
  const std::size_t end = all.find('\0');
  std::vector<std::string> overrides;
  if (end != std::string::npos) overrides.push_back(all.substr(end + 1));
  try {
    const kt::Scene scene = kt::parse_scene(all.substr(0, end), overrides, "a.json");
    require(kt::parse_scene(kt::to_json(scene)) == scene, "a scene reads back from its own text");
  } catch (const kt::InputError& error) {
    require(std::string(error.what()).find('\n') == std::string::npos, "a message is one line");
  }
  return 0;
}
