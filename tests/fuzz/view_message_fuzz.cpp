// Messages that a page may send to kilotouch view: each is read, or one InputError of one line.
//
//     scripts/fuzz view_message_fuzz
#include <cmath>
#include <cstdint>
#include <string>

#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "tests/fuzz/require.hpp"
#include "view/server/page_message.hpp"

using kt::fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const kt::PageMessage m = kt::parse_page_message(std::string(reinterpret_cast<const char*>(data), size));
    require(m.x.allFinite() && m.x.lpNorm<Eigen::Infinity>() <= 1e6, "a place is one");
    require(std::isfinite(m.stamp), "a stamp is a number");
    for (const std::string& setting : m.settings) require(setting.size() <= 4096, "settings are short");
  } catch (const kt::InputError& error) {
    require(kt::visible(error.what()).find('\n') == std::string::npos, "a message is one line");
  }
  return 0;
}
