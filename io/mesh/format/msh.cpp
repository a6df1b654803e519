// Gmsh .msh, versions 2.x and 4.1, text and binary: triangles, quadrangles and tetrahedra; points and lines are
// skipped.
#include <optional>
#include <unordered_map>

#include "io/files/output_file.hpp"
#include "io/mesh/cells.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/number_reader.hpp"

namespace kt {
namespace {

struct ElementType {
  long long type;
  CellKind kind;
  int nodes, corners;  ///< all nodes, and the corners, which are all that we take
};
// Gmsh's numbers: lines and points, triangles, quadrangles, tetrahedra, each with its quadratic form.
constexpr ElementType kTypes[] = {{1, CellKind::skipped, 2, 0},     {8, CellKind::skipped, 3, 0},
                                  {15, CellKind::skipped, 1, 0},    {2, CellKind::polygon, 3, 3},
                                  {9, CellKind::polygon, 6, 3},     {3, CellKind::polygon, 4, 4},
                                  {10, CellKind::polygon, 9, 4},    {16, CellKind::polygon, 8, 4},
                                  {4, CellKind::tetrahedron, 4, 4}, {11, CellKind::tetrahedron, 10, 4}};

class MshReader {
 public:
  MshReader(const std::string& path, const LoadOptions& options, Notes& notes)
      : in_(path, text_content(path, options)), numbers_(in_), options_(options), notes_(notes) {}

  Mesh read() {
    read_format();
    while (const auto section = in_.word()) {
      const std::string name(*section);
      if (name == "$Nodes")
        version_ < 4 ? read_nodes_2() : read_nodes_4();
      else if (name == "$Elements")
        version_ < 4 ? read_elements_2() : read_elements_4();
      else if (!name.starts_with("$"))
        in_.fail("found ", in_quotes(name), " where a section like $Nodes should start");
      else if (!in_.skip_past("$End" + name.substr(1)))
        in_.fail("file ends inside ", in_quotes(name));
      if (name == "$Nodes" || name == "$Elements") expect("$End" + name.substr(1));
    }
    if (x_.empty()) in_.fail("the file has no $Nodes");
    if (!has_elements_) in_.fail("the file has no $Elements");
    return cells_.finish(Eigen::Map<const VectorX>(x_.data(), static_cast<Eigen::Index>(x_.size())), true, in_.path(),
                         options_, notes_);
  }

 private:
  void expect(const std::string& token) {
    const auto found = in_.word();
    if (!found) in_.fail("file ends where ", token, " should be");
    if (*found != token) in_.fail("found ", in_quotes(*found), " where ", token, " should be");
  }

  void read_format() {
    const auto first = in_.word();
    if (!first || *first != "$MeshFormat")
      in_.fail("file starts with ", in_quotes(first.value_or("")), "; must start with $MeshFormat");
    version_ = in_.number("the format version");
    const long long binary = in_.integer("the file type");
    if (binary != 0 && binary != 1) in_.fail("the file type is ", binary, "; must be 0 (text) or 1 (binary)");
    if (!((version_ >= 2 && version_ < 3) || version_ == 4.1))
      in_.fail("format version ", version_, " is not supported; known: 2.x and 4.1");
    const long long size = in_.integer("the data size");
    if (binary == 1) {
      if (size != 8 && (size != 4 || version_ < 4)) in_.fail("the data size is ", size, "; must be 8");
      size_type_ = size == 8 ? kUInt64 : kUInt32;
      read_byte_order();
    }
    expect("$EndMeshFormat");
  }

  /// The number 1 as four bytes says in which order they are.
  void read_byte_order() {
    in_.skip_line();
    const std::string_view bytes = in_.rest();
    if (bytes.size() < 4) in_.fail("file ends where the number 1 should show the order of bytes");
    const bool little = bits_of(bytes, 4, std::endian::little) == 1;
    if (!little && bits_of(bytes, 4, std::endian::big) != 1)
      in_.fail("the four bytes behind the format are not the number 1 in either order");
    in_.skip_bytes(4);
    numbers_.use_bytes(little ? std::endian::little : std::endian::big);
  }

