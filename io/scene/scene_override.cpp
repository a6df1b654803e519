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

std::string without_blanks(const std::string& s) {
  const std::size_t from = s.find_first_not_of(" \t"), to = s.find_last_not_of(" \t");
  return from == std::string::npos ? "" : s.substr(from, to - from + 1);
}

[[noreturn]] void refuse(const std::string& override_text, const std::string& why) {
  throw InputError(text("--set ", override_text, ": ", why));
}

}  // namespace

std::pair<std::string, std::string> split_override(const std::string& override_text) {
  const std::size_t equals = override_text.find('=');
  if (equals == std::string::npos) return {without_blanks(override_text), ""};
  return {without_blanks(override_text.substr(0, equals)), without_blanks(override_text.substr(equals + 1))};
}

void apply_override(Json& document, const std::string& override_text, const Rules& schema) {
  const auto [key, value] = split_override(override_text);
  if (key.empty() || override_text.find('=') == std::string::npos)
    refuse(override_text, "write key=value, as in object.model.young=2e4");
  const std::vector<std::string> parts = split(key);
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
  *at = parse_value(value, find_rules(schema, path));
}

}  // namespace kt
