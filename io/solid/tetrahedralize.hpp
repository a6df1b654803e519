#pragma once
// Fills a closed surface with tetrahedra. Backends: tetrahedralizer.def. Every backend runs in a child process with
// limits, because all of them crash, abort or hang on some bad surface; what comes back is checked before it is used.
#include <atomic>
#include <string>
#include <vector>

#include "core/base/backend.hpp"
#include "core/body/mesh.hpp"

namespace kt {

struct TetrahedralizeOptions {
  std::string name = "tetrahedralize";  ///< stands for the surface in messages: its file
  std::string backend = {};  ///< name in tetrahedralizer.def; empty: the first that fills it of those in this
                             ///< build, but none that makes a new surface where another is there
  double max_volume = 0;     ///< largest tetrahedron [m^3]; 0: automatic_max_volume(). Tetrahedra near the
                             ///< kept surface may be larger; for netgen and cgal it is a target
  double quality = 1.4;      ///< bound on radius / shortest edge [-], 1.1 .. 10 (a regular tetrahedron has 0.61)
  double timeout = 120;      ///< wall clock [s], > 0
  double memory_gb = 4;      ///< address space of the child, > 0
  const std::atomic<bool>* stop = nullptr;    ///< when set and true: the child is ended, ChildStopped
  std::vector<std::string>* notes = nullptr;  ///< gets a line where one has failed and another has filled the surface
};

/// The table of backends, in the order of the .def file.
std::vector<BackendInfo> tetrahedralizers();

/// 1.5 times the regular tetrahedron on the root-mean-square edge of the surface [m^3].
double automatic_max_volume(const Mesh& surface);

/// Tetrahedra inside a closed surface, all of positive volume. tetgen and netgen keep the surface: its nodes come first
/// with equal coordinates and its triangles stay as they are; cgal makes a new surface. Nodes of `surface` that no
/// triangle uses are dropped first. Cavities (inner surfaces turned inward) stay empty.
/// @throws InputError when the surface is open, not manifold, inside out or crosses itself: says where (coordinates,
///         face numbers); also for options out of range or a backend that is not in this build
/// @throws RunError when the backend itself fails or its result does not hold (count, volumes, total volume, surface)
Mesh tetrahedralize(const Mesh& surface, const TetrahedralizeOptions& options = {});

}  // namespace kt
