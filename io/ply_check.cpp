#include "io/ply_check.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <vector>

#include "io/text_reader.hpp"

namespace kt {
namespace {

struct Type {
  enum class Kind { signed_integer, unsigned_integer, real } kind = Kind::real;
  std::size_t size = 0;  ///< bytes; 0: none
};
struct Property {
  std::string name;
  Type type;   ///< of a value, or of one list entry
  Type count;  ///< of a list's length; none: not a list
  bool is_list() const { return count.size > 0; }
};
struct Element {
  std::string name;
  long long number = 0;
  std::vector<Property> properties;
  std::string shown() const { return name == "vertex" || name == "face" ? name : quoted(name); }
  std::size_t smallest() const {  ///< bytes of one record with empty lists
    std::size_t sum = 0;
    for (const Property& p : properties) sum += p.is_list() ? p.count.size : p.type.size;
    return sum;
  }
};
struct Header {
  std::string format;
  bool ascii = false, big_endian = false;
  std::vector<Element> elements;
};

Type type_of(const TextReader& in, const std::string& name, bool integer) {
  using Kind = Type::Kind;
  if (name == "char" || name == "int8") return {Kind::signed_integer, 1};
  if (name == "uchar" || name == "uint8") return {Kind::unsigned_integer, 1};
  if (name == "short" || name == "int16") return {Kind::signed_integer, 2};
  if (name == "ushort" || name == "uint16") return {Kind::unsigned_integer, 2};
  if (name == "int" || name == "int32") return {Kind::signed_integer, 4};
  if (name == "uint" || name == "uint32") return {Kind::unsigned_integer, 4};
  if (!integer && (name == "float" || name == "float32")) return {Kind::real, 4};
  if (!integer && (name == "double" || name == "float64")) return {Kind::real, 8};
  in.fail("property type ", quoted(name), " is not ", integer ? "an integer type" : "a PLY type");
}

void read_header_line(const TextReader& in, const std::vector<std::string>& word, Header& h) {
  const auto must_have = [&](std::size_t n) {
    if (word.size() != n) in.fail("header line ", quoted(word[0]), " has ", word.size(), " words; must be ", n);
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
    Element e{word[1], in.to_integer(word[2], text("the number of elements ", quoted(word[1]))), {}};
    if (e.number < 0) in.fail("the number of elements ", e.shown(), " is ", e.number, "; must be at least 0");
    h.elements.push_back(e);
  } else if (word[0] == "property") {
    const bool list = word.size() > 1 && word[1] == "list";
    must_have(list ? 5 : 3);
    if (h.elements.empty()) in.fail("property before the first element");
    Property p{word.back(), type_of(in, word[list ? 3 : 1], false), {}};
    if (list) p.count = type_of(in, word[2], true);
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

/// The values of a text body, one after the other.
class TextBody {
 public:
  explicit TextBody(TextReader& in) : in_(in) {}
  void enter(const Element& e, long long record) { what_ = text("a value of ", e.shown(), ' ', record); }
  long long list_length(const Type&) {
    const long long n = in_.integer("the length of a list");
    in_.check_count(n, "list entries", 2);
    return n;
  }
  double real(const Type&) { return in_.number(what_, true); }
  long long integer(const Type&) { return in_.integer(what_); }
  void end() {
    if (const auto extra = in_.word())
      in_.fail("data ", quoted(*extra), " after the elements that the header announces");
  }

 private:
  TextReader& in_;
  std::string what_;
};

/// The same of a binary body.
class BinaryBody {
 public:
  BinaryBody(const TextReader& in, bool big_endian) : in_(in), body_(in.rest()), big_endian_(big_endian) {}
  void enter(const Element& e, long long record) {
    element_ = &e;
    record_ = record;
  }
  long long list_length(const Type& type) {
    const long long n = integer(type);
    if (n < 0) in_.fail("a list of ", element_->shown(), ' ', record_, " has length ", n, "; must be at least 0");
    return n;
  }
  double real(const Type& type) {
    if (type.kind != Type::Kind::real) return static_cast<double>(integer(type));
    const std::uint64_t bits = take(type.size);
    return type.size == 8 ? std::bit_cast<double>(bits)
                          : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
  }
  long long integer(const Type& type) {
    const std::uint64_t bits = take(type.size);
    const bool is_negative = type.kind == Type::Kind::signed_integer && (bits >> (8 * type.size - 1)) != 0;
    return static_cast<long long>(bits) - (is_negative ? 1LL << 8 * type.size : 0);
  }
  void end() {
    if (!body_.empty()) in_.fail(body_.size(), " bytes follow the elements that the header announces");
  }

 private:
  std::uint64_t take(std::size_t size) {
    if (body_.size() < size)
      in_.fail("file ends in ", element_->shown(), ' ', record_, "; the header announces ", element_->number);
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const auto byte = static_cast<unsigned char>(body_[i]);
      bits |= static_cast<std::uint64_t>(byte) << 8 * (big_endian_ ? size - 1 - i : i);
    }
    body_.remove_prefix(size);
    return bits;
  }
  const TextReader& in_;
  std::string_view body_;
  bool big_endian_;
  const Element* element_ = nullptr;
  long long record_ = 0;
};

/// Which properties are coordinates and corners: of elements "vertex" and "face", each there once.
struct Wanted {
  const Element *vertex = nullptr, *face = nullptr;
  const Property *axis[3] = {}, *corners = nullptr;

  /// 0 1 2: x y z; 3: corners; -1: of no interest.
  int role(const Property& p) const {
    for (int k = 0; k < 3; ++k)
      if (&p == axis[k]) return k;
    return &p == corners ? 3 : -1;
  }
};

const Element* find_once(const TextReader& in, const Header& h, const std::string& name) {
  const Element* found = nullptr;
  for (const Element& e : h.elements) {
    if (e.name != name) continue;
    if (found) in.fail("the header has two elements ", name);
    found = &e;
  }
  if (!found) in.fail("the header has no element ", name);
  return found;
}

Wanted find_wanted(const TextReader& in, const Header& h) {
  Wanted out{find_once(in, h, "vertex"), find_once(in, h, "face")};
  for (const Property& p : out.vertex->properties)
    for (int k = 0; k < 3; ++k) {
      if (p.name != std::string(1, "xyz"[k])) continue;
      if (out.axis[k] || p.is_list()) in.fail("element vertex has a property ", p.name, " twice, or as a list");
      out.axis[k] = &p;
    }
  for (int k = 0; k < 3; ++k)
    if (!out.axis[k]) in.fail("element vertex has no property ", "xyz"[k]);
  for (const Property& p : out.face->properties) {
    if (p.name != "vertex_index" && p.name != "vertex_indices") continue;
    if (out.corners) in.fail("element face has two lists of vertices");
    if (!p.is_list() || p.type.kind == Type::Kind::real) in.fail("property ", p.name, " must be a list of integers");
    out.corners = &p;
  }
  if (!out.corners) in.fail("element face has no list vertex_indices");
  return out;
}

template <class T>
void append(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

float to_float(const TextReader& in, double value, long long vertex) {
  if (std::isfinite(value) && std::abs(value) > static_cast<double>(std::numeric_limits<float>::max()))
    in.fail("coordinate ", value, " of vertex ", vertex, " is beyond the range of a 32-bit float (3.4e38)");
  return static_cast<float>(value);
}

/// The coordinates, then the faces, as the body of a binary file.
template <class Body>
std::string read_body(const TextReader& in, Body body, const Header& h, const Wanted& wanted) {
  std::string vertices, faces;
  for (const Element& e : h.elements)
    for (long long i = 0; i < e.number; ++i) {
      body.enter(e, i);
      float x[3] = {};
      for (const Property& p : e.properties) {
        const int role = wanted.role(p);
        const long long entries = p.is_list() ? body.list_length(p.count) : 1;
        if (role == 3) append(faces, static_cast<std::int32_t>(entries));
        for (long long k = 0; k < entries; ++k) {
          if (role == 3) {
            const long long index = body.integer(p.type);
            if (index < 0 || index >= wanted.vertex->number)
              in.fail("vertex index ", index, " of face ", i, " is out of range 0..", wanted.vertex->number - 1);
            append(faces, static_cast<std::int32_t>(index));
          } else if (const double value = body.real(p.type); role >= 0) {
            x[role] = to_float(in, value, i);
          }
        }
      }
      if (&e == wanted.vertex)
        for (const float value : x) append(vertices, value);
    }
  body.end();
  return vertices + faces;
}

std::string plain_header(const Wanted& wanted) {
  return text("ply\nformat binary_little_endian 1.0\nelement vertex ", wanted.vertex->number,
              "\nproperty float x\nproperty float y\nproperty float z\nelement face ", wanted.face->number,
              "\nproperty list int int vertex_indices\nend_header\n");
}

}  // namespace

CheckedPly check_ply(const std::string& path, const std::string& data) {
  TextReader in(path, data);
  const Header h = read_header(in);
  for (const Element& e : h.elements) {
    if (e.properties.empty()) in.fail("element ", e.shown(), " has no properties");
    in.check_count(e.number, "elements " + e.shown(), h.ascii ? 2 * e.properties.size() : e.smallest());
  }
  const Wanted wanted = find_wanted(in, h);
  std::string body =
      h.ascii ? read_body(in, TextBody(in), h, wanted) : read_body(in, BinaryBody(in, h.big_endian), h, wanted);
  return {wanted.vertex->number, wanted.face->number, plain_header(wanted) + body};
}

}  // namespace kt
