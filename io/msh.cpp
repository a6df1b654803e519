// Gmsh .msh as text, versions 2.x and 4.1: triangles and tetrahedra; points and lines are skipped.
#include <optional>
#include <unordered_map>

#include "io/mesh_formats.hpp"
#include "io/output_file.hpp"
#include "io/polygon.hpp"
#include "io/text_reader.hpp"

namespace kt {
namespace {

struct ElementType {
  long long type;
  int nodes, corners;  ///< all nodes, and the corners we take: 3 triangle, 4 tetrahedron, -4 quadrangle, 0 skipped
};
// Gmsh's numbers: lines and points, triangles, quadrangles, tetrahedra, each with its quadratic form.
constexpr ElementType kTypes[] = {{1, 2, 0},  {8, 3, 0},   {15, 1, 0},  {2, 3, 3}, {9, 6, 3},
                                  {3, 4, -4}, {10, 9, -4}, {16, 8, -4}, {4, 4, 4}, {11, 10, 4}};

class MshReader {
 public:
  MshReader(const std::string& path, const LoadOptions& options, Notes& notes)
      : in_(path, text_content(path, options)), options_(options), notes_(notes) {}

  Mesh read() {
    read_format();
    while (const auto section = in_.word()) {
      const std::string name(*section);
      if (name == "$Nodes")
        version_ < 4 ? read_nodes_2() : read_nodes_4();
      else if (name == "$Elements")
        version_ < 4 ? read_elements_2() : read_elements_4();
      else if (name.starts_with("$"))
        skip_section(name);
      else
        in_.fail("found ", quoted(name), " where a section like $Nodes should start");
      if (name == "$Nodes" || name == "$Elements") expect("$End" + name.substr(1));
    }
    if (x_.empty()) in_.fail("the file has no $Nodes");
    if (!has_elements_) in_.fail("the file has no $Elements");
    return finish();
  }

 private:
  void expect(const std::string& token) {
    const auto found = in_.word();
    if (!found) in_.fail("file ends where ", token, " should be");
    if (*found != token) in_.fail("found ", quoted(*found), " where ", token, " should be");
  }

  void read_format() {
    const auto first = in_.word();
    if (!first || *first != "$MeshFormat")
      in_.fail("file starts with ", quoted(first.value_or("")), "; must start with $MeshFormat");
    version_ = in_.number("the format version");
    const long long binary = in_.integer("the file type");
    if (binary != 0) in_.fail("binary .msh is not supported; save it as text (gmsh: Mesh.Binary = 0)");
    if (!((version_ >= 2 && version_ < 3) || version_ == 4.1))
      in_.fail("format version ", version_, " is not supported; known: 2.x and 4.1");
    in_.integer("the data size");
    expect("$EndMeshFormat");
  }

  void skip_section(const std::string& name) {
    const std::string end = "$End" + name.substr(1);
    while (const auto found = in_.word())
      if (*found == end) return;
    in_.fail("file ends inside ", quoted(name));
  }

  void add_node(long long tag) {
    for (int k = 0; k < 3; ++k) x_.push_back(in_.number(text("a coordinate of node ", tag), options_.lenient));
  }
  void add_tag(long long tag) {
    if (!index_.try_emplace(tag, static_cast<int>(index_.size())).second) in_.fail("node ", tag, " occurs twice");
  }

  void read_nodes_2() {
    const int n = in_.count("nodes", 8);
    for (int i = 0; i < n; ++i) {
      const long long tag = in_.integer("a node number");
      add_tag(tag);
      add_node(tag);
    }
  }

