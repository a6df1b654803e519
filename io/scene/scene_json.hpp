#pragma once
// Between a scene and its JSON document. Inside io/ only (see json_schema.hpp for the third-party name).
#include <nlohmann/json_fwd.hpp>

#include "io/scene/json_schema.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// A scene from a document that fits the schema; keys that are absent keep their defaults.
Scene scene_from_json(const nlohmann::json& document);

/// The first rule between several values that a schema cannot say: mu_kinetic <= mu_static, times that increase, ...
std::optional<JsonProblem> find_scene_problem(const Scene& scene);

/// The document of a scene file.
/// @throws InputError with file:line:column: a syntax error, a key that is given twice, a number beyond double.
nlohmann::json parse_scene_document(const std::string& json, const std::string& name);

/// Key and value of "key = value"; blanks around both do not count. Without "=" all of it is the key.
std::pair<std::string, std::string> split_override(const std::string& override_text);

/// Sets the value of one "a.b.c=value" and drops the keys that cannot stand beside it.    @throws InputError
void apply_override(nlohmann::json& document, const std::string& override_text, const nlohmann::ordered_json& schema);

}  // namespace kt
