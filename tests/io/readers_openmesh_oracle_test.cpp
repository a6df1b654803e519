// Our OBJ and OFF readers against OpenMesh's, on real files that OpenMesh reads in full.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#pragma GCC diagnostic pop

#include "tests/io/mesh_samples.hpp"

namespace kt {
namespace {

/// OpenMesh reads nothing out of an OFF file that has a comment below its first line, as the project's own have: a copy
/// without comments, or the file itself.
std::string without_comments(const std::string& file, const PrivateFolder& folder) {
  if (mesh_extension(file) != ".off") return file;
  std::ifstream in(file);
  std::string text;
  for (std::string line; std::getline(in, line);)
    if (!line.starts_with('#')) text += line + "\n";
  return write_sample(folder, file_name(file), text);
}

/// Whether OpenMesh read all of a file, so that it could be compared.
bool agrees_with_openmesh(const std::string& f, const PrivateFolder& folder) {
  const std::string name = file_name(f);
  // OpenMesh reads nothing out of the odd files and doubles the nodes of the non-manifold ones.
  if (mesh_extension(f) == ".stl" || name.starts_with("malformed") || name.starts_with("nonmanifold")) return false;
  const Mesh mesh = load_mesh(f);
  OpenMesh::PolyMesh_ArrayKernelT<> other;
  EXPECT_TRUE(OpenMesh::IO::read_mesh(other, without_comments(f, folder))) << f;
  if (static_cast<int>(other.n_vertices()) != mesh.num_nodes()) return false;  // its half-edges made copies
  double difference = 0;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    for (int k = 0; k < 3; ++k)
      difference = std::max(
          difference, std::abs(mesh.x[3 * i + k] -
                               static_cast<double>(other.point(other.vertex_handle(static_cast<unsigned>(i)))[k])));
  EXPECT_LE(difference, 1.2e-7 * mesh.x.lpNorm<Eigen::Infinity>()) << f;
  std::size_t triangles = 0;
  for (const auto face : other.faces()) triangles += other.valence(face) - 2;
  EXPECT_EQ(triangles, mesh.triangles.size()) << f;
  return true;
}

TEST(Readers, AgreeWithOpenMeshToFloatPrecision) {
  const PrivateFolder folder;
  ::omerr().disable();
  for (const std::string& f : own_meshes()) EXPECT_TRUE(agrees_with_openmesh(f, folder)) << f;
  int compared = 0;
  for (const std::string& f : real_meshes()) compared += agrees_with_openmesh(f, folder);
  ::omerr().enable();
  EXPECT_GE(compared, real_meshes().empty() ? 0 : 25);
}

}  // namespace
}  // namespace kt
