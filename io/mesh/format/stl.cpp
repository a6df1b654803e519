// STL, text and binary, in the precision that the file has. OpenMesh, which read these files before, takes text numbers
// as 32-bit floats and knows keywords in small letters only.
#include <algorithm>
#include <limits>

#include "io/mesh/edge_table.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/number_reader.hpp"
#include "io/mesh/weld.hpp"

namespace kt {
namespace {

constexpr std::size_t kHeader = 84, kTriangle = 50;  // bytes

/// The corners of a text STL: keywords in any case, closing ones as one word or two, several solids.
class TextStl {
 public:
  TextStl(TextReader& in, bool is_lenient) : in_(in), is_lenient_(is_lenient) {}

  std::vector<double> read(Notes& notes) {
    while (const auto word = in_.word()) {
      if (is_keyword("solid", *word)) {
        ++solids_;
        in_.skip_line();  // a name of any words
        is_open_ = true;
      } else if (!is_open_) {
        behind_the_end(*word, notes);
      } else if (equals_any_case(*word, "vertex")) {
        for (int k = 0; k < 3; ++k) x_.push_back(in_.coordinate("a vertex coordinate", is_lenient_));
      } else if (is_end_of("facet", *word)) {
        if (x_.size() != 9 * ++facets_) in_.fail("facet ", facets_ - 1, " has not 3 vertices");
      } else if (is_end_of("solid", *word)) {
        in_.skip_line();
        is_open_ = false;
      }
      last_ = *word;
    }
    if (is_open_) in_.fail("file ends without endsolid: it is truncated");
    if (x_.size() != 9 * facets_) in_.fail("vertices follow the last facet");
    if (solids_ > 1) notes.push_back(text(solids_, " solids in the file, taken together"));
    return std::move(x_);
  }

 private:
  /// The word itself, not the second half of "end solid".
  bool is_keyword(std::string_view name, std::string_view word) const {
    return equals_any_case(word, name) && !equals_any_case(last_, "end");
  }
  /// "endsolid", or the second word of "end solid".
  bool is_end_of(std::string_view name, std::string_view word) const {
    return equals_any_case(word, "end" + std::string(name)) ||
           (equals_any_case(word, name) && equals_any_case(last_, "end"));
  }

  void behind_the_end(std::string_view word, Notes& notes) {
    if (equals_any_case(word, "facet") || equals_any_case(word, "vertex"))
      in_.fail("found ", in_quotes(word), " after endsolid; must be solid, or the end of the file");
    const std::string note = "text behind endsolid ignored";
    if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
  }

  TextReader& in_;
  bool is_lenient_, is_open_ = false;
  std::vector<double> x_;
  std::size_t facets_ = 0;
  int solids_ = 0;
  std::string_view last_;
};

std::vector<double> read_binary(TextReader& file, std::uint32_t n, const LoadOptions& options, Notes& notes) {
  NumberReader in(file);
  in.use_bytes(std::endian::little);
  file.skip_bytes(kHeader);
  std::vector<double> x;
  x.reserve(std::size_t{9} * n);  // the file is as long
  for (std::uint32_t i = 0; i < n; ++i) {
    file.skip_bytes(12);  // the normal
    for (int k = 0; k < 9; ++k)
      x.push_back(in.coordinate(kFloat32,
                                What(k % 3 == 0   ? "coordinate x of a corner of triangle"
                                     : k % 3 == 1 ? "coordinate y of a corner of triangle"
                                                  : "coordinate z of a corner of triangle",
                                     i),
                                options.lenient));
    file.skip_bytes(2);
  }
  if (file.bytes_left() > 0)
    notes.push_back(
        text(file.bytes_left(), " bytes behind the ", n, " triangles that the header announces are ignored"));
  return x;
}

bool starts_with_solid(std::string_view data) {
  if (data.starts_with("\xEF\xBB\xBF")) data.remove_prefix(3);
  data.remove_prefix(std::min(data.find_first_not_of(" \t\r\n"), data.size()));
  return equals_any_case(data.substr(0, 5), "solid");
}

/// Binary STL: 80 bytes, a count, 50 bytes a triangle. A text STL starts with "solid", but so do some binary ones: the
/// size decides, and else a NUL, which a count of less than 16 million triangles has.
bool is_text(std::string_view data, std::size_t expected) {
  if (!starts_with_solid(data) || data.size() == expected) return false;
  return data.size() < kHeader || data.substr(0, kHeader).find('\0') == std::string_view::npos;
}

struct Corners {
  std::vector<double> x;
  bool from_text = false;
};

Corners read_corners(const std::string& path, const LoadOptions& options, Notes& notes) {
  std::string data = file_content(path, options);
  const std::uint32_t n =
      data.size() < kHeader ? 0 : static_cast<std::uint32_t>(bits_of(data.substr(80, 4), 4, std::endian::little));
  const std::size_t expected = data.size() < kHeader ? 0 : kHeader + kTriangle * n, size = data.size();
  if (is_text(data, expected)) {
    while (!data.empty() && data.back() == '\0') data.pop_back();
    TextReader in(path, std::move(data));
    return {TextStl(in, options.lenient).read(notes), true};
  }
  if (size < kHeader) throw InputError(text(path, ": ", size, " bytes are too few for an STL file"));
  if (size < expected || (n == 0 && size > expected))
    throw InputError(text(path, ": binary STL announces ", n, " triangles (", expected, " bytes) but the file has ",
                          size, " bytes"));
  TextReader in(path, std::move(data));
  return {read_binary(in, n, options, notes), false};
}

}  // namespace

/// STL repeats every corner: those in one place are one node. In a text they may differ in the last digit that a double
/// has.
Mesh read_stl(const std::string& path, const LoadOptions& options, Notes& notes) {
  const auto [x, from_text] = read_corners(path, options, notes);
  if (x.size() / 3 > std::numeric_limits<int>::max() / 4)
    throw InputError(text(path, ": too many triangles: ", x.size() / 9));
  Mesh mesh;
  mesh.x = Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
  for (int i = 0; i < mesh.num_nodes(); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
  const int corners = mesh.num_nodes();
  join_nodes(mesh, from_text ? rounding_of(mesh) : 0);
  drop_unused_nodes(mesh);
  if (const std::size_t dropped = std::erase_if(mesh.triangles, repeats_node); dropped > 0) {
    if (mesh.triangles.empty())
      throw InputError(text(path, ": no triangles: all ", dropped,
                            " have equal corners (were digits lost, as of a far "
                            "origin in floats?)"));
    notes.push_back(text(dropped, " of ", corners / 3, " triangles have equal corners and are left out"));
    drop_unused_nodes(mesh);
  }
  notes.push_back(text(corners, " triangle corners joined to ", mesh.num_nodes(), " vertices by equal coordinates"));
  return mesh;
}

}  // namespace kt
