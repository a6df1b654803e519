// What a schema says about its own keys: their names, their rules, and which of them exclude each other.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/scene/json_schema.hpp"

namespace kt {
namespace {

using Rules = nlohmann::ordered_json;
using Names = std::vector<std::string>;

void collect_keys(const Rules& schema, const Rules& rules, const std::string& path, Names& out) {
  for (const auto& [key, reference] : rules.at("properties").items()) {
    const Rules& child = resolve_rules(schema, reference);
    const std::string name = path.empty() ? key : path + "." + key;
    if (child.contains("properties"))
      collect_keys(schema, child, name, out);
    else
      out.push_back(name);
  }
}

}  // namespace

const Rules& resolve_rules(const Rules& schema, const Rules& rules) {
  if (!rules.contains("$ref")) return rules;
  return schema.at(Rules::json_pointer(rules.at("$ref").get<std::string>().substr(1)));  // "#/definitions/vec3"
}

Names schema_keys(const Rules& schema) {
  Names keys;
  collect_keys(schema, schema, "", keys);
  return keys;
}

const Rules* find_rules(const Rules& schema, const Names& path) {
  const Rules* rules = &schema;
  for (const std::string& key : path) {
    if (!rules->contains("properties") || !rules->at("properties").contains(key)) return nullptr;
    rules = &rules->at("properties").at(key);
    if (rules->contains("$ref"))
      rules = &schema.at(Rules::json_pointer(rules->at("$ref").get<std::string>().substr(1)));
  }
  return rules;
}

Names excluded_by(const Rules& rules, const std::string& key) {
  Names out;
  if (rules.value("maxProperties", 0) == 1)
    for (const auto& [other, child] : rules.at("properties").items())
      if (other != key) out.push_back(other);
  Rules pairs = rules.value("allOf", Rules::array());
  pairs.push_back(rules);
  for (const Rules& rule : pairs) {
    if (!rule.contains("not") || !rule.at("not").contains("required")) continue;
    const Names pair = rule.at("not").at("required").get<Names>();
    if (std::find(pair.begin(), pair.end(), key) == pair.end()) continue;
    for (const std::string& other : pair)
      if (other != key) out.push_back(other);
  }
  return out;
}

}  // namespace kt
