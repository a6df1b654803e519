// Wavefront OBJ: v and f in full (slashes, negative indices, polygons, per-vertex colours, joined lines); every other
// known statement is skipped; an unknown one is an error.
#include <algorithm>
#include <array>
#include <limits>
#include <optional>

#include "io/files/output_file.hpp"
#include "io/files/text_reader.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/polygon.hpp"

namespace kt {
namespace {

constexpr std::array<std::string_view, 38> kSkipped = {
    "vt",    "vn",     "vp",    "g",        "o",        "s",          "l",         "p",      "usemtl", "mtllib",
    "mg",    "lod",    "bevel", "d_interp", "c_interp", "shadow_obj", "trace_obj", "maplib", "usemap", "ctech",
    "stech", "cstype", "deg",   "bmat",     "step",     "curv",       "curv2",     "surf",   "parm",   "trim",
    "hole",  "scrv",   "sp",    "end",      "con",      "bzp",        "call",      "csh"};

bool is_statement(std::string_view word) {
  return word == "v" || word == "f" || std::find(kSkipped.begin(), kSkipped.end(), word) != kSkipped.end();
}

/// Statement after statement, without comments and blank lines. `\` at a line's end joins it with the next one, unless
/// that one is a statement of its own: names of materials and groups end in a backslash too.
class Statements {
 public:
  explicit Statements(TextReader& in) : in_(in) {}

  /// The words of the next statement; empty at the end of the file. They are valid until the next call.
  std::vector<std::string_view> next() {
    while (const auto line = physical_line()) {
      line_ = in_.line_number();
      joined_ = *line;
      while (joined_.ends_with('\\') && join_next_line()) {
      }
      if (std::vector<std::string_view> words = split_words(joined_); !words.empty()) return words;
    }
    return {};
  }
  int line_number() const { return line_; }  ///< of the statement's first line
  int not_joined() const { return not_joined_; }

 private:
  std::optional<std::string_view> physical_line() {
    auto line = in_.line();
    if (line) *line = line->substr(0, line->find('#'));
    while (line && (line->ends_with(' ') || line->ends_with('\t'))) line->remove_suffix(1);
    return line;
  }

  bool join_next_line() {
    joined_.back() = ' ';  // the backslash
    const TextReader::Bookmark place = in_.bookmark();
    const auto more = physical_line();
    if (!more) return false;
    if (const auto words = split_words(*more); !words.empty() && is_statement(words[0])) {
      in_.go_back(place);
      ++not_joined_;
      return false;
    }
    joined_ += *more;
    return true;
  }

  TextReader& in_;
  std::string joined_;
  int line_ = 1, not_joined_ = 0;
};

/// "12", "12/3", "12//4", "12/3/4" and the odd "12//": the vertex index, from 0; the others need only be integers.
long long corner(const TextReader& in, std::string_view token, long long vertices_so_far) {
  std::string_view rest = token;
  std::array<std::string_view, 3> part;
  std::size_t parts = 0;
  for (bool more = true; more;) {
    const std::size_t slash = rest.find('/');
    more = slash != std::string_view::npos;
    if (parts == 3) in.fail("face corner ", in_quotes(token), " has more than two slashes");
    part[parts++] = rest.substr(0, slash);
    if (more) rest.remove_prefix(slash + 1);
  }
  for (std::size_t i = 1; i < parts; ++i)
    if (!part[i].empty()) in.to_integer(part[i], i == 1 ? "texture index" : "normal index");
  const long long index = in.to_integer(part[0], "vertex index");
  if (index == 0) in.fail("vertex index is 0; OBJ counts from 1 (or from -1 backwards)");
  if (index < -vertices_so_far)
    in.fail("vertex index ", index, " reaches before the first vertex; ", vertices_so_far,
            " vertices precede this face");
  return index > 0 ? index - 1 : vertices_so_far + index;
}

struct Polygons {
  std::vector<long long> corners;
  std::vector<std::size_t> first{0};
  std::vector<int> line;
};

}  // namespace

Mesh read_obj(const std::string& path, const LoadOptions& options, Notes& notes) {
  TextReader in(path, text_content(path, options));
  std::vector<double> x;
  Polygons polygons;
  int lines_and_points = 0;
  Statements statements(in);
  for (auto words = statements.next(); !words.empty(); words = statements.next()) {
    const std::size_t values = words.size() - 1;
    in.say_line(statements.line_number());
    if (words[0] == "v") {
      if (values != 3 && values != 4 && values != 6 && values != 7)
        in.fail("vertex has ", values, " numbers; must be 3 (x y z), 4 (with w), 6 (with colour) or 7");
      for (std::size_t i = 1; i <= values; ++i) {
        const double value = i <= 3 ? in.to_coordinate(words[i], "coordinate", options.lenient)
                                    : in.to_number(words[i], "vertex value", options.lenient);
        if (i <= 3) x.push_back(value);
        if (i == 4 && values == 4 && value != 1)
          in.fail("vertex weight ", in_quotes(words[i]), " is not 1; rational geometry is not supported");
      }
    } else if (words[0] == "f") {
      if (values < 3) in.fail("face has ", values, " corners; must be at least 3");
      for (std::size_t i = 1; i <= values; ++i)
        polygons.corners.push_back(corner(in, words[i], static_cast<long long>(x.size() / 3)));
      polygons.first.push_back(polygons.corners.size());
      polygons.line.push_back(in.line_number());
    } else if (std::find(kSkipped.begin(), kSkipped.end(), words[0]) == kSkipped.end()) {
      in.fail("unknown statement ", in_quotes(words[0]), "; known: v, f and vt vn g o s l p usemtl mtllib (skipped)");
    } else if (words[0] == "l" || words[0] == "p") {
      ++lines_and_points;
    }
  }
  if (x.size() / 3 > std::numeric_limits<int>::max() / 4) in.fail("too many vertices: ", x.size() / 3);
  if (statements.not_joined() > 0)
    notes.push_back(text(statements.not_joined(),
                         " lines end in a backslash but are followed by a statement, which is read as one"));
  if (lines_and_points > 0) notes.push_back(text(lines_and_points, " line and point elements skipped"));

  Mesh mesh;
  mesh.x = Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
  PolygonTriangulator triangulator;
  std::vector<int> polygon;
  for (std::size_t f = 0; f + 1 < polygons.first.size(); ++f) {
    polygon.clear();
    for (std::size_t i = polygons.first[f]; i < polygons.first[f + 1]; ++i) {
      const long long index = polygons.corners[i];
      if (index >= mesh.num_nodes())
        in.fail_at(polygons.line[f], "vertex index ", index + 1, " is out of range; the file has ", mesh.num_nodes(),
                   " vertices");
      polygon.push_back(static_cast<int>(index));
    }
    triangulator.add(mesh.x, polygon, mesh.triangles);
  }
  for (std::string& note : triangulator.notes()) notes.push_back(std::move(note));
  return mesh;
}

std::string write_obj(const Mesh& mesh) {
  std::string out;
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    out += 'v';
    for (int k = 0; k < 3; ++k) append_number(out += ' ', mesh.x[3 * i + k]);
    out += '\n';
  }
  for (const Triangle& t : mesh.triangles) out += text("f ", t[0] + 1, ' ', t[1] + 1, ' ', t[2] + 1, '\n');
  return out;
}

}  // namespace kt
