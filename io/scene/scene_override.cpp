// "object.model.young=2e4" on the command line.
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "io/files/json_file.hpp"
#include "io/scene/scene_json.hpp"

namespace kt {
namespace {

using Json = nlohmann::json;
using Rules = nlohmann::ordered_json;

std::vector<std::string> split(const std::string& key) {
  std::vector<std::string> parts(1);
  for (const char c : key)
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// The first `count` parts with their dots; "the scene" for none.
std::string parent(const std::vector<std::string>& parts, std::size_t count) {
  std::string out = count == 0 ? "the scene" : parts[0];
  for (std::size_t i = 1; i < count; ++i) out += "." + parts[i];
  return out;
}

/// JSON if it parses, else the word itself. A text key takes "2024" as text: nobody quotes for the shell twice.
Json parse_value(const std::string& value, const Rules* rules) {
  require_shallow_json(value, "--set");
  const Json parsed = Json::parse(value, nullptr, /*allow_exceptions=*/false, /*ignore_comments=*/true);
  if (parsed.is_discarded()) return value;
  const bool wants_text = rules && rules->value("type", "") == "string";
  return wants_text && !parsed.is_string() ? Json(value) : parsed;
}

[[noreturn]] void refuse(const std::string& override_text, const std::string& why) {
  throw InputError(text("--set ", override_text, ": ", why));
}

}  // namespace

void apply_override(Json& document, const std::string& override_text, const Rules& schema) {
  const std::size_t equals = override_text.find('=');
  if (equals == std::string::npos || equals == 0)
    refuse(override_text, "write key=value, as in object.model.young=2e4");
  const std::vector<std::string> parts = split(override_text.substr(0, equals));
  Json* at = &document;
  std::vector<std::string> path;
  for (const std::string& part : parts) {
    if (part.empty()) refuse(override_text, "the key has an empty part: write it as in object.model.young=2e4");
    const Rules* rules = find_rules(schema, path);
    const bool is_value = rules ? !rules->contains("properties") : !at->is_null() && !at->is_object();
    if (is_value) refuse(override_text, text(parent(parts, path.size()), " is a value, not a group with keys inside"));
    if (!at->is_object()) *at = Json::object();
    if (rules)
      for (const std::string& other : excluded_by(*rules, part)) at->erase(other);
    path.push_back(part);
    at = &(*at)[part];
  }
  *at = parse_value(override_text.substr(equals + 1), find_rules(schema, path));
}

}  // namespace kt