  /// Where the numbers of a section start. Counts of version 2 are text in binary files too.
  int start_section_2(std::string_view what, std::size_t bytes_each, std::size_t words_each) {
    const long long n = in_.integer(text("the number of ", what));
    if (numbers_.is_binary()) in_.skip_line();
    numbers_.check_count(n, what, bytes_each, words_each);
    return static_cast<int>(n);
  }
  void start_section_4() {
    if (numbers_.is_binary()) in_.skip_line();
  }

  void add_node(long long tag) {
    for (int k = 0; k < 3; ++k)
      x_.push_back(numbers_.coordinate(kFloat64, What("a coordinate of node", tag), options_.lenient));
  }
  void add_tag(long long tag) {
    if (!index_.try_emplace(tag, static_cast<int>(index_.size())).second) numbers_.fail("node ", tag, " occurs twice");
  }

  void read_nodes_2() {
    const int n = start_section_2("nodes", 28, 4);
    for (int i = 0; i < n; ++i) {
      const long long tag = numbers_.integer(kInt32, "a node number");
      add_tag(tag);
      add_node(tag);
    }
  }

  void read_nodes_4() {
    start_section_4();
    const int blocks = numbers_.count(size_type_, "node blocks", 20, 4);
    const int announced = numbers_.count(size_type_, "nodes", 28, 4);
    numbers_.integer(size_type_, "the smallest node number");
    numbers_.integer(size_type_, "the largest node number");
    for (int b = 0; b < blocks; ++b) {
      const long long dimension = numbers_.integer(kInt32, "an entity dimension");
      numbers_.integer(kInt32, "an entity number");
      const long long parametric = numbers_.integer(kInt32, "the parametric flag");
      const int n = numbers_.count(size_type_, "nodes of a block", 28, 1);
      std::vector<long long> tags;
      for (int i = 0; i < n; ++i) tags.push_back(numbers_.integer(size_type_, "a node number"));
      for (const long long tag : tags) {
        add_tag(tag);
        add_node(tag);
        for (long long k = 0; parametric != 0 && k < dimension; ++k) numbers_.real(kFloat64, "a parameter");
      }
    }
    if (static_cast<int>(index_.size()) != announced)
      numbers_.fail("$Nodes holds ", index_.size(), " nodes; its header announces ", announced);
  }

  const ElementType& element_type(long long type) const {
    for (const ElementType& t : kTypes)
      if (t.type == type) return t;
    numbers_.fail("element type ", type,
                  " is not supported; known: points, lines, triangles, quadrangles and tetrahedra, "
                  "linear or quadratic (1 2 3 4 8 9 10 11 15 16)");
  }

  void read_element(const ElementType& type, const NumberType& tag_type) {
    int corner[4] = {};
    for (int k = 0; k < type.nodes; ++k) {
      const long long tag = numbers_.integer(tag_type, "a node of an element");
      const auto found = index_.find(tag);
      if (found == index_.end()) numbers_.fail("element uses node ", tag, ", which $Nodes does not have");
      if (k < 4) corner[k] = found->second;
    }
    const std::span<const int> corners(corner, static_cast<std::size_t>(type.corners));
    type.nodes > type.corners ? cells_.add_quadratic(type.kind, corners) : cells_.add(type.kind, corners);
  }

  void read_elements_2() {
    has_elements_ = true;
    const int n = start_section_2("elements", 8, 4);
    if (numbers_.is_binary()) return read_element_blocks_2(n);
    for (int i = 0; i < n; ++i) {
      in_.integer("an element number");
      const ElementType& type = element_type(in_.integer("an element type"));
      skip_tags(in_.count("tags", 1));
      read_element(type, kInt32);
    }
  }

