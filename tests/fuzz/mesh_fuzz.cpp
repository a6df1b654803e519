// Mesh files of whatever bytes a fuzzer makes up: each is a mesh, valid in all that load_mesh promises, or one
// InputError of one line. What `kilotouch mesh info` and `mesh repair` do next with the mesh is done too.
//
//     scripts/fuzz mesh_fuzz
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>

#include "core/base/error.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/mesh/weld.hpp"
#include "io/surface/mesh_doctor.hpp"
#include "io/surface/mesh_repair.hpp"
#include "tests/fuzz/require.hpp"

using kt::fuzz::require;

namespace {

using kt::Mesh;

constexpr const char* kNames[] = {"a.obj", "a.off", "a.ply", "a.stl", "a.node", "a.msh", "a.vtu", "a.vtk", "a.mesh"};
constexpr int kFormats = static_cast<int>(std::size(kNames));
constexpr char kNextFile = 1;  // a byte between a .node and its .ele

/// One line that a terminal can show.
void check_message(const std::string& message) {
  require(message.size() < 1000, "a message is short");
  for (const char c : message) require(c >= ' ' && c < 127, "a message is one line of plain characters");
}

void check_mesh(const Mesh& mesh, bool is_lenient) {
  const int n = mesh.num_nodes();
  require(n > 0 && mesh.x.size() == 3 * n, "there are nodes");
  require(is_lenient || !mesh.triangles.empty() || !mesh.tetrahedra.empty(), "there are faces");
  require(is_lenient || mesh.x.allFinite(), "coordinates are finite");
  for (const kt::Triangle& t : mesh.triangles)
    for (const int i : t) require(i >= 0 && i < n, "corners are nodes");
  for (const kt::Tetrahedron& t : mesh.tetrahedra) {
    for (const int i : t) require(i >= 0 && i < n, "corners are nodes");
    require(is_lenient || kt::tetrahedron_volume(mesh.x, t) > 0, "tetrahedra are positive");
  }
}

Mesh load(const std::string& name, std::string_view bytes, bool is_lenient) {
  const auto read_file = [&](const std::string& path) {
    const std::size_t cut = name == "a.node" ? bytes.find(kNextFile) : std::string_view::npos;
    if (path.ends_with(".ele")) return std::string(cut == std::string_view::npos ? "" : bytes.substr(cut + 1));
    return std::string(bytes.substr(0, cut));
  };
  Mesh mesh = kt::load_mesh(name, {.lenient = is_lenient, .read_file = read_file});
  check_mesh(mesh, is_lenient);
  return mesh;
}

/// Everything that looks at a mesh, and what is printed of it.
void look_at(const Mesh& mesh) {
  kt::find_near_nodes(mesh);
  const kt::MeshReport report = kt::examine(mesh, {.self_intersections = false});
  for (const kt::DefectList& list : kt::defects(report))
    if (!list.places->empty()) kt::describe(list.places->front());
}

void mend(const Mesh& mesh) {
  const Mesh repaired = kt::repair(mesh).mesh;
  check_mesh(repaired, !mesh.tetrahedra.empty());  // flat tetrahedra stay
  look_at(repaired);
}

/// The text formats keep every bit.
void write_and_read_back(const std::string& name, const Mesh& mesh) {
  if (!mesh.x.allFinite()) return;
  if (name == "a.obj") require(load(name, kt::write_obj(mesh), true).x == mesh.x, "OBJ reads back");
  if (name == "a.off") require(load(name, kt::write_off(mesh), true) == mesh, "OFF reads back");
  if (name == "a.msh") require(load(name, kt::write_msh(mesh), true).x == mesh.x, "MSH reads back");
  if (name == "a.vtu") require(load(name, kt::write_vtu(mesh), true).x == mesh.x, "VTU reads back");
}

}  // namespace

/// First byte: the format, and what is done with the mesh.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::string name = kNames[data[0] % kFormats];
  const int choice = data[0] / kFormats;
  const bool is_lenient = choice % 2 == 1;
  try {
    const Mesh mesh = load(name, {reinterpret_cast<const char*>(data) + 1, size - 1}, is_lenient);
    switch (choice / 2 % 4) {  // half of them only read: the rest takes most of the time
      case 0:
        look_at(mesh);
        mend(mesh);
        break;
      case 1:
        write_and_read_back(name, mesh);
        break;
      default:
        break;
    }
  } catch (const kt::InputError& error) {
    check_message(error.what());
  }
  return 0;
}
