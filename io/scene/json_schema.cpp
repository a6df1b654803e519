// The only file that sees valijson: its templates take seconds to compile.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored \
    "-Wrestrict"  // GCC 12 sees overlaps inside std::string::replace that are not there (PR105651)
#endif
#include "io/scene/json_schema.hpp"

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

namespace kt {
namespace {

/// valijson's own words, for a rule that explain_json does not know.
JsonProblem last_words(valijson::ValidationResults& results) {
  JsonProblem problem{.message = "does not fit the schema"};
  valijson::ValidationResults::Error error;
  while (results.popError(error)) {
    problem.path.clear();
    for (const std::string& step : error.context)
      if (step != "<root>") problem.path += (problem.path.empty() ? "" : ".") + step;
    problem.message = error.description;
  }
  return problem;
}

}  // namespace

std::optional<JsonProblem> find_json_problem(const nlohmann::json& document, const nlohmann::ordered_json& schema) {
  const nlohmann::json plain = nlohmann::json::parse(schema.dump());  // the adapter knows only the unordered kind
  valijson::Schema parsed;
  valijson::SchemaParser(valijson::SchemaParser::kDraft7)
      .populateSchema(valijson::adapters::NlohmannJsonAdapter(plain), parsed);
  valijson::ValidationResults results;
  if (valijson::Validator(valijson::Validator::kStrongTypes)
          .validate(parsed, valijson::adapters::NlohmannJsonAdapter(document), &results))
    return std::nullopt;
  if (auto problem = explain_json(document, schema)) return problem;
  return last_words(results);
}

}  // namespace kt
