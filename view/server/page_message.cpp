#include "view/server/page_message.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "io/files/json_file.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;
using Kind = PageMessage::Kind;

struct Word {
  const char* name;
  Kind kind;
};
constexpr Word kWords[] = {{"target", Kind::target}, {"set", Kind::set},       {"restart", Kind::restart},
                           {"check", Kind::check},   {"open", Kind::open},     {"reset", Kind::reset},
                           {"pause", Kind::pause},   {"record", Kind::record}, {"cancel", Kind::cancel},
                           {"take", Kind::take},     {"seek", Kind::seek}};

constexpr std::size_t kMostSettings = 50, kLongestSetting = 4096;
constexpr double kFarthest = 1e6;  // [m]

[[noreturn]] void fail(const std::string& key, const Json& value, const std::string& allowed) {
  throw InputError(text("page: ", key, " is ", shown_json(value), ", must be ", allowed));
}

const Json& at(const Json& message, const char* key) {
  if (!message.contains(key)) throw InputError(text("page: ", key, " is missing"));
  return message[key];
}

double number(const Json& message, const char* key, double least, double most) {
  const Json& value = at(message, key);
  const double out = value.is_number() ? value.get<double>() : std::nan("");
  if (!(out >= least && out <= most)) fail(key, value, text("a number ", least, " .. ", most));
  return out;
}

bool flag(const Json& message, const char* key) {
  const Json& value = at(message, key);
  if (!value.is_boolean()) fail(key, value, "true or false");
  return value.get<bool>();
}

std::string word(const Json& value, const std::string& key, std::size_t longest) {
  if (!value.is_string() || value.get_ref<const std::string&>().size() > longest)
    fail(key, value, text("a text of at most ", longest, " bytes"));
  return value.get<std::string>();
}

}  // namespace

PageMessage parse_page_message(const std::string& message) {
  if (message.size() > kLongestMessage)
    throw InputError(text("page: a message of ", message.size(), " bytes, must be at most ", kLongestMessage));
  const Json json = parse_json_text(message, "page");
  if (!json.is_object()) throw InputError("page: a message must be a group { }");
  const std::string name = word(at(json, "type"), "type", 100);
  const auto known = std::ranges::find_if(kWords, [&](const Word& w) { return name == w.name; });
  if (known == std::end(kWords)) fail("type", json["type"], "one of those in docs/view.md");
  PageMessage out;
  out.kind = known->kind;
  switch (out.kind) {
    case Kind::target: {
      const Json& x = at(json, "x");
      if (!x.is_array() || x.size() != 3) fail("x", x, "three numbers");
      for (std::size_t i = 0; i < 3; ++i) {
        const double v = x[i].is_number() ? x[i].get<double>() : std::nan("");
        if (!(std::abs(v) <= kFarthest)) fail(text("x[", i, "]"), x[i], text("a number of at most ", kFarthest, " m"));
        out.x[static_cast<int>(i)] = v;
      }
      out.number = static_cast<unsigned>(number(json, "number", 0, 4294967295.0));
      out.stamp = number(json, "stamp", 0, 1e15);
      break;
    }
    case Kind::set:
    case Kind::restart:
    case Kind::check: {
      const Json& list = at(json, "settings");
      if (!list.is_array() || list.empty() || list.size() > kMostSettings)
        fail("settings", list, text("a list of 1 to ", kMostSettings));
      for (const Json& setting : list) out.settings.push_back(word(setting, "settings", kLongestSetting));
      break;
    }
    case Kind::open:
      out.name = word(at(json, "name"), "name", 255);
      out.on = json.contains("repair") && flag(json, "repair");
      break;
    case Kind::pause:
    case Kind::record:
      out.on = flag(json, "on");
      break;
    case Kind::seek:
      out.stamp = number(json, "time", 0, 1e9);
      break;
    case Kind::reset:
    case Kind::cancel:
    case Kind::take:
      break;
  }
  return out;
}

}  // namespace kt
