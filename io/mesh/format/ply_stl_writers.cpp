// PLY and STL are written by us: the library's writers round coordinates to 6 digits or to floats.
#include <Eigen/Geometry>
#include <bit>
#include <cstdint>

#include "core/base/error.hpp"
#include "io/mesh/mesh_formats.hpp"

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY and STL files are written little-endian");

template <class T>
void append_bytes(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string write_ply(const Mesh& mesh) {
  std::string out = text("ply\nformat binary_little_endian 1.0\nelement vertex ", mesh.num_nodes(),
                         "\nproperty double x\nproperty double y\nproperty double z\nelement face ",
                         mesh.triangles.size(), "\nproperty list uchar int vertex_indices\nend_header\n");
  for (const double value : mesh.x) append_bytes(out, value);
  for (const Triangle& t : mesh.triangles) {
    append_bytes(out, std::uint8_t{3});
    for (const int i : t) append_bytes(out, static_cast<std::int32_t>(i));
  }
  return out;
}

std::string write_stl(const Mesh& mesh) {
  std::string out = "binary STL written by kilotouch";  // must not start with "solid", or readers take it for text
  out.resize(80, ' ');
  append_bytes(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = node(mesh.x, t[0]);
    const Vec3 n = (node(mesh.x, t[1]) - a).cross(node(mesh.x, t[2]) - a).stableNormalized();
    for (int k = 0; k < 3; ++k) append_bytes(out, static_cast<float>(n[k]));
    for (const int i : t)
      for (int k = 0; k < 3; ++k) append_bytes(out, static_cast<float>(mesh.x[3 * i + k]));
    append_bytes(out, std::uint16_t{0});
  }
  return out;
}

}  // namespace kt
