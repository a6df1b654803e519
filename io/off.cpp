// OFF: free white space, comments anywhere, counts on one or several lines, extras of COFF, NOFF and STOFF skipped.
#include "io/mesh_formats.hpp"
#include "io/output_file.hpp"
#include "io/polygon.hpp"
#include "io/text_reader.hpp"

namespace kt {
namespace {

struct OffHeader {
  bool st = false, colour = false, normal = false;
  int vertices = 0, faces = 0;
};

/// The keyword may be glued to the first count ("OFF8 6 12" is legal) or be missing altogether.
OffHeader read_header(TextReader& in, Notes& notes) {
  OffHeader h;
  const auto first = in.word();
  if (!first) in.fail("file holds no data, only blanks and comments");
  std::string_view keyword = *first;
  const auto take = [&](std::string_view prefix) {
    const bool found = keyword.starts_with(prefix);
    if (found) keyword.remove_prefix(prefix.size());
    return found;
  };
  std::string_view counts = *first;
  const bool bare = first->find_first_not_of("0123456789") == std::string_view::npos;
  if (bare) {
    notes.push_back("the keyword OFF is missing");
  } else {
    h.st = take("ST");
    h.colour = take("C");
    h.normal = take("N");
    if (keyword.starts_with("4") || keyword.starts_with("n"))
      in.fail("keyword ", quoted(*first), ": only three-dimensional OFF is supported");
    if (!take("OFF")) in.fail("file starts with ", quoted(*first), "; must start with OFF, COFF, NOFF or STOFF");
    counts = keyword;
  }
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

/// Values after the coordinates. Colours have no fixed count: they end with the line.
void skip_vertex_extras(TextReader& in, const OffHeader& h) {
  const int fixed = (h.normal ? 3 : 0) + (h.st ? 2 : 0);
  if (h.colour) {
    while (const auto extra = in.word_on_line()) in.to_number(*extra, "vertex value", true);
  } else {
    for (int i = 0; i < fixed; ++i) in.number("vertex normal or texture value", true);
  }
}

}  // namespace

Mesh read_off(const std::string& path, const LoadOptions& options, Notes& notes) {
  TextReader in(path, text_content(path, options));
  const OffHeader header = read_header(in, notes);
  Mesh mesh;
  mesh.x.resize(3 * header.vertices);
  constexpr std::string_view kAxis[3] = {"x coordinate", "y coordinate", "z coordinate"};
  for (int i = 0; i < header.vertices; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto token = in.word();
      if (!token) in.fail("file ends at vertex ", i, "; the header announces ", header.vertices);
      mesh.x[3 * i + k] = in.to_number(*token, text(kAxis[k], " of vertex ", i), options.lenient);
    }
    skip_vertex_extras(in, header);
  }
  PolygonTriangulator triangulator;
  std::vector<int> polygon;
  for (int f = 0; f < header.faces; ++f) {
    const auto size = in.word();
    if (!size) in.fail("file ends at face ", f, "; the header announces ", header.faces);
    const long long corners = in.to_integer(*size, text("the number of corners of face ", f));
    if (corners < 3) in.fail("face ", f, " has ", corners, " corners; must be at least 3");
    in.check_count(corners, "corners", 2);
    polygon.clear();
    for (long long c = 0; c < corners; ++c) {
      const long long index = in.integer(text("a vertex index of face ", f));
      if (index < 0 || index >= header.vertices)
        in.fail("vertex index ", index, " of face ", f, " is out of range 0..", header.vertices - 1);
      polygon.push_back(static_cast<int>(index));
    }
    int colours = 0;
    while (const auto extra = in.word_on_line()) {
      in.to_number(*extra, text("colour of face ", f), true);
      if (++colours > 4) in.fail("more than 4 values follow the ", corners, " corners of face ", f);
    }
    triangulator.add(mesh.x, polygon, mesh.triangles);
  }
  if (const auto extra = in.word())
    in.fail("data ", quoted(*extra), " after the ", header.vertices, " vertices and ", header.faces,
            " faces that the header announces");
  for (std::string& note : triangulator.notes()) notes.push_back(std::move(note));
  return mesh;
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
