#pragma once
// A JSON document against a draft-07 schema, with a message a person can act on.
// Used only inside io/ (nlohmann's forward header is the one third-party name here; public headers stay free of it).
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace kt {

/// What is wrong with a document, and where.
struct JsonProblem {
  std::string path = {};     ///< "object.model.young"; empty: the document itself
  std::string message = {};  ///< "is -5, must be above 0 ..."; reads on after the path
  bool unknown_key = false;  ///< the path names a key that the schema does not have
};

/// The first problem, or nothing when the document is valid. Validity is decided by valijson; the words come from
/// explain_json, because a validator says "failed to validate against child schema #3" where a person needs the range.
std::optional<JsonProblem> find_json_problem(const nlohmann::json& document, const nlohmann::ordered_json& schema);

/// The first rule of the schema that the document breaks, in words. Knows the rules our schemas use: type, enum,
/// ranges, list lengths, required, unknown keys, numbers of properties, dependencies, "anyOf" of types, and pairs that
/// exclude each other
/// ("not": {"required": [a, b]}, alone or in "allOf").
std::optional<JsonProblem> explain_json(const nlohmann::json& document, const nlohmann::ordered_json& schema);

/// The schema's own keys that have a value, "object.model.young", in its order.
std::vector<std::string> schema_keys(const nlohmann::ordered_json& schema);

/// The rules themselves, or those that their "$ref" points at.
const nlohmann::ordered_json& resolve_rules(const nlohmann::ordered_json& schema, const nlohmann::ordered_json& rules);

/// The rules for the value at `path`, references resolved; null when the schema has no such key.
const nlohmann::ordered_json* find_rules(const nlohmann::ordered_json& schema, const std::vector<std::string>& path);

/// Keys that cannot stand beside `key` in an object with these rules.
std::vector<std::string> excluded_by(const nlohmann::ordered_json& rules, const std::string& key);

}  // namespace kt
