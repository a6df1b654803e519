#include "core/base/visible_text.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>

namespace kt {
namespace {

unsigned char byte_at(std::string_view text, std::size_t i) { return static_cast<unsigned char>(text[i]); }

/// The code point that begins at `at` and its number of bytes; 0 bytes: not UTF-8 (Unicode 15, table 3-7).
struct CodePoint {
  std::uint32_t value = 0;
  std::size_t bytes = 0;
};

CodePoint code_point(std::string_view text, std::size_t at) {
  const unsigned char lead = byte_at(text, at);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || at + bytes > text.size()) return {};
  std::uint32_t value = lead & (0x7Fu >> bytes);
  for (std::size_t k = 1; k < bytes; ++k) {
    const unsigned char next = byte_at(text, at + k);
    if ((next & 0xC0) != 0x80) return {};
    value = value << 6 | (next & 0x3Fu);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = value >= 0xD800 && value < 0xE000;
  return value < kLeast[bytes] || value > 0x10FFFF || is_surrogate ? CodePoint{} : CodePoint{value, bytes};
}

struct Range {
  std::uint32_t first, last;
};
// C1; soft hyphen; Arabic letter mark; zero widths and marks of direction; separators and embeddings; invisible
// operators and isolates; byte order mark; annotations; tags.
constexpr Range kUnseen[] = {{0x7F, 0x9F},     {0xAD, 0xAD},     {0x61C, 0x61C},   {0x200B, 0x200F},  {0x2028, 0x202E},
                             {0x2060, 0x206F}, {0xFEFF, 0xFEFF}, {0xFFF9, 0xFFFB}, {0xE0000, 0xE007F}};

bool is_unseen(std::uint32_t c) {
  return c < ' ' || std::ranges::any_of(kUnseen, [&](const Range& r) { return c >= r.first && c <= r.last; });
}

void append_hex(std::string& out, const char* format, std::uint32_t value) {
  char buffer[16];
  std::snprintf(buffer, sizeof buffer, format, static_cast<unsigned>(value));
  out += buffer;
}

std::string made_visible(std::string_view text, std::string_view kept) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const CodePoint c = code_point(text, i);
    if (c.bytes == 0)
      append_hex(out, "\\x%02x", byte_at(text, i));
    else if (!is_unseen(c.value) || kept.find(text[i]) != std::string_view::npos)
      out += text.substr(i, c.bytes);
    else if (c.value == '\n')
      out += "\\n";
    else if (c.value == '\r')
      out += "\\r";
    else if (c.value == '\t')
      out += "\\t";
    else
      append_hex(out, c.value < 0x80 ? "\\x%02x" : "\\u%04x", c.value);
    i += std::max<std::size_t>(1, c.bytes);
  }
  return out;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/// The byte that an escape at `at` stands for; -1: there is none.
int escaped_byte(std::string_view text, std::size_t at) {
  if (at + 4 > text.size() || text[at] != '\\' || text[at + 1] != 'x') return -1;
  const int high = hex_digit(text[at + 2]), low = hex_digit(text[at + 3]);
  return high < 0 || low < 0 ? -1 : 16 * high + low;
}

}  // namespace

std::string visible(std::string_view text) { return made_visible(text, ""); }

std::string one_line(std::string_view text, std::size_t most) {
  if (text.size() <= most) return visible(text);
  std::size_t end = most;  // not within a character
  while (end > 0 && end + 4 > most && (byte_at(text, end) & 0xC0) == 0x80) --end;
  return visible(text.substr(0, end)) + "... (" + std::to_string(text.size() - end) + " bytes more)";
}

std::string visible_lines(std::string_view text) { return made_visible(text, "\n\t"); }

std::string escape_bytes(std::string_view name) {
  std::string out;
  for (std::size_t i = 0; i < name.size();) {
    const CodePoint c = code_point(name, i);
    if (c.bytes == 0 || escaped_byte(name, i) >= 0)
      append_hex(out, "\\x%02x", byte_at(name, i));
    else
      out += name.substr(i, c.bytes);
    i += std::max<std::size_t>(1, c.bytes);
  }
  return out;
}

std::string unescape_bytes(std::string_view name) {
  std::string out;
  for (std::size_t i = 0; i < name.size();) {
    const int byte = escaped_byte(name, i);
    out += byte >= 0 ? static_cast<char>(byte) : name[i];
    i += byte >= 0 ? 4 : 1;
  }
  return out;
}

}  // namespace kt
