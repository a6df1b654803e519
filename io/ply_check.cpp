#include "io/ply_check.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <vector>

#include "io/text_reader.hpp"

namespace kt {
namespace {

struct Property {
  std::string line;            ///< as it stands in the header, with single blanks
  std::size_t size = 0;        ///< bytes of a value, or of one list entry
  std::size_t count_size = 0;  ///< bytes of a list's length; 0: not a list
};
struct Element {
  std::string name;
  long long number = 0;
  std::vector<Property> properties;
  std::size_t smallest() const {  ///< bytes of one record with empty lists
    std::size_t sum = 0;
    for (const Property& p : properties) sum += p.count_size > 0 ? p.count_size : p.size;
    return sum;
  }
};
struct Header {
  std::string format;
  bool ascii = false, big_endian = false;
  std::vector<Element> elements;
};

std::size_t size_of_type(const TextReader& in, const std::string& type, bool integer) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "int32" || type == "uint32") return 4;
  if (!integer && (type == "float" || type == "float32")) return 4;
  if (!integer && (type == "double" || type == "float64")) return 8;
  in.fail("property type ", quoted(type), " is not ", integer ? "an integer type" : "a PLY type");
}

void read_header_line(const TextReader& in, const std::vector<std::string>& word, Header& h) {
  const auto must_have = [&](std::size_t n) {
    if (word.size() != n) in.fail("header line ", word[0], " has ", word.size(), " words; must be ", n);
  };
  if (word[0] == "format") {
    must_have(3);
    if (!h.format.empty()) in.fail("a second format line");
    h.format = word[1];
    h.ascii = word[1] == "ascii";
    h.big_endian = word[1] == "binary_big_endian";
    if (!h.ascii && !h.big_endian && word[1] != "binary_little_endian")
      in.fail("format ", quoted(word[1]), " is unknown");
  } else if (word[0] == "element") {
    must_have(3);
    Element e{word[1], in.to_integer(word[2], text("the number of elements ", word[1])), {}};
    if (e.number < 0) in.fail("the number of elements ", e.name, " is ", e.number, "; must be at least 0");
    h.elements.push_back(e);
  } else if (word[0] == "property") {
    const bool list = word.size() > 1 && word[1] == "list";
    must_have(list ? 5 : 3);
    if (h.elements.empty()) in.fail("property before the first element");
    Property p;
    for (const std::string& w : word) p.line += (p.line.empty() ? "" : " ") + w;
    p.size = size_of_type(in, word[list ? 3 : 1], false);
    if (list) p.count_size = size_of_type(in, word[2], true);
    h.elements.back().properties.push_back(p);
  } else if (word[0] != "comment" && word[0] != "obj_info") {
    in.fail("unknown header line ", quoted(word[0]), "; known: format, comment, element, property, end_header");
  }
}

Header read_header(TextReader& in) {
  Header h;
  const auto first = in.line();
  if (!first || *first != "ply") in.fail("file starts with ", quoted(first.value_or("")), "; must start with ply");
  while (const auto line = in.line()) {
    if (*line == "end_header") {
      if (h.format.empty()) in.fail("the header has no format line");
      return h;
    }
    std::istringstream stream{std::string(*line)};
    std::vector<std::string> words;
    for (std::string w; stream >> w;) words.push_back(w);
    read_header_line(in, words, h);
  }
  in.fail("the header has no end_header");
}

void check_text_body(TextReader& in, const Header& h) {
  for (const Element& e : h.elements)
    for (long long i = 0; i < e.number; ++i)
      for (const Property& p : e.properties) {
        const std::string what = text("a value of ", e.name, ' ', i);
        long long entries = 1;
        if (p.count_size > 0) {
          entries = in.integer(text("the list length of ", e.name, ' ', i));
          in.check_count(entries, text("list entries of ", e.name, ' ', i), 2);
        }
        for (long long k = 0; k < entries; ++k) in.number(what, true);
      }
  if (const auto extra = in.word()) in.fail("data ", quoted(*extra), " after the elements that the header announces");
}

void check_binary_body(const TextReader& in, const Header& h) {
  const std::string_view body = in.rest();
  std::size_t at = 0;
  for (const Element& e : h.elements)
    for (long long i = 0; i < e.number; ++i)
      for (const Property& p : e.properties) {
        std::size_t bytes = p.size;
        if (p.count_size > 0) {
          if (body.size() - at < p.count_size)
            in.fail("file ends in ", e.name, ' ', i, "; the header announces ", e.number);
          std::size_t entries = 0;
          for (std::size_t k = 0; k < p.count_size; ++k) {
            const auto byte = static_cast<unsigned char>(body[at + k]);
            entries |= static_cast<std::size_t>(byte) << 8 * (h.big_endian ? p.count_size - 1 - k : k);
          }
          at += p.count_size;
          bytes *= entries;
        }
        if (body.size() - at < bytes) in.fail("file ends in ", e.name, ' ', i, "; the header announces ", e.number);
        at += bytes;
      }
  if (at != body.size()) in.fail(body.size() - at, " bytes follow the elements that the header announces");
}

std::string plain_header(const Header& h) {
  std::string out = "ply\nformat " + h.format + " 1.0\n";
  for (const Element& e : h.elements) {
    out += text("element ", e.name, ' ', e.number, '\n');
    for (const Property& p : e.properties) out += p.line + "\n";
  }
  return out + "end_header\n";
}

}  // namespace

CheckedPly check_ply(const std::string& path, const std::string& data) {
  TextReader in(path, data);
  const Header h = read_header(in);
  const Element* vertex = nullptr;
  const Element* face = nullptr;
  for (const Element& e : h.elements) {
    if (e.properties.empty()) in.fail("element ", e.name, " has no properties");
    in.check_count(e.number, "elements " + e.name, h.ascii ? 2 * e.properties.size() : e.smallest());
    if (e.name == "vertex") vertex = &e;
    if (e.name == "face") face = &e;
  }
  if (!vertex) in.fail("the header has no element vertex");
  if (!face) in.fail("the header has no element face");
  const std::string body(in.rest());
  if (h.ascii)
    check_text_body(in, h);
  else
    check_binary_body(in, h);
  return {vertex->number, face->number, plain_header(h).append(body)};
}

}  // namespace kt
