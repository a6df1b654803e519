// TetGen's .node and .ele: either name loads both files of the pair.
#include <filesystem>

#include "core/base/numbers.hpp"
#include "io/files/text_reader.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/mesh/mesh_pair.hpp"

namespace kt {
namespace {

/// Nodes; returns the index of the first one, 0 or 1, which the .ele file shares.
int read_nodes(const std::string& path, const LoadOptions& options, VectorX& x) {
  TextReader in(path, text_content(path, options));
  const long long announced = in.integer("the number of nodes");
  const long long dimension = in.integer("the dimension");
  if (dimension != 3) in.fail("dimension is ", dimension, "; must be 3");
  const int extras = in.count("attributes", 1) + in.count("boundary markers", 1);
  in.check_count(announced, "nodes", 8);  // "0 0 0 0\n"
  const int n = static_cast<int>(announced);
  x.resize(3 * n);
  long long base = 0;
  for (int i = 0; i < n; ++i) {
    if (in.bytes_left() == 0) in.fail("file ends at node ", i, "; the header announces ", n);
    const long long index = in.integer(What("the number of node", i));
    if (i == 0) base = index;
    if (base != 0 && base != 1) in.fail("first node has number ", base, "; must be 0 or 1");
    if (index != base + i) in.fail("node number ", index, " follows ", base + i - 1, "; must be consecutive");
    for (int k = 0; k < 3; ++k) x[3 * i + k] = in.coordinate(What("a coordinate of node", index), options.lenient);
    for (int k = 0; k < extras; ++k) in.number(What("an attribute or marker of node", index), true);
  }
  if (const auto extra = in.word())
    in.fail("data ", in_quotes(*extra), " after the ", n, " nodes the header announces");
  return static_cast<int>(base);
}

/// The file of the pair that ends in `extension`: `path` itself, or one beside it, in small letters or in capitals.
std::string of_pair(const std::string& path, std::string extension) {
  namespace fs = std::filesystem;
  if (mesh_extension(path) == extension) return path;
  const std::string small = fs::path(path).replace_extension(extension).string();
  std::string& capitals = extension;
  for (char& c : capitals) c = upper(c);
  const std::string large = fs::path(path).replace_extension(capitals).string();
  std::error_code error;
  return fs::exists(large, error) && !fs::exists(small, error) ? large : small;
}

}  // namespace

std::string other_of_pair(const std::string& path) {
  const std::string extension = mesh_extension(path);
  if (extension == ".node") return of_pair(path, ".ele");
  return extension == ".ele" ? of_pair(path, ".node") : std::string();
}

Mesh read_node_ele(const std::string& path, const LoadOptions& options, Notes& notes) {
  const std::string nodes = of_pair(path, ".node"), elements = of_pair(path, ".ele");
  Mesh mesh;
  const int base = read_nodes(nodes, options, mesh.x);
  TextReader in(elements, text_content(elements, options));
  const int n = in.count("tetrahedra", 10);  // "0 0 1 2 3\n"
  const long long corners = in.integer("the number of nodes of a tetrahedron");
  if (corners != 4 && corners != 10) in.fail("tetrahedra have ", corners, " nodes; must be 4 or 10");
  const int extras = in.count("attributes", 1) + static_cast<int>(corners) - 4;
  mesh.tetrahedra.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    if (in.bytes_left() == 0) in.fail("file ends at tetrahedron ", i, "; the header announces ", n);
    in.integer(What("the number of tetrahedron", i));
    Tetrahedron t{};
    for (int& corner : t) {
      const long long number = in.integer(What("a node of tetrahedron", i));
      if (number < base || number > mesh.num_nodes() - 1 + base)
        in.fail("node ", number, " of tetrahedron ", i, " is out of range ", base, "..", mesh.num_nodes() - 1 + base);
      corner = static_cast<int>(number - base);
    }
    mesh.tetrahedra.push_back(t);
    for (int k = 0; k < extras; ++k) in.number(What("an attribute of tetrahedron", i), true);
  }
  if (const auto extra = in.word()) in.fail("data ", in_quotes(*extra), " after the ", n, " tetrahedra announced");
  if (corners == 10) notes.push_back("quadratic tetrahedra: the mid-edge nodes are not used");
  finish_solid(mesh, elements, options, notes);
  return mesh;
}

}  // namespace kt
