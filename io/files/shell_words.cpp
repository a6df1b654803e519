#include "io/files/shell_words.hpp"

#include "core/base/visible_text.hpp"

namespace kt {
namespace {

std::string quoted_for_shell(const std::string& word) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=:,+@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  const bool is_plain_text = visible(word) == word;
  std::string out = is_plain_text ? "'" : "$'";
  for (const char c : word) {
    if (c == '\'')
      out += is_plain_text ? "'\\''" : "\\'";
    else if (c == '\\' && !is_plain_text)
      out += "\\\\";
    else
      out += c;
  }
  out += "'";
  if (is_plain_text) return out;
  // What is left unseen is named by its bytes: bash, zsh and ksh read $'\xff' so.
  std::string named;
  for (const char c : out) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= ' ' && byte < 0x7F) {
      named += c;
      continue;
    }
    constexpr const char* kDigits = "0123456789abcdef";
    named += "\\x";
    named += kDigits[byte >> 4];
    named += kDigits[byte & 15];
  }
  return named;
}

}  // namespace

std::string shell_words(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) {
    if (!out.empty()) out += ' ';
    out += quoted_for_shell(word);
  }
  return out;
}

}  // namespace kt
