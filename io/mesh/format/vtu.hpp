#pragma once
// States for ParaView: VTU files (XML with raw binary data) and a PVD file that puts them on a time line.
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Values at the nodes: (n) scalars or (3n) vectors.
struct PointField {
  std::string name;
  VectorX values;
};

/// The .vtu text of a mesh at positions x (3n): tetrahedra, or triangles of a surface mesh.
/// @throws InputError when x or a field has the wrong length.
std::string vtu_text(const Mesh& mesh, const VectorX& x, const std::vector<PointField>& fields = {});

/// Writes one state; the file appears whole or not at all. @throws InputError when it cannot be written.
void save_vtu(const std::string& path, const Mesh& mesh, const VectorX& x, const std::vector<PointField>& fields = {});

/// A time series: NAME.pvd and NAME_000000.vtu, NAME_000001.vtu, ... beside it. The .pvd is complete after every add(),
/// so an interrupted run leaves a series that opens.
class PvdSeries {
 public:
  explicit PvdSeries(std::string path);  ///< ends in .pvd, else InputError

  /// Adds the state at time t [s].
  void add(double t, const Mesh& mesh, const VectorX& x, const std::vector<PointField>& fields = {});
  int size() const { return count_; }

 private:
  std::string path_, entries_;
  int count_ = 0;
};

}  // namespace kt
