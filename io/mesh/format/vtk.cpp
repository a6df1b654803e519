// Legacy VTK files: unstructured grids and polydata, text and binary, in the layout of all versions (5.1 has offsets).
#include <array>
#include <limits>
#include <optional>

#include "io/mesh/cells.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/number_reader.hpp"

namespace kt {
namespace {

NumberType type_of(const TextReader& in, std::string_view name) {
  constexpr std::pair<std::string_view, NumberType> kTypes[] = {{"double", kFloat64},
                                                                {"float", kFloat32},
                                                                {"int", kInt32},
                                                                {"unsigned_int", kUInt32},
                                                                {"vtktypeint64", kInt64},
                                                                {"long", kInt64},
                                                                {"unsigned_long", kUInt64},
                                                                {"vtktypeuint64", kUInt64},
                                                                {"vtktypeint32", kInt32},
                                                                {"short", kInt16},
                                                                {"unsigned_short", kUInt16},
                                                                {"vtktypeuint32", kUInt32},
                                                                {"vtktypeint16", kInt16},
                                                                {"char", kInt8},
                                                                {"unsigned_char", kUInt8},
                                                                {"vtktypeuint8", kUInt8},
                                                                {"vtkidtype", kInt32}};  // as old versions write it
  for (const auto& [known, type] : kTypes)
    if (equals_any_case(name, known)) return type;
  in.fail("data type ", in_quotes(name), " is not supported; known: double, float, int, long, short, char");
}

/// Lists of nodes one after the other: list i has nodes[first[i]] .. nodes[first[i + 1] - 1].
struct Lists {
  std::vector<int> nodes;
  std::vector<std::size_t> first{0};
  std::size_t size() const { return first.size() - 1; }
  std::span<const int> operator[](std::size_t i) const {
    return std::span(nodes).subspan(first[i], first[i + 1] - first[i]);
  }
};

class VtkReader {
 public:
  VtkReader(const std::string& path, const LoadOptions& options, Notes& notes)
      : in_(path, file_content(path, options)), numbers_(in_), options_(options), notes_(notes) {}

  Mesh read() {
    read_header();
    while (const auto keyword = next_keyword())
      if (!read_section(*keyword)) break;
    if (!has_points_) in_.fail("the file has no POINTS");
    collect_cells();
    return cells_.finish(Eigen::Map<const VectorX>(x_.data(), static_cast<Eigen::Index>(x_.size())), false, in_.path(),
                         options_, notes_);
  }

 private:
  void read_header() {
    const auto first = in_.line();
    if (!first || !first->starts_with("# vtk DataFile Version"))
      in_.fail("file starts with ", in_quotes(first.value_or("")), "; must start with \"# vtk DataFile Version\"");
    in_.line();  // the title
    const auto format = in_.line();
    const bool binary = format && equals_any_case(*format, "binary");
    if (!binary && (!format || !equals_any_case(*format, "ascii")))
      in_.fail("format ", in_quotes(format.value_or("")), " is unknown; known: ASCII, BINARY");
    if (binary)
      numbers_.use_bytes(std::endian::big);
    else
      in_.drop_last_nuls();
    const auto dataset = next_keyword();
    if (!dataset || !equals_any_case(*dataset, "dataset")) in_.fail("found no DATASET behind the format");
    const std::string_view name = word_of_line("the kind of dataset");
    is_polydata_ = equals_any_case(name, "polydata");
    if (!is_polydata_ && !equals_any_case(name, "unstructured_grid"))
      in_.fail("dataset ", in_quotes(name), " is not supported; known: UNSTRUCTURED_GRID, POLYDATA");
  }

  /// Nothing at the end, where some programs write C's end of string.
  std::optional<std::string_view> next_keyword() {
    const auto found = in_.word();
    return found && found->front() == '\0' ? std::nullopt : found;
  }

  std::string_view word_of_line(const char* what) {
    const auto found = in_.word_on_line();
    if (!found) in_.fail("line ends where ", what, " should be");
    return *found;
  }
  long long number_of_line(const char* what) { return in_.to_integer(word_of_line(what), what); }
  /// Binary data start behind the line.
  void end_line() {
    if (numbers_.is_binary()) in_.skip_line();
  }

  /// False at what belongs to the points and cells, with which the mesh ends.
  bool read_section(std::string_view keyword) {
    const auto is = [&](std::string_view name) { return equals_any_case(keyword, name); };
    if (is("points"))
      read_points();
    else if (is("cells") && !is_polydata_)
      read_lists(lists_[0]);
    else if (is("cell_types") && !is_polydata_)
      read_types();
    else if (is("polygons") && is_polydata_)
      read_lists(lists_[0]);
    else if (is("triangle_strips") && is_polydata_)
      read_lists(lists_[1]);
    else if ((is("lines") || is("vertices")) && is_polydata_)
      read_lists(lists_[2]);
    else if (is("field"))
      skip_field();
    else if (is("metadata"))
      skip_metadata();
    else if (is("cell_data") || is("point_data"))
      return false;
    else
      in_.fail("found ", in_quotes(keyword), " where a section like POINTS or CELLS should start");
    return true;
  }

  void read_points() {
    if (has_points_) in_.fail("a second POINTS");
    has_points_ = true;
    const long long n = number_of_line("the number of points");
    const NumberType type = type_of(in_, word_of_line("the type of the points"));
    end_line();
    numbers_.check_count(n, "points", 3 * type.size, 3);
    for (long long i = 0; i < n; ++i)
      for (int k = 0; k < 3; ++k)
        x_.push_back(numbers_.coordinate(type, What("a coordinate of point", i), options_.lenient));
  }

