#include "io/scene/number_range.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/error.hpp"
#include "io/scene/json_schema.hpp"
#include "io/scene/scene.hpp"

namespace kt {

std::string NumberRange::told() const {
  return text(above ? "above " : "at least ", least, std::isfinite(most) ? text(", at most ", most) : "");
}

NumberRange number_range(const std::string& key) {
  static const auto schema = nlohmann::ordered_json::parse(scene_schema());
  std::vector<std::string> path;
  std::istringstream words(key);
  for (std::string word; std::getline(words, word, '.');) path.push_back(word);
  const nlohmann::ordered_json* rules = find_rules(schema, path);
  if (rules && rules->contains("anyOf")) rules = &resolve_rules(schema, rules->at("anyOf")[0]);
  const std::string type = rules ? rules->value("type", "") : "";
  if (type != "number" && type != "integer") throw InputError(text(key, ": is no number of a scene"));
  NumberRange out;
  out.above = rules->contains("exclusiveMinimum");
  out.least = rules->value(out.above ? "exclusiveMinimum" : "minimum", out.least);
  out.most = rules->value("maximum", out.most);
  return out;
}

}  // namespace kt
