#pragma once
// Where the material of a lattice is: at points finer than its cubes, how deep inside the surface they are, and with
// which of them they hang together. Parts of a cube that a gap separates, however narrow, are pieces of their own.
#include <optional>

#include "io/solid/cell_moments.hpp"
#include "io/surface/winding_number.hpp"

namespace kt {

constexpr int kCubePoints = 4;  // along each edge, and one
constexpr int kWide = kCubePoints + 1;
constexpr int kAllPoints = kWide * kWide * kWide;

/// Points of a cube are numbered along x, then y, then z.
constexpr std::array<int, 3> at_point(int point) {
  return {point % kWide, point / kWide % kWide, point / kWide / kWide};
}
constexpr int point_at(const std::array<int, 3>& at) { return at[0] + kWide * (at[1] + kWide * at[2]); }
constexpr std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

/// Nearer to the surface than so much of an edge is on it: rounding.
inline constexpr double kOnSurface = 1e-7;

/// Material of a cube that hangs together in it.
struct CubePiece {
  int cube = 0;
  std::array<CellMoments, 6> cell;  ///< each of the cube's tetrahedra
};

class LatticeMaterial final : public MaterialField {
 public:
  /// @param closes  as LatticeReport::closes: what is inside is found out once for all that the surface does not part
  LatticeMaterial(Mesh surface, bool closes);

  const Mesh& surface() const { return surface_; }
  const WindingNumber& winding() const { return winding_; }
  /// Which of the cubes that the surface does not touch are inside.
  std::vector<char> full_cubes(const LatticeGrid& grid, const std::vector<char>& touched) const;

  /// Looks at the points of the cubes that the surface passes through.
  void cut(const LatticeGrid& grid);
  /// Where the vertices of a surface are, in pieces of `holder`'s cubes just below them; pieces that the surface goes
  /// along are one. A cube without material gets a piece where it has a vertex.
  /// @param below   the vertices' places, a little inside      @returns pieces
  std::vector<int> hold(const std::vector<Vec3>& below, const std::vector<Triangle>& triangles);
  /// Fills the moments of pieces. After hold().
  void measure();

  const std::vector<CubePiece>& pieces() const { return pieces_; }
  /// Corners of pieces (8 each, piece by piece, x first) that are one and the same: the first of these. After hold().
  std::vector<int> join_corners();

  int cut_cubes() const { return static_cast<int>(cut_.size()); }
  int parted_cubes() const;  ///< of several pieces
  double unsure() const;     ///< share of the points near the surface that this winds around 1/4 to 3/4 times

  /// Piece of each cell of the mesh that is_whole() and depth() are asked for.
  void name_cells(std::vector<int> piece_of_cell) { piece_of_cell_ = std::move(piece_of_cell); }
  bool is_whole(int cell) const override;
  double depth(int cell, const Vec3& place, double most) const override;

 private:
  struct CutCube {
    int cube = 0;
    std::array<float, kAllPoints> depth{};            // [m], at most cap_ either way
    std::array<Eigen::Vector3f, kAllPoints> slope{};  // of the depth; zero: not known
    std::array<int, kAllPoints> piece{};              // -1: outside
    bool is_thin = false;                             // less material than its points see
  };

  int cut_of(int cube) const { return cut_of_cube_[static_cast<std::size_t>(cube)]; }
  Vec3 place_of(int cube, int point) const;
  void find_depths();
  void find_pieces();
  std::vector<int> connect(const CutCube& cube) const;
  int seen_from(const CutCube& cube, const Vec3& place) const;
  int nearest_to(const CutCube& cube, const Vec3& place) const;
  void look_below(const CutCube& cube, const std::vector<int>& vertices, const std::vector<Vec3>& below,
                  std::vector<int>& piece, std::vector<char>& is_sure) const;
  void add_material(const CutCube& cube, int small, int piece, CellMoments& out) const;
  Vec3 step(int from, int to) const;  // from one of a cube's points to another
  void measure_by_depth(const CutCube& cube);
  std::array<double, 2> known_beside(const CutCube& cube, const Vec3& place) const;
  void measure_by_samples(const CutCube& cube);
  void join_by_points(std::vector<int>& same) const;
  int new_piece(int cube);

  Mesh surface_;
  WindingNumber winding_;
  bool closes_;
  LatticeGrid grid_;
  double cap_ = 0;
  std::vector<char> is_full_;     // cubes that the surface does not pass through
  std::vector<int> cut_of_cube_;  // -1: the surface does not pass through it
  std::vector<CutCube> cut_;
  std::vector<CubePiece> pieces_;
  std::vector<std::vector<int>> pieces_of_cube_;
  std::vector<std::array<int, 2>> seams_;  // pieces of neighbouring cubes that the surface joins
  std::vector<int> piece_of_cell_;
  long unsure_ = 0, inside_ = 0;
};

}  // namespace kt
