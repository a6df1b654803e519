// Walks a document and its schema side by side and words the first rule that is broken.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "io/scene/json_schema.hpp"

namespace kt {
namespace {

using Json = nlohmann::json;
using Rules = nlohmann::ordered_json;
using Names = std::vector<std::string>;

std::string below(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

/// A value as the user wrote it, short enough for one line.
std::string shown(const Json& value) {
  std::string out = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return out.size() <= 60 ? out : out.substr(0, 57) + "...";
}

std::string number(const Rules& value) { return text(value.get<double>()); }

class Explainer {
 public:
  explicit Explainer(const Rules& schema) : schema_(schema), keys_(schema_keys(schema)) {}

  std::optional<JsonProblem> explain(const Json& value, const Rules& maybe_reference, const std::string& path) const {
    const Rules& rules = resolve(maybe_reference);
    if (rules.contains("anyOf")) return explain_choice(value, rules, path);
    if (!has_type(value, rules))
      return JsonProblem{path, text("is ", shown(value), ", must be ", wanted(rules), about(rules))};
    if (value.is_object()) return explain_object(value, rules, path);
    if (value.is_array()) return explain_list(value, rules, path);
    if (value.is_string()) return explain_word(value, rules, path);
    if (value.is_number() && !in_range(value, rules))
      return JsonProblem{path, text("is ", shown(value), ", must be ", wanted(rules), about(rules))};
    return std::nullopt;
  }

  const Rules& resolve(const Rules& rules) const { return resolve_rules(schema_, rules); }

 private:
  static bool has_type(const Json& value, const Rules& rules) {
    const std::string type = rules.value("type", "");
    if (type == "object") return value.is_object();
    if (type == "array") return value.is_array();
    if (type == "string") return value.is_string();
    if (type == "boolean") return value.is_boolean();
    if (type == "integer") return value.is_number_integer();
    if (type == "number") return value.is_number();
    if (type == "null") return value.is_null();
    return true;
  }

  /// Of rules for several types: the rule for the value's own type, or all of them.
  std::optional<JsonProblem> explain_choice(const Json& value, const Rules& rules, const std::string& path) const {
    for (const Rules& choice : rules.at("anyOf")) {
      if (!has_type(value, resolve(choice))) continue;
      auto problem = explain(value, choice, path);
      if (problem && value.is_number()) problem->message += " or " + others(rules, choice) + about(rules);
      return problem;
    }
    return JsonProblem{path, text("is ", shown(value), ", must be ", wanted(rules), about(rules))};
  }

  std::string others(const Rules& rules, const Rules& but) const {
    std::string out;
    for (const Rules& choice : rules.at("anyOf"))
      if (choice != but) out += (out.empty() ? "" : " or ") + wanted(choice);
    return out;
  }

  static bool in_range(const Json& value, const Rules& rules) {
    const double x = value.get<double>();
    return x >= rules.value("minimum", x) && x <= rules.value("maximum", x) &&
           (!rules.contains("exclusiveMinimum") || x > rules.at("exclusiveMinimum").get<double>()) &&
           (!rules.contains("exclusiveMaximum") || x < rules.at("exclusiveMaximum").get<double>());
  }

  /// "above 0, at most 3600"; empty without bounds.
  static std::string range(const Rules& rules) {
    Names bounds;
    if (rules.contains("minimum")) bounds.push_back("at least " + number(rules.at("minimum")));
    if (rules.contains("exclusiveMinimum")) bounds.push_back("above " + number(rules.at("exclusiveMinimum")));
    if (rules.contains("maximum")) bounds.push_back("at most " + number(rules.at("maximum")));
    if (rules.contains("exclusiveMaximum")) bounds.push_back("below " + number(rules.at("exclusiveMaximum")));
    return bounds.empty() ? "" : " " + join(bounds);
  }

  /// "a number above 0", "a list of 3 numbers", "one of point, sphere": what the rules ask for.
  std::string wanted(const Rules& maybe_reference) const {
    const Rules& rules = resolve(maybe_reference);
    const std::string type = rules.value("type", "");
    if (rules.contains("anyOf")) return others(rules, Rules());
    if (rules.contains("enum")) return "one of " + join(rules.at("enum").get<Names>());
    if (type == "number") return "a number" + range(rules);
    if (type == "integer") return "a whole number" + range(rules);
    if (type == "string") return "a text in quotes";
    if (type == "boolean") return "true or false";
    if (type == "null") return "null";
    if (type == "array") return "a list of " + count(rules) + plural(rules.at("items"));
    if (rules.contains("properties")) return "a group { } with keys from " + join(own_keys(rules));
    return "something else";
  }

  static std::string count(const Rules& rules) {
    if (!rules.contains("minItems")) return "";
    const bool exact = rules.value("maxItems", -1) == rules.value("minItems", 0);
    return text(exact ? "" : "at least ", rules.value("minItems", 0), " ");
  }

  std::string plural(const Rules& maybe_reference) const {
    const Rules& rules = resolve(maybe_reference);
    if (rules.value("type", "") == "array") return "lists of " + count(rules) + plural(rules.at("items"));
    if (rules.value("type", "") == "object") return "groups { } with keys from " + join(own_keys(rules));
    return rules.value("type", "") == "integer" ? "whole numbers" + range(rules) : "numbers" + range(rules);
  }

  static std::string about(const Rules& rules) {
    return rules.contains("description") ? " (" + rules.at("description").get<std::string>() + ")" : "";
  }

  static Names own_keys(const Rules& rules) {
    Names keys;
    if (rules.contains("properties"))
      for (const auto& [key, value] : rules.at("properties").items()) keys.push_back(key);
    return keys;
  }

  std::optional<JsonProblem> explain_object(const Json& value, const Rules& rules, const std::string& path) const {
    const Names keys = own_keys(rules);
    for (const auto& [key, child] : value.items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) return unknown(key, keys, path);
    if (auto problem = explain_company(value, rules, path)) return problem;
    for (const std::string& key : keys)
      if (value.contains(key))
        if (auto problem = explain(value.at(key), rules.at("properties").at(key), below(path, key))) return problem;
    return std::nullopt;
  }

  /// Keys that must, or must not, stand side by side.
  static std::optional<JsonProblem> explain_company(const Json& value, const Rules& rules, const std::string& path) {
    const Names keys = own_keys(rules);
    Names given;
    for (const std::string& key : keys)
      if (value.contains(key)) given.push_back(key);
    if (given.size() > rules.value("maxProperties", given.size()))
      return JsonProblem{path, text("has ", join(given), ": give one of them")};
    if (given.size() < rules.value("minProperties", std::size_t{0}))
      return JsonProblem{path, text("is empty, must have one of ", join(keys))};
    for (const std::string& key : given)
      for (const std::string& other : excluded_by(rules, key))
        if (value.contains(other))
          return JsonProblem{path, text("has both ", key, " and ", other, ": give one of them")};
    if (rules.contains("required"))
      for (const std::string key : rules.at("required"))
        if (!value.contains(key))
          return JsonProblem{below(path, key), text("is missing", about(rules.at("properties").at(key)))};
    if (rules.contains("dependencies"))
      for (const auto& [key, partners] : rules.at("dependencies").items())
        for (const std::string partner : partners)
          if (value.contains(key) && !value.contains(partner))
            return JsonProblem{below(path, key), "needs " + partner + " beside it"};
    return std::nullopt;
  }

  /// A misspelt sibling first; then the same word elsewhere in the schema, for a key in the wrong group.
  JsonProblem unknown(const std::string& key, const Names& siblings, const std::string& path) const {
    std::string near = nearest_name(key, siblings);
    if (near.empty())
      for (const std::string& known : keys_)
        if (known.substr(known.rfind('.') + 1) == key) near = known;
    return {below(path, key),
            text("is not a key of a scene", near.empty() ? "" : ", did you mean " + near + "?",
                 " (known here: ", join(siblings), ")"),
            true};
  }

  std::optional<JsonProblem> explain_list(const Json& value, const Rules& rules, const std::string& path) const {
    if (value.size() < rules.value("minItems", std::size_t{0}) || value.size() > rules.value("maxItems", value.size()))
      return JsonProblem{path, text("has ", value.size(), value.size() == 1 ? " entry" : " entries", ", must be ",
                                    wanted(rules), about(rules))};
    for (std::size_t i = 0; i < value.size(); ++i)
      if (auto problem = explain(value[i], rules.at("items"), text(path, "[", i, "]"))) return problem;
    return std::nullopt;
  }

  static std::optional<JsonProblem> explain_word(const Json& value, const Rules& rules, const std::string& path) {
    if (!rules.contains("enum")) return std::nullopt;
    const Names words = rules.at("enum").get<Names>();
    const std::string word = value.get<std::string>();
    if (std::find(words.begin(), words.end(), word) != words.end()) return std::nullopt;
    const std::string near = nearest_name(word, words);
    return JsonProblem{path, text("is ", shown(value), near.empty() ? "" : ", did you mean " + near + "?",
                                  " (known: ", join(words), ")")};
  }

  const Rules& schema_;
  Names keys_;
};

}  // namespace

std::optional<JsonProblem> explain_json(const Json& document, const Rules& schema) {
  return Explainer(schema).explain(document, schema, "");
}

}  // namespace kt