  void read_nodes_4() {
    const int blocks = in_.count("node blocks", 8), announced = in_.count("nodes", 8);
    in_.integer("the smallest node number");
    in_.integer("the largest node number");
    for (int b = 0; b < blocks; ++b) {
      const long long dimension = in_.integer("an entity dimension");
      in_.integer("an entity number");
      const long long parametric = in_.integer("the parametric flag");
      const int n = in_.count("nodes of a block", 2);
      std::vector<long long> tags;
      for (int i = 0; i < n; ++i) tags.push_back(in_.integer("a node number"));
      for (const long long tag : tags) {
        add_tag(tag);
        add_node(tag);
        for (long long k = 0; parametric != 0 && k < dimension; ++k) in_.number("a parameter", true);
      }
    }
    if (static_cast<int>(index_.size()) != announced)
      in_.fail("$Nodes holds ", index_.size(), " nodes; its header announces ", announced);
  }

  void read_element(long long type) {
    const ElementType* known = nullptr;
    for (const ElementType& t : kTypes)
      if (t.type == type) known = &t;
    if (!known)
      in_.fail("element type ", type,
               " is not supported; known: points, lines, triangles, quadrangles and tetrahedra, "
               "linear or quadratic (1 2 3 4 8 9 10 11 15 16)");
    std::array<int, 4> corner{};
    for (int k = 0; k < known->nodes; ++k) {
      const long long tag = in_.integer("a node of an element");
      const auto found = index_.find(tag);
      if (found == index_.end()) in_.fail("element uses node ", tag, ", which $Nodes does not have");
      if (k < 4) corner[k] = found->second;
    }
    if (known->corners == 4) tetrahedra_.push_back(corner);
    if (known->corners == 3) polygons_.push_back({corner[0], corner[1], corner[2]});
    if (known->corners == -4) polygons_.push_back({corner.begin(), corner.end()});
    skipped_ += known->corners == 0;
  }

  void read_elements_2() {
    has_elements_ = true;
    const int n = in_.count("elements", 8);
    for (int i = 0; i < n; ++i) {
      in_.integer("an element number");
      const long long type = in_.integer("an element type");
      const int tags = in_.count("tags", 1);
      for (int k = 0; k < tags; ++k) in_.integer("a tag");
      read_element(type);
    }
  }

  void read_elements_4() {
    has_elements_ = true;
    const int blocks = in_.count("element blocks", 8), announced = in_.count("elements", 4);
    in_.integer("the smallest element number");
    in_.integer("the largest element number");
    long long total = 0;
    for (int b = 0; b < blocks; ++b) {
      in_.integer("an entity dimension");
      in_.integer("an entity number");
      const long long type = in_.integer("an element type");
      const int n = in_.count("elements of a block", 4);
      for (int i = 0; i < n; ++i) {
        in_.integer("an element number");
        read_element(type);
      }
      total += n;
    }
    if (total != announced) in_.fail("$Elements holds ", total, " elements; its header announces ", announced);
  }

  Mesh finish() {
    Mesh mesh;
    mesh.x = Eigen::Map<const VectorX>(x_.data(), static_cast<Eigen::Index>(x_.size()));
    mesh.tetrahedra = std::move(tetrahedra_);
    if (skipped_ > 0) notes_.push_back(text(skipped_, " point and line elements skipped"));
    if (!mesh.tetrahedra.empty()) {
      finish_solid(mesh, in_.path(), options_, notes_);
      return mesh;
    }
    PolygonTriangulator triangulator;
    for (const std::vector<int>& p : polygons_) triangulator.add(mesh.x, p, mesh.triangles);
    for (std::string& note : triangulator.notes()) notes_.push_back(std::move(note));
    if (options_.lenient) return mesh;
    if (const int dropped = drop_unused_nodes(mesh); dropped > 0)
      notes_.push_back(text(dropped, " nodes that no triangle uses dropped"));
    return mesh;
  }

  TextReader in_;
  const LoadOptions& options_;
  Notes& notes_;
  double version_ = 0;
  std::vector<double> x_;
  std::unordered_map<long long, int> index_;
  std::vector<std::vector<int>> polygons_;
  std::vector<Tetrahedron> tetrahedra_;
  int skipped_ = 0;
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
