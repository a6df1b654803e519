// VTU (VTK unstructured grid): ASCII, inline base64 and appended raw or base64 arrays, compressed by zlib or not, in
// either byte order.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "core/base/numbers.hpp"
#include "io/files/text_reader.hpp"
#include "io/mesh/cells.hpp"
#include "io/mesh/format/vtu_array.hpp"
#include "io/mesh/mesh_formats.hpp"

namespace kt {
namespace {

struct Element {
  std::string name;
  std::map<std::string, std::string> attribute;
  std::size_t begin = 0, content = 0;  ///< positions of '<' and behind '>'
};

class VtuReader {
 public:
  VtuReader(const std::string& path, const LoadOptions& options, Notes& notes)
      : path_(path), data_(file_content(path, options)), options_(options), notes_(notes) {}

  Mesh read();

 private:
  template <class... Args>
  [[noreturn]] void fail(std::size_t at, const Args&... args) const {
    const auto lines =
        std::count(data_.begin(), data_.begin() + static_cast<std::ptrdiff_t>(std::min(at, data_.size())), '\n');
    throw InputError(text(path_, ":", lines + 1, ": ", args...));
  }
  std::optional<Element> next_element(std::size_t& at) const;
  long long integer_attribute(const Element& e, const std::string& name) const;
  /// No array is longer than this: compressed ones are a few times the file.
  std::size_t most_bytes() const { return encoding_.compressed ? 32 * data_.size() : data_.size(); }
  std::vector<double> ascii(const Element& e, const std::string& what) const;
  std::vector<double> decoded(const Element& e, const std::string& format, const std::string& type) const;
  std::vector<double> values(const Element& e, std::size_t expected, const std::string& what) const;
  void read_header(const Element& e);
  Mesh build(const Element& piece, const Element* points, const std::map<std::string, Element>& cells);

