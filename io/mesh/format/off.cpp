// OFF: free white space, comments anywhere, counts on one or several lines, extras of COFF, NOFF and STOFF skipped.
#include "io/files/output_file.hpp"
#include "io/files/text_reader.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/polygon.hpp"

namespace kt {
namespace {

struct OffHeader {
  bool st = false, colour = false, normal = false, homogeneous = false;
  int vertices = 0, faces = 0;
};

/// What stands before OFF, in any order: programs do not agree on it.
std::string_view read_prefixes(const TextReader& in, std::string_view keyword, OffHeader& h) {
  const std::string_view whole = keyword;
  const auto take = [&](std::string_view prefix, bool& found) {
    if (found || !keyword.starts_with(prefix)) return false;
    keyword.remove_prefix(prefix.size());
    return found = true;
  };
  while (take("ST", h.st) || take("C", h.colour) || take("N", h.normal) || take("4", h.homogeneous)) {
  }
  if (keyword.starts_with("n")) in.fail("keyword ", in_quotes(whole), ": only three-dimensional OFF is supported");
  bool off = false;
  if (!take("OFF", off))
    in.fail("file starts with ", in_quotes(whole), "; must start with OFF, COFF, NOFF, NCOFF, STOFF or 4OFF");
  return keyword;
}

/// The keyword may be glued to the first count ("OFF8 6 12" is legal) or be missing altogether.
OffHeader read_header(TextReader& in, Notes& notes) {
  OffHeader h;
  const auto first = in.word();
  if (!first) in.fail("file holds no data, only blanks and comments");
  std::string_view counts = *first;
  const bool bare = first->find_first_not_of("0123456789") == std::string_view::npos;
  if (bare)
    notes.push_back("the keyword OFF is missing");
  else
    counts = read_prefixes(in, *first, h);
  long long n[3] = {0, 0, 0};
  constexpr std::string_view kWhat[3] = {"the number of vertices", "the number of faces", "the number of edges"};
  for (int i = 0; i < 3; ++i) {
    if (i == 0 && !counts.empty()) {
      n[i] = in.to_integer(counts, kWhat[i]);
      continue;
    }
    // The edge count is unused and often wrong or missing: it may only stand on the line of the face count or be alone.
    const auto token = i == 2 ? in.word_on_line() : in.word();
    if (!token && i == 2) break;
    if (!token) in.fail("file ends where ", kWhat[i], " should be");
    if (*token == "BINARY") in.fail("binary OFF is not supported; write it as text");
    n[i] = in.to_integer(*token, kWhat[i]);
  }
  in.check_count(n[0], "vertices", 6);  // "0 0 0\n"
  in.check_count(n[1], "faces", 8);     // "3 0 0 0\n"
  h.vertices = static_cast<int>(n[0]);
  h.faces = static_cast<int>(n[1]);
  return h;
}

constexpr int kToLineEnd = -1;

/// How many values follow the coordinates of a vertex. Colours have no fixed count: they end with the line.
int number_of_extras(const OffHeader& h) { return h.colour ? kToLineEnd : (h.normal ? 3 : 0) + (h.st ? 2 : 0); }

/// How the values of the vertices are laid out, if each has a line of its own.
struct VertexLines {
  int values = 0;    ///< on the first line
  int odd_line = 0;  ///< number of the first line that has another number of values; 0: none
  int odd_values = 0;
};

VertexLines look_at_lines(TextReader& in, int vertices) {
  VertexLines out;
  for (int i = 0; i < vertices; ++i) {
    int values = in.word() ? 1 : 0;
    const int line = in.line_number();
    while (values > 0 && in.word_on_line()) ++values;
    if (i == 0)
      out.values = values;
    else if (values != out.values)
      return {out.values, line, values};
  }
  return out;
}

void read_vertices(TextReader& in, const OffHeader& header, int extras, bool is_lenient, Mesh& mesh) {
  mesh.x.resize(3 * header.vertices);
  constexpr const char* kAxis[3] = {"x coordinate of vertex", "y coordinate of vertex", "z coordinate of vertex"};
  for (int i = 0; i < header.vertices; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto token = in.word();
      if (!token) in.fail("file ends at vertex ", i, "; the header announces ", header.vertices);
      mesh.x[3 * i + k] = in.to_coordinate(*token, What(kAxis[k], i), is_lenient);
    }
    if (header.homogeneous)
      if (const double w = in.number(What("the weight of vertex", i)); w != 1)
        in.fail("the weight of vertex ", i, " is ", w, "; must be 1: points at infinity have no place in a mesh");
    for (int k = 0; k < extras; ++k) in.number(What("a value behind the coordinates of vertex", i), true);
    if (extras == kToLineEnd)
      while (const auto extra = in.word_on_line()) in.to_number(*extra, What("a value behind vertex", i), true);
  }
}

void read_faces(TextReader& in, const OffHeader& header, Mesh& mesh, Notes& notes) {
  PolygonTriangulator triangulator;
  std::vector<int> polygon;
  for (int f = 0; f < header.faces; ++f) {
    const auto size = in.word();
    if (!size) in.fail("file ends at face ", f, "; the header announces ", header.faces);
    const long long corners = in.to_integer(*size, What("the number of corners of face", f));
    if (corners < 3) in.fail("face ", f, " has ", corners, " corners; must be at least 3");
    in.check_count(corners, "corners", 2);
    polygon.clear();
    for (long long c = 0; c < corners; ++c) {
      const long long index = in.integer(What("a vertex index of face", f));
      if (index < 0 || index >= header.vertices)
        in.fail("vertex index ", index, " of face ", f, " is out of range 0..", header.vertices - 1);
      polygon.push_back(static_cast<int>(index));
    }
    int colours = 0;
    while (const auto extra = in.word_on_line()) {
      in.to_number(*extra, What("colour of face", f), true);
      if (++colours > 4) in.fail("more than 4 values follow the ", corners, " corners of face ", f);
    }
    triangulator.add(mesh.x, polygon, mesh.triangles);
  }
  if (const auto extra = in.word())
    in.fail("data ", in_quotes(*extra), " after the ", header.vertices, " vertices and ", header.faces,
            " faces that the header announces");
  for (std::string& note : triangulator.notes()) notes.push_back(std::move(note));
}

Mesh read_body(TextReader& in, const OffHeader& header, int extras, bool is_lenient, Notes& notes) {
  Mesh mesh;
  read_vertices(in, header, extras, is_lenient, mesh);
  read_faces(in, header, mesh, notes);
  return mesh;
}

}  // namespace

