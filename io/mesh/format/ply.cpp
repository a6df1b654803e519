// PLY, text and binary in either byte order, in the precision that the file has: every value is checked here anyway,
// and OpenMesh, which read these files before, has vertices of 32-bit floats only.
#include <cmath>
#include <limits>

#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/number_reader.hpp"
#include "io/mesh/polygon.hpp"

namespace kt {
namespace {

using Type = NumberType;

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
  std::string value_name = {}, list_name = {};  ///< for messages
  std::string shown() const { return name == "vertex" || name == "face" ? name : in_quotes(name); }
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

Type type_of(const TextReader& in, std::string_view name, bool integer) {
  if (name == "char" || name == "int8") return kInt8;
  if (name == "uchar" || name == "uint8") return kUInt8;
  if (name == "short" || name == "int16") return kInt16;
  if (name == "ushort" || name == "uint16") return kUInt16;
  if (name == "int" || name == "int32") return kInt32;
  if (name == "uint" || name == "uint32") return kUInt32;
  if (!integer && (name == "float" || name == "float32")) return kFloat32;
  if (!integer && (name == "double" || name == "float64")) return kFloat64;
  in.fail("property type ", in_quotes(name), " is not ", integer ? "an integer type" : "a PLY type");
}

void read_header_line(const TextReader& in, const std::vector<std::string_view>& word, Header& h) {
  const auto must_have = [&](std::size_t n) {
    if (word.size() != n) in.fail("header line ", in_quotes(word[0]), " has ", word.size(), " words; must be ", n);
  };
  if (word[0] == "format") {
    must_have(3);
    if (!h.format.empty()) in.fail("a second format line");
    h.format = word[1];
    h.ascii = word[1] == "ascii";
    h.big_endian = word[1] == "binary_big_endian";
    if (!h.ascii && !h.big_endian && word[1] != "binary_little_endian")
      in.fail("format ", in_quotes(word[1]), " is unknown");
  } else if (word[0] == "element") {
    must_have(3);
    Element e{std::string(word[1]), in.to_integer(word[2], "the number of elements"), {}};
    if (e.number < 0) in.fail("the number of elements ", e.shown(), " is ", e.number, "; must be at least 0");
    h.elements.push_back(e);
  } else if (word[0] == "property") {
    const bool list = word.size() > 1 && word[1] == "list";
    must_have(list ? 5 : 3);
    if (h.elements.empty()) in.fail("property before the first element");
    Property p{std::string(word.back()), type_of(in, word[list ? 3 : 1], false), {}};
    if (list) p.count = type_of(in, word[2], true);
    h.elements.back().properties.push_back(p);
  } else if (word[0] != "comment" && word[0] != "obj_info") {
    in.fail("unknown header line ", in_quotes(word[0]), "; known: format, comment, element, property, end_header");
  }
}

Header read_header(TextReader& in) {
  Header h;
  const auto first = in.line();
  if (!first || *first != "ply") in.fail("file starts with ", in_quotes(first.value_or("")), "; must start with ply");
  while (const auto line = in.line()) {
    if (line->empty()) continue;
    if (*line == "end_header") {
      if (h.format.empty()) in.fail("the header has no format line");
      return h;
    }
    read_header_line(in, split_words(*line), h);
  }
  in.fail("the header has no end_header");
}

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
    if (!p.is_list() || !p.type.is_integer()) in.fail("property ", p.name, " must be a list of integers");
    out.corners = &p;
  }
  if (!out.corners) in.fail("element face has no list vertex_indices");
  return out;
}

struct Faces {
  std::vector<int> corners;
  std::vector<std::size_t> first{0};
};

class BodyReader {
 public:
  BodyReader(NumberReader in, const Header& h, const Wanted& wanted, bool is_lenient)
      : in_(in), header_(h), wanted_(wanted), is_lenient_(is_lenient) {}