  /// Binary elements come in blocks of one type.
  void read_element_blocks_2(int n) {
    for (int done = 0; done < n;) {
      const ElementType& type = element_type(numbers_.integer(kInt32, "an element type"));
      const int block = numbers_.count(kInt32, "elements of a block", 4, 1);
      const int tags = numbers_.count(kInt32, "tags", 1, 1);
      if (block < 1 || block > n - done)
        numbers_.fail("a block of ", block, " elements; must be 1 to ", n - done, ", which are left");
      for (int i = 0; i < block; ++i) {
        numbers_.integer(kInt32, "an element number");
        skip_tags(tags);
        read_element(type, kInt32);
      }
      done += block;
    }
  }
  void skip_tags(int n) {
    for (int k = 0; k < n; ++k) numbers_.integer(kInt32, "a tag");
  }

  void read_elements_4() {
    has_elements_ = true;
    start_section_4();
    const int blocks = numbers_.count(size_type_, "element blocks", 20, 4);
    const int announced = numbers_.count(size_type_, "elements", 8, 2);
    numbers_.integer(size_type_, "the smallest element number");
    numbers_.integer(size_type_, "the largest element number");
    long long total = 0;
    for (int b = 0; b < blocks; ++b) {
      numbers_.integer(kInt32, "an entity dimension");
      numbers_.integer(kInt32, "an entity number");
      const ElementType& type = element_type(numbers_.integer(kInt32, "an element type"));
      const int n = numbers_.count(size_type_, "elements of a block", 8, 2);
      for (int i = 0; i < n; ++i) {
        numbers_.integer(size_type_, "an element number");
        read_element(type, size_type_);
      }
      total += n;
    }
    if (total != announced) numbers_.fail("$Elements holds ", total, " elements; its header announces ", announced);
  }

  TextReader in_;
  NumberReader numbers_;
  const LoadOptions& options_;
  Notes& notes_;
  double version_ = 0;
  NumberType size_type_ = kUInt64;
  std::vector<double> x_;
  std::unordered_map<long long, int> index_;
  CellCollector cells_;
  bool has_elements_ = false;
};

}  // namespace

Mesh read_msh(const std::string& path, const LoadOptions& options, Notes& notes) {
  return MshReader(path, options, notes).read();
}

std::string write_msh(const Mesh& mesh) {
  const int n = mesh.num_nodes();
  const std::size_t triangles = mesh.triangles.size(), tetrahedra = mesh.tetrahedra.size();
  // Gmsh refuses elements of an entity that $Entities does not announce, with its box.
  const bool solid = tetrahedra > 0, surface = triangles > 0;
  std::string box;
  const Bounds b = bounds(mesh);
  for (const Vec3& corner : {b.min, b.max})
    for (int k = 0; k < 3; ++k) append_number(box += ' ', corner[k]);
  std::string out = text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 ", int{surface}, ' ', int{solid}, '\n');
  if (surface) out += text(1, box, " 0 0\n");
  if (solid) out += text(1, box, surface ? " 0 1 1\n" : " 0 0\n");
  out += text("$EndEntities\n$Nodes\n1 ", n, " 1 ", n, "\n", solid ? 3 : 2, " 1 0 ", n, "\n");
  for (int i = 1; i <= n; ++i) out += text(i, '\n');
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) {
      append_number(out, mesh.x[3 * i + k]);
      out += k < 2 ? ' ' : '\n';
    }
  out += text("$EndNodes\n$Elements\n", int{surface} + int{solid}, ' ', triangles + tetrahedra, " 1 ",
              triangles + tetrahedra, "\n");
  std::size_t number = 0;
  if (surface) out += text("2 1 2 ", triangles, '\n');
  for (const Triangle& t : mesh.triangles) out += text(++number, ' ', t[0] + 1, ' ', t[1] + 1, ' ', t[2] + 1, '\n');
  if (solid) out += text("3 1 4 ", tetrahedra, '\n');
  for (const Tetrahedron& t : mesh.tetrahedra)
    out += text(++number, ' ', t[0] + 1, ' ', t[1] + 1, ' ', t[2] + 1, ' ', t[3] + 1, '\n');
  return out + "$EndElements\n";
}

}  // namespace kt