/// White space is free, so that vertices may come several on a line; but many programs write colours or normals under a
/// plain header. What makes no sense the first way is read the second way, if all lines of vertices are alike.
Mesh read_off(const std::string& path, const LoadOptions& options, Notes& notes) {
  TextReader in(path, text_content(path, options));
  const OffHeader header = read_header(in, notes);
  const TextReader::Bookmark body = in.bookmark();
  try {
    return read_body(in, header, number_of_extras(header), options.lenient, notes);
  } catch (const InputError& error) {
    if (header.homogeneous) throw;
    in.go_back(body);
    const VertexLines lines = look_at_lines(in, header.vertices);
    if (lines.odd_line > 0 && lines.values >= 3 && lines.odd_values > lines.values)
      throw InputError(text(error.what(), " (line ", lines.odd_line, " has ", lines.odd_values,
                            " values, those of the vertices before it ", lines.values, ")"));
    if (lines.odd_line > 0 || lines.values <= 3) throw;
    in.go_back(body);
    notes.push_back(
        text("the ", lines.values - 3,
             " values behind the coordinates of each vertex, which the header does not announce, are ignored"));
    return read_body(in, header, lines.values - 3, options.lenient, notes);
  }
}

std::string write_off(const Mesh& mesh) {
  std::string out = text("OFF\n", mesh.num_nodes(), ' ', mesh.triangles.size(), " 0\n");
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    for (int k = 0; k < 3; ++k) {
      if (k > 0) out += ' ';
      append_number(out, mesh.x[3 * i + k]);
    }
    out += '\n';
  }
  for (const Triangle& t : mesh.triangles) out += text("3 ", t[0], ' ', t[1], ' ', t[2], '\n');
  return out;
}

}  // namespace kt