  void read(std::vector<double>& x, Faces& faces) {
    for (const Element& e : header_.elements)
      for (long long i = 0; i < e.number; ++i) {
        double point[3] = {};
        for (const Property& p : e.properties) read_property(e, i, p, point, faces);
        if (&e == wanted_.vertex) x.insert(x.end(), point, point + 3);
      }
  }

 private:
  void read_property(const Element& e, long long record, const Property& p, double* point, Faces& faces) {
    const int role = wanted_.role(p);
    if (role >= 0 && role < 3) {
      point[role] = in_.coordinate(p.type, What(kAxis[role], record), is_lenient_);
      return;
    }
    const long long entries = p.is_list() ? list_length(e, record, p) : 1;
    for (long long k = 0; k < entries; ++k)
      if (role == 3)
        faces.corners.push_back(corner(p, record));
      else
        in_.real(p.type, What(e.value_name, record));
    if (role != 3) return;
    if (entries < 3) in_.fail("face ", record, " has ", entries, " corners; must be at least 3");
    faces.first.push_back(faces.corners.size());
  }

  long long list_length(const Element& e, long long record, const Property& p) {
    const long long n = in_.integer(p.count, What(e.list_name, record));
    if (n < 0) in_.fail("a list of ", e.shown(), ' ', record, " has length ", n, "; must be at least 0");
    in_.check_count(n, "list entries", p.type.size, 1);
    return n;
  }

  int corner(const Property& p, long long face) {
    const long long index = in_.integer(p.type, What("a vertex index of face", face));
    if (index < 0 || index >= wanted_.vertex->number)
      in_.fail("vertex index ", index, " of face ", face, " is out of range 0..", wanted_.vertex->number - 1);
    return static_cast<int>(index);
  }

  static constexpr const char* kAxis[3] = {"coordinate x of vertex", "coordinate y of vertex",
                                           "coordinate z of vertex"};
  NumberReader in_;
  const Header& header_;
  const Wanted& wanted_;
  bool is_lenient_;
};

/// Blanks and line ends behind the last element are nothing; anything else means that the header does not fit.
void check_end(TextReader& in, const Header& h, Notes& notes) {
  const bool is_blank = in.rest().find_first_not_of(std::string_view(" \t\r\n\0", 5)) == std::string_view::npos;
  if (h.ascii) {
    if (const auto extra = in.word())
      in.fail("data ", in_quotes(*extra), " after the elements that the header announces");
  } else if (in.bytes_left() > 0) {
    if (!is_blank) in.fail(in.bytes_left(), " bytes follow the elements that the header announces");
    notes.push_back(text(in.bytes_left(), " blank bytes behind the last element ignored"));
  }
}

Header checked_header(TextReader& in) {
  Header h = read_header(in);
  for (Element& e : h.elements) {
    if (e.properties.empty()) in.fail("element ", e.shown(), " has no properties");
    in.check_count(e.number, "elements " + e.shown(), h.ascii ? 2 * e.properties.size() : e.smallest());
    e.value_name = "a value of " + e.shown();
    e.list_name = "the length of a list of " + e.shown();
  }
  return h;
}

}  // namespace

Mesh read_ply(const std::string& path, const LoadOptions& options, Notes& notes) {
  TextReader in(path, file_content(path, options));
  const Header h = checked_header(in);
  if (h.ascii) in.drop_last_nuls();
  const Wanted wanted = find_wanted(in, h);
  std::vector<double> x;
  Faces faces;
  NumberReader numbers(in);
  if (!h.ascii) numbers.use_bytes(h.big_endian ? std::endian::big : std::endian::little);
  BodyReader(numbers, h, wanted, options.lenient).read(x, faces);
  check_end(in, h, notes);
  Mesh mesh;
  mesh.x = Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
  PolygonTriangulator triangulator;
  for (std::size_t f = 0; f + 1 < faces.first.size(); ++f)
    triangulator.add(mesh.x, std::span(faces.corners).subspan(faces.first[f], faces.first[f + 1] - faces.first[f]),
                     mesh.triangles);
  for (std::string& note : triangulator.notes()) notes.push_back(std::move(note));
  return mesh;
}

}  // namespace kt
