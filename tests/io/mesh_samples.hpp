#pragma once
// Where test meshes are, and small ones made by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "io/files/child_process.hpp"
#include "io/mesh/mesh_io.hpp"
#include "tests/support/test_data.hpp"

namespace kt {

inline std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> out;
  if (std::filesystem::is_directory(folder))
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const auto known = readable_mesh_extensions();
      if (std::find(known.begin(), known.end(), mesh_extension(entry.path().string())) != known.end())
        out.push_back(entry.path().string());
    }
  std::sort(out.begin(), out.end());
  return out;
}

/// The project's own good surfaces.
inline std::vector<std::string> own_meshes() {
  std::vector<std::string> out = files_in(KT_SOURCE_DIR "/meshes");
  std::erase_if(out, [](const std::string& f) { return mesh_extension(f) != ".off"; });
  return out;
}

/// Real meshes of the test data; empty where the folder is not there. A test of nothing else is skipped then.
constexpr const char* kNoMeshes = "no meshes in the test data";
inline std::vector<std::string> real_meshes() { return files_in(test_data() + "/meshes"); }

inline std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

/// A disc, 100 mm wide and 2 mm thick, as CAD draws it: both faces are fans of needles.
inline Mesh thin_disc(int segments) {
  Mesh out;
  out.x.resize(6 * segments);
  for (int i = 0; i < segments; ++i) {
    const double a = 2 * std::numbers::pi * i / segments;
    for (int side = 0; side < 2; ++side)
      node(out.x, 2 * i + side) = Vec3(0.05 * std::cos(a), 0.05 * std::sin(a), 0.002 * side);
    const int b = 2 * ((i + 1) % segments);
    out.triangles.push_back({2 * i, b, b + 1});
    out.triangles.push_back({2 * i, b + 1, 2 * i + 1});
    if (i == 0 || i == segments - 1) continue;
    out.triangles.push_back({0, b, 2 * i});
    out.triangles.push_back({1, 2 * i + 1, b + 1});
  }
  return out;
}

inline std::string write_sample(const PrivateFolder& folder, const std::string& name, const std::string& content) {
  std::ofstream(folder / name, std::ios::binary) << content;
  return folder / name;
}

/// what() of the InputError that f throws, without the folder; "" when it does not throw.
template <class F>
std::string input_error(const PrivateFolder& folder, F&& f) {
  try {
    f();
  } catch (const InputError& e) {
    std::string what = e.what();
    const std::string prefix = folder.path() + "/";
    for (std::size_t at; (at = what.find(prefix)) != std::string::npos;) what.erase(at, prefix.size());
    return what;
  }
  return "";
}

inline Mesh tetrahedron_surface() {
  Mesh mesh;
  mesh.x = VectorX{{0, 0, 0, 0.02, 0, 0, 0, 0.02, 0, 0, 0, 0.02}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

/// Each list in a canonical order, to compare meshes that differ in order only.
inline std::vector<Triangle> sorted_triangles(std::vector<Triangle> list) {
  for (Triangle& t : list) std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  std::sort(list.begin(), list.end());
  return list;
}

}  // namespace kt