  /// "CELLS number size" and for each its length and nodes; or, in 5.1, the lengths of two arrays, and these.
  void read_lists(Lists& out) {
    const long long n = number_of_line("the number of lists"), size = number_of_line("the size of the lists");
    const TextReader::Bookmark place = in_.bookmark();
    const auto word = in_.word();
    if (word && equals_any_case(*word, "offsets")) return read_offsets(n, size, out);
    in_.go_back(place);
    end_line();
    numbers_.check_count(n, "lists", 4, 1);
    numbers_.check_count(size, "numbers of lists", 4, 1);
    long long used = 0;
    for (long long i = 0; i < n; ++i) {
      const long long length = numbers_.integer(kInt32, What("the number of nodes of cell", i));
      used += 1 + length;
      if (length < 0 || used > size)
        numbers_.fail("cell ", i, " has ", length, " nodes; all cells together have ", size - n);
      for (long long k = 0; k < length; ++k) out.nodes.push_back(node_of(kInt32, i));
      out.first.push_back(out.nodes.size());
    }
    if (used != size) numbers_.fail("the cells have ", used, " numbers; their header announces ", size);
  }

  void read_offsets(long long n, long long size, Lists& out) {
    const NumberType offset_type = type_of(in_, word_of_line("the type of the offsets"));
    end_line();
    numbers_.check_count(n, "offsets", offset_type.size, 1);
    if (n < 1) numbers_.fail("number of offsets is ", n, "; must be at least 1");
    const std::size_t before = out.nodes.size();
    long long last = 0;
    for (long long i = 0; i < n; ++i) {
      const long long offset = numbers_.integer(offset_type, What("offset", i));
      if (offset < last || offset > size || (i == 0 && offset != 0))
        numbers_.fail("offset ", i, " is ", offset, "; must be from ", last, " to ", i == 0 ? 0 : size);
      if (i > 0) out.first.push_back(before + static_cast<std::size_t>(offset));
      last = offset;
    }
    if (last != size) numbers_.fail("the last offset is ", last, "; must be ", size);
    const auto word = in_.word();
    if (!word || !equals_any_case(*word, "connectivity")) in_.fail("found no CONNECTIVITY behind the offsets");
    const NumberType type = type_of(in_, word_of_line("the type of the connectivity"));
    end_line();
    numbers_.check_count(size, "nodes of cells", type.size, 1);
    for (long long i = 0; i < size; ++i) out.nodes.push_back(node_of(type, i));
  }

  int node_of(const NumberType& type, long long of) {
    const long long i = numbers_.integer(type, What("a node of cell", of));
    if (i < 0 || i > std::numeric_limits<int>::max())
      numbers_.fail("node ", i, " of cell ", of, " is out of range 0..", std::numeric_limits<int>::max());
    return static_cast<int>(i);  // POINTS may come later
  }

  void read_types() {
    const long long n = number_of_line("the number of cell types");
    end_line();
    numbers_.check_count(n, "cell types", 4, 1);
    for (long long i = 0; i < n; ++i) types_.push_back(numbers_.integer(kInt32, What("the type of cell", i)));
  }

  void skip_field() {
    word_of_line("the name of a field");
    const long long arrays = number_of_line("the number of arrays");
    for (long long i = 0; i < arrays; ++i) {
      if (!in_.word()) in_.fail("file ends where the name of a field's array should be");
      const long long components = number_of_line("the number of components");
      const long long tuples = number_of_line("the number of tuples");
      const NumberType type = type_of(in_, word_of_line("the type of an array"));
      end_line();
      numbers_.check_count(components, "components", type.size, 1);
      numbers_.check_count(tuples, "tuples", type.size, 1);
      for (long long k = 0; k < components * tuples; ++k) numbers_.real(type, "a value of a field");
    }
  }

  /// To a blank line.
  void skip_metadata() {
    in_.skip_line();
    for (auto line = in_.line(); line && !line->empty();) line = in_.line();
  }

  void collect_cells() {
    constexpr std::array<long long, 3> kPolydata = {7, 6, 4};  // polygon, strip, line
    if (!is_polydata_ && types_.size() != lists_[0].size())
      in_.fail("the file has ", lists_[0].size(), " cells but ", types_.size(), " cell types");
    for (std::size_t which = 0; which < lists_.size(); ++which)
      for (std::size_t i = 0; i < lists_[which].size(); ++i)
        add_cell(i, is_polydata_ ? kPolydata[which] : types_[i], lists_[which][i]);
  }

  void add_cell(std::size_t i, long long number, std::span<const int> nodes) {
    const VtkCellType* type = find_vtk_cell_type(number);
    if (!type) in_.fail("cell ", i, " has type ", number, "; known: ", kVtkCellTypes);
    const auto points = static_cast<int>(x_.size() / 3);
    for (const int node : nodes)
      if (node >= points) in_.fail("node ", node, " of cell ", i, " is out of range 0..", points - 1);
    if (const std::string wrong = cells_.add_vtk(*type, nodes); !wrong.empty())
      in_.fail("cell ", i, " has ", nodes.size(), " nodes; must be ", wrong);
  }

  TextReader in_;
  NumberReader numbers_;
  const LoadOptions& options_;
  Notes& notes_;
  bool is_polydata_ = false, has_points_ = false;
  std::vector<double> x_;
  std::array<Lists, 3> lists_;  ///< cells or polygons; strips; lines and points
  std::vector<long long> types_;
  CellCollector cells_;
};

}  // namespace

Mesh read_vtk(const std::string& path, const LoadOptions& options, Notes& notes) {
  return VtkReader(path, options, notes).read();
}

}  // namespace kt
