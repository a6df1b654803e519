#pragma once
// JSON of others: read whole, from regular files only, and never so deep that recursion over it ends the process.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace kt {

constexpr int kDeepestJson = 100;  // levels of [ ] and { }; what the program itself writes has fewer than ten

/// Throws InputError, naming `name` and the line, when groups and lists are nested deeper than kDeepestJson. Comments
/// (// and /* */) are skipped.
void require_shallow_json(std::string_view json, const std::string& name);

/// A document. @throws InputError naming the file and, for what is not JSON, the line and column
nlohmann::ordered_json read_json_file(const std::string& file);

/// The same from text. @param name  of it in messages
nlohmann::ordered_json parse_json_text(const std::string& json, const std::string& name);

/// As it is written to a file: bytes of names that are not UTF-8 never cost a result.
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);
std::string json_text(const nlohmann::json& json, int indent = -1);

/// How a message shows a value: its text, cut after 60 characters.
std::string shown_json(const nlohmann::ordered_json& value);

}  // namespace kt
