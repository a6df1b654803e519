// Medit .mesh as text (also of MMG and FreeFem): vertices, triangles, quadrilaterals and tetrahedra; everything else
// that the format has is skipped.
#include <algorithm>
#include <array>
#include <optional>

#include "core/base/numbers.hpp"
#include "io/files/text_reader.hpp"
#include "io/mesh/cells.hpp"
#include "io/mesh/mesh_formats.hpp"

namespace kt {
namespace {

/// Marks, normals and what adaptive meshing needs; in small letters.
constexpr std::array<std::string_view, 18> kSkipped = {"corners",
                                                       "ridges",
                                                       "requiredvertices",
                                                       "requirededges",
                                                       "requiredtriangles",
                                                       "requiredquadrilaterals",
                                                       "normals",
                                                       "normalatvertices",
                                                       "normalattrianglevertices",
                                                       "normalatquadrilateralvertices",
                                                       "tangents",
                                                       "tangentatvertices",
                                                       "tangentatedges",
                                                       "geometry",
                                                       "identifier",
                                                       "angleofcornerbound",
                                                       "subdomainfrommesh",
                                                       "subdomainfromgeom"};

class MeditReader {
 public:
  MeditReader(const std::string& path, const LoadOptions& options, Notes& notes)
      : in_(path, text_content(path, options)), options_(options), notes_(notes) {}

  Mesh read() {
    read_header();
    for (auto keyword = next_keyword(); keyword && !equals_any_case(*keyword, "end"); keyword = next_keyword())
      read_section(*keyword);
    return cells_.finish(Eigen::Map<const VectorX>(x_.data(), static_cast<Eigen::Index>(x_.size())), true, in_.path(),
                         options_, notes_);
  }

 private:
  void read_header() {
    const auto first = in_.word();
    if (!first || !equals_any_case(*first, "meshversionformatted"))
      in_.fail("file starts with ", in_quotes(first.value_or("")), "; must start with MeshVersionFormatted (Medit)");
    in_.integer("the version");
    const auto second = in_.word();
    if (!second || !equals_any_case(*second, "dimension")) in_.fail("found no Dimension behind the version");
    const long long dimension = in_.integer("the dimension");
    if (dimension != 3) in_.fail("dimension is ", dimension, "; must be 3");
  }

  /// The next word that is no number: sections that we do not use end there.
  std::optional<std::string_view> next_keyword() {
    auto word = in_.word();
    while (word && !is_letter((*word)[0])) word = in_.word();
    return word;
  }

  void read_section(std::string_view keyword) {
    const auto is = [&](std::string_view name) { return equals_any_case(keyword, name); };
    if (is("vertices"))
      read_vertices();
    else if (is("triangles"))
      read_cells(CellKind::polygon, 3, "triangles");
    else if (is("quadrilaterals"))
      read_cells(CellKind::polygon, 4, "quadrilaterals");
    else if (is("tetrahedra"))
      read_cells(CellKind::tetrahedron, 4, "tetrahedra");
    else if (is("edges"))
      read_cells(CellKind::skipped, 2, "edges");
    else if (std::find_if(kSkipped.begin(), kSkipped.end(), is) == kSkipped.end())
      in_.fail("section ", in_quotes(keyword),
               " is not supported; known: Vertices, Triangles, Quadrilaterals, Tetrahedra, Edges, and what marks them");
  }

  void read_vertices() {
    if (num_nodes_ > 0) in_.fail("a second section Vertices");
    num_nodes_ = in_.count("vertices", 8);  // "0 0 0 0\n"
    for (int i = 0; i < num_nodes_; ++i) {
      for (int k = 0; k < 3; ++k) x_.push_back(in_.coordinate(What("a coordinate of vertex", i + 1), options_.lenient));
      in_.number(What("the reference of vertex", i + 1));
    }
  }

  void read_cells(CellKind kind, int corners, const char* what) {
    const int n = in_.count(what, 2 * static_cast<std::size_t>(corners) + 2);
    const std::string of = text("a vertex of one of the ", what, ", number");
    for (int i = 0; i < n; ++i) {
      int corner[4] = {};
      for (int k = 0; k < corners; ++k) {
        const long long number = in_.integer(What(of, i + 1));
        if (number < 1 || number > num_nodes_)
          in_.fail(What(of, i + 1), ", is ", number, "; must be from 1 to ", num_nodes_, ", the vertices before it");
        corner[k] = static_cast<int>(number - 1);
      }
      in_.number(What("a reference"));
      cells_.add(kind, std::span<const int>(corner, static_cast<std::size_t>(corners)));
    }
  }

  TextReader in_;
  const LoadOptions& options_;
  Notes& notes_;
  std::vector<double> x_;
  int num_nodes_ = 0;
  CellCollector cells_;
};

}  // namespace

Mesh read_medit(const std::string& path, const LoadOptions& options, Notes& notes) {
  return MeditReader(path, options, notes).read();
}

}  // namespace kt