  std::string path_, data_;
  const LoadOptions& options_;
  Notes& notes_;
  VtuEncoding encoding_;
  std::size_t markup_end_ = 0;           ///< where XML ends and appended data start
  std::optional<std::size_t> appended_;  ///< behind the underscore
  bool appended_base64_ = false;
};

std::optional<Element> VtuReader::next_element(std::size_t& at) const {
  for (;;) {
    at = data_.find('<', at);
    if (at == std::string::npos || at >= markup_end_) return std::nullopt;
    if (data_.compare(at, 4, "<!--") == 0) {
      const std::size_t end = data_.find("-->", at);
      if (end == std::string::npos) fail(at, "comment without end");
      at = end + 3;
      continue;
    }
    const std::size_t end = data_.find('>', at);
    if (end == std::string::npos) fail(at, "element without '>': the file is truncated");
    const std::string_view inside = std::string_view(data_).substr(at + 1, end - at - 1);
    Element e{.name = std::string(inside.substr(0, inside.find_first_of(" \t\r\n/", 1))),
              .attribute = {},
              .begin = at,
              .content = end + 1};
    for (std::size_t p = e.name.size(); (p = inside.find('=', p)) != std::string_view::npos;) {
      const std::size_t name_end = inside.find_last_not_of(" \t\r\n", p - 1) + 1;
      const std::size_t name_begin = inside.find_last_of(" \t\r\n", name_end - 1) + 1;
      const std::size_t open = inside.find_first_of("\"'", p);
      if (open == std::string_view::npos) fail(at, "attribute without quotes in ", in_quotes(inside));
      const std::size_t close = inside.find(inside[open], open + 1);
      if (close == std::string_view::npos) fail(at, "attribute without closing quote in ", in_quotes(inside));
      e.attribute[std::string(inside.substr(name_begin, name_end - name_begin))] =
          std::string(inside.substr(open + 1, close - open - 1));
      p = close + 1;
    }
    at = end + 1;
    if (e.name[0] != '?' && e.name[0] != '!') return e;
  }
}

long long VtuReader::integer_attribute(const Element& e, const std::string& name) const {
  const auto found = e.attribute.find(name);
  if (found == e.attribute.end()) fail(e.begin, e.name, " has no attribute ", name);
  long long value = 0;
  const char* end = found->second.data() + found->second.size();
  const auto result = std::from_chars(found->second.data(), end, value);
  if (result.ec != std::errc() || result.ptr != end || value < 0)
    fail(e.begin, name, " is ", in_quotes(found->second), "; must be an integer >= 0");
  return value;
}

std::vector<double> VtuReader::decoded(const Element& e, const std::string& format, const std::string& type) const {
  const NumberType number = vtu_type(type);
  if (number.size == 0) fail(e.begin, "array type ", in_quotes(type), " is unknown");
  const std::string_view whole = data_;
  std::string_view source;
  if (format == "binary") {
    source = whole.substr(e.content, data_.find('<', e.content) - e.content);
  } else {
    if (!appended_) fail(e.begin, "the array is appended, but the file has no AppendedData: it may be truncated");
    const std::size_t offset = static_cast<std::size_t>(integer_attribute(e, "offset"));
    if (offset >= data_.size() - *appended_) fail(e.begin, "offset ", offset, " lies behind the end of the file");
    source = whole.substr(*appended_ + offset);
  }
  try {
    return values_of(vtu_array_bytes(source, format == "binary" || appended_base64_, encoding_, most_bytes()), number,
                     encoding_.order);
  } catch (const InputError& error) {
    fail(e.begin, error.what());
  }
}

std::vector<double> VtuReader::ascii(const Element& e, const std::string& what) const {
  std::vector<double> out;
  const std::size_t end = std::min(data_.find('<', e.content), data_.size());
  const char* at = data_.data() + e.content;
  const char* const last = data_.data() + end;
  while (at < last) {
    if (is_space(*at)) {
      ++at;
      continue;
    }
    const char* stop = std::find_if(at, last, is_space);
    double value = 0;
    const auto result = std::from_chars(at, stop, value);
    if (result.ec != std::errc() || result.ptr != stop)
      fail(static_cast<std::size_t>(at - data_.data()), what, " ", in_quotes({at, static_cast<std::size_t>(stop - at)}),
           " is not a number");
    out.push_back(value);
    at = stop;
  }
  return out;
}

std::vector<double> VtuReader::values(const Element& e, std::size_t expected, const std::string& what) const {
  const auto attribute = [&](const char* name) {
    const auto found = e.attribute.find(name);
    return found == e.attribute.end() ? std::string() : found->second;
  };
  const std::string format = attribute("format");
  std::vector<double> out;
  if (format.empty() || format == "ascii")
    out = ascii(e, what);
  else if (format == "binary" || format == "appended")
    out = decoded(e, format, attribute("type"));
  else
    fail(e.begin, "array format ", in_quotes(format), " is unknown; known: ascii, binary, appended");
  if (out.size() != expected && expected != std::numeric_limits<std::size_t>::max())
    fail(e.begin, what, ": ", out.size(), " values; must be ", expected);
  return out;
}

void VtuReader::read_header(const Element& e) {
  const auto is = [&](const char* name, const char* value) {
    const auto found = e.attribute.find(name);
    return found != e.attribute.end() && found->second == value;
  };
  if (!is("type", "UnstructuredGrid")) fail(e.begin, "VTKFile is not of type UnstructuredGrid");
  if (is("byte_order", "BigEndian")) encoding_.order = std::endian::big;
  if (const auto found = e.attribute.find("compressor"); found != e.attribute.end()) {
    if (found->second != "vtkZLibDataCompressor")
      fail(e.begin, "compressor ", in_quotes(found->second),
           " is not supported; known: vtkZLibDataCompressor, or none");
    encoding_.compressed = true;
  }
  encoding_.wide = is("header_type", "UInt64");
}

/// What arrays stand in; ParaView puts keys and their values into arrays, which end none of these.
bool is_section(std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);
  for (const char* section : {"Points", "Cells", "PointData", "CellData", "FieldData", "Piece", "UnstructuredGrid"})
    if (name == section) return true;
  return false;
}

/// Where the appended data begin; in a comment they do not.
std::size_t find_appended(std::string_view data) {
  constexpr std::string_view kTag = "<AppendedData", kComment = "<!--";
  for (std::size_t at = 0; (at = data.find('<', at)) != data.npos; ++at) {
    if (data.substr(at, kTag.size()) == kTag) return at;
    if (data.substr(at, kComment.size()) != kComment) continue;
    at = data.find("-->", at);
    if (at == data.npos) break;
  }
  return data.npos;
}

Mesh VtuReader::read() {
  const std::size_t tag = find_appended(data_);
  markup_end_ = std::min(tag, data_.size());
  if (tag != std::string::npos) {
    const std::size_t close = data_.find('>', tag), underscore = data_.find('_', close);
    if (underscore == std::string::npos) fail(tag, "AppendedData has no '_'");
    appended_ = underscore + 1;
    appended_base64_ = data_.substr(tag, close - tag).find("base64") != std::string::npos;
  }
  std::optional<Element> file, piece, points;
  std::map<std::string, Element> cells;
  std::string parent;
  std::size_t at = 0;
  while (const auto e = next_element(at)) {
    if (!file && e->name != "VTKFile")
      fail(e->begin, "file starts with ", in_quotes("<" + e->name), "; must start with <VTKFile");
    if (e->name == "VTKFile") read_header(*(file = e));
    if (e->name == "Piece") {
      if (piece) fail(e->begin, "the file has several pieces; only one is supported");
      piece = e;
    }
    if (e->name == "DataArray" && parent == "Points") points = e;
    if (e->name == "DataArray" && parent == "Cells" && e->attribute.count("Name"))
      cells.insert_or_assign(e->attribute.at("Name"), *e);
    if (is_section(e->name)) parent = e->name;
  }
  if (!file) fail(0, "no <VTKFile> element: not a VTU file");
  if (!piece) fail(data_.size(), "no <Piece> element: the file may be truncated");
  return build(*piece, points ? &*points : nullptr, cells);
}

/// Read as a double, like all numbers of the file, and usable as an index.
bool is_whole(double value, double low, double high) {
  return value >= low && value <= high && value == std::floor(value);
}

Mesh VtuReader::build(const Element& piece, const Element* points, const std::map<std::string, Element>& cells) {
  constexpr std::size_t kAny = std::numeric_limits<std::size_t>::max();
  const auto n = static_cast<std::size_t>(integer_attribute(piece, "NumberOfPoints"));
  const auto num_cells = static_cast<std::size_t>(integer_attribute(piece, "NumberOfCells"));
  for (const std::size_t announced : {n, num_cells})
    if (announced > most_bytes())
      fail(piece.begin, "the piece announces ", announced, " points or cells, but the file has only ", data_.size(),
           " bytes");
  if (!points) fail(piece.begin, "the piece has no array in <Points>");
  for (const char* name : {"connectivity", "offsets", "types"})
    if (!cells.count(name)) fail(piece.begin, "the piece has no array \"", name, "\" in <Cells>");
  const std::vector<double> x = values(*points, 3 * n, "coordinate");
  const std::vector<double> offsets = values(cells.at("offsets"), num_cells, "cell offset");
  const std::vector<double> types = values(cells.at("types"), num_cells, "cell type");
  const std::vector<double> connectivity = values(cells.at("connectivity"), kAny, "connectivity");
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::isfinite(x[i]) ? std::abs(x[i]) >= kLargestCoordinate : !options_.lenient)
      fail(points->begin, "coordinate ", "xyz"[i % 3], " of point ", i / 3, " is ", x[i], "; must be finite and below ",
           kLargestCoordinate);
  double begin = 0;
  CellCollector collector;
  std::vector<int> corner;
  for (std::size_t c = 0; c < num_cells; ++c) {
    const double end = offsets[c];
    if (!is_whole(end, begin, static_cast<double>(connectivity.size())))
      fail(cells.at("offsets").begin, "offset ", end, " of cell ", c, " is no integer in the range ", begin, "..",
           connectivity.size());
    corner.clear();
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      if (!is_whole(connectivity[i], 0, static_cast<double>(n) - 1))
        fail(cells.at("connectivity").begin, "point ", connectivity[i], " of cell ", c,
             " is no integer in the range 0..", static_cast<long long>(n) - 1);
      corner.push_back(static_cast<int>(connectivity[i]));
    }
    begin = end;
    const VtkCellType* type =
        is_whole(types[c], 0, 255) ? find_vtk_cell_type(static_cast<long long>(types[c])) : nullptr;
    if (!type) fail(cells.at("types").begin, "cell ", c, " has type ", types[c], "; known: ", kVtkCellTypes);
    if (const std::string wrong = collector.add_vtk(*type, corner); !wrong.empty())
      fail(cells.at("offsets").begin, "cell ", c, " has ", corner.size(), " points; must be ", wrong);
  }
  return collector.finish(Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size())), false, path_,
                          options_, notes_);
}

}  // namespace

Mesh read_vtu(const std::string& path, const LoadOptions& options, Notes& notes) {
  return VtuReader(path, options, notes).read();
}

}  // namespace kt
