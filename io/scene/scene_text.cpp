// The text of a scene file to a document, with errors that say where: file:line:column.
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.hpp"
#include "io/files/json_file.hpp"
#include "io/scene/scene_json.hpp"

namespace kt {
namespace {

using Json = nlohmann::json;

/// "3:14" of a byte in a text, both from 1.
std::string line_and_column(const std::string& all, std::size_t byte) {
  byte = std::min(byte, all.size());
  const std::string before = all.substr(0, byte);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t start = before.rfind('\n');
  return text(line, ":", start == std::string::npos ? byte + 1 : byte - start);
}

/// What most likely went wrong, in a person's words; empty when nothing is typical.
std::string hint(const std::string& message) {
  const auto says = [&](const char* words) { return message.find(words) != std::string::npos; };
  if (says("object key - unexpected '}'") || says("value - unexpected ']'")) return " (a comma too many before it?)";
  if (says("unexpected string literal; expected '}'")) return " (a comma missing before it?)";
  if (says("unexpected end of input")) return " (a bracket not closed?)";
  if (says("expected string literal")) return " (keys go in double quotes)";
  if (says("invalid literal")) return " (words go in double quotes)";
  return "";
}

/// nlohmann's message without its prefix: "unexpected '}'; expected string literal".
std::string plain_words(const std::string& message) {
  const std::size_t dash = message.find(" - ");
  if (dash == std::string::npos) return message.substr(message.rfind("] ") + 2);
  return message.substr(dash + 3);
}

/// Watches the parser for a key that an object has twice: JSON allows it, and the first value would vanish unseen.
class KeysOnce {
 public:
  bool operator()(int /*depth*/, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) seen_.emplace_back();
    if (event == Json::parse_event_t::object_end) seen_.pop_back();
    if (event == Json::parse_event_t::key && !seen_.back().insert(parsed.get<std::string>()).second)
      twice_ = twice_.empty() ? parsed.get<std::string>() : twice_;
    return true;
  }
  const std::string& twice() const { return twice_; }

 private:
  std::vector<std::set<std::string>> seen_;
  std::string twice_;
};

}  // namespace

Json parse_scene_document(const std::string& json, const std::string& name) {
  require_shallow_json(json, name);
  KeysOnce keys;
  Json document;
  try {
    document = Json::parse(json, std::ref(keys), true, /*ignore_comments=*/true);
  } catch (const Json::parse_error& error) {
    const std::string words = plain_words(error.what());
    throw InputError(
        text(name, ":", line_and_column(json, error.byte ? error.byte - 1 : 0), ": ", words, hint(error.what())));
  } catch (const Json::out_of_range& error) {  // "number overflow parsing '1e999'"
    const std::string what = error.what();
    const std::size_t quote = what.find('\'');
    const std::string token = quote == std::string::npos ? "" : what.substr(quote + 1, what.rfind('\'') - quote - 1);
    const std::size_t where = token.empty() ? std::string::npos : json.find(token);
    throw InputError(text(name, ":", line_and_column(json, where), ": the number ", token, " is too large"));
  }
  if (!keys.twice().empty())
    throw InputError(text(name, ": the key \"", keys.twice(), "\" is given twice in one group { }"));
  return document;
}

}  // namespace kt
