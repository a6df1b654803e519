#include "io/files/json_file.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "io/files/text_reader.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

/// Behind a string or a comment that begins at `at`; else `at`.
std::size_t skip_text(std::string_view json, std::size_t at) {
  const auto behind = [&](std::string_view mark, std::size_t from) {
    const std::size_t found = json.find(mark, from);
    return found == std::string_view::npos ? json.size() : found + mark.size();
  };
  if (json.substr(at, 2) == "//") return behind("\n", at);
  if (json.substr(at, 2) == "/*") return behind("*/", at + 2);
  if (json[at] != '"') return at;
  for (++at; at < json.size() && json[at] != '"'; ++at)
    if (json[at] == '\\') ++at;
  return std::min(at + 1, json.size());
}

}  // namespace

void require_shallow_json(std::string_view json, const std::string& name) {
  int depth = 0;
  for (std::size_t i = 0; i < json.size();) {
    if (const std::size_t next = skip_text(json, i); next != i) {
      i = next;
      continue;
    }
    depth += json[i] == '[' || json[i] == '{' ? 1 : json[i] == ']' || json[i] == '}' ? -1 : 0;
    if (depth > kDeepestJson)
      throw InputError(text(name, ":", 1 + std::ranges::count(json.substr(0, i), '\n'), ": more than ", kDeepestJson,
                            " levels of [ ] and { } inside one another; at most ", kDeepestJson, " are read"));
    ++i;
  }
}

Json parse_json_text(const std::string& json, const std::string& name) {
  require_shallow_json(json, name);
  try {
    return Json::parse(json);
  } catch (const Json::parse_error& error) {
    const std::string before = json.substr(0, error.byte ? error.byte - 1 : 0);
    const std::size_t start = before.rfind('\n');
    throw InputError(text(name, ":", 1 + std::ranges::count(before, '\n'), ":",
                          start == std::string::npos ? before.size() + 1 : before.size() - start,
                          ": is not JSON from here on"));
  } catch (const Json::exception&) {  // a number beyond double
    throw InputError(text(name, ": is not JSON: a number in it is too large"));
  }
}

Json read_json_file(const std::string& file) { return parse_json_text(read_whole_file(file), file); }

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}
std::string json_text(const nlohmann::json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string shown_json(const Json& value) {
  constexpr std::size_t kLongest = 60;
  const std::string all = json_text(value);
  return all.size() > kLongest ? all.substr(0, kLongest) + "..." : all;
}

}  // namespace kt
