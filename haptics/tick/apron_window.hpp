#pragma once
// Which triangles of the body are the apron of a local model: of a usual body all, of a large one those nearest to the
// tools, found by a tree and chosen anew in the tick in which a tool comes near their end. So the apron reaches the
// whole surface, and a tick pays for a part of bounded size.
#include <limits>
#include <memory>

#include "collision/broad/triangle_index.hpp"
#include "core/contact_surface/apron.hpp"

namespace kt {

class ApronWindow {
 public:
  static constexpr int kTriangles = 1500, kVertices = 1000;  ///< at most, of a body that has more

  /// @param surface  borrowed       @param local_triangle  of each of the body's: of the patch, or -1
  /// @param x        of the whole body where it was linearized [m], (3n); borrowed
  ApronWindow(const Surface& surface, const VectorX& x, std::span<const int> local_triangle, ApronMotion motion,
              const std::string& collision_backend);

  const ApronMotion& motion() const noexcept { return motion_; }
  bool has_all() const noexcept { return !tree_; }
  int num_triangles() const noexcept { return most_triangles_; }  ///< at most
  int num_vertices() const noexcept { return most_vertices_; }

  /// Whether all that may come within `need` [m] of a place is in the window, or will not be in another one either.
  bool covers(int tool, const Vec3& place, double need) const noexcept;
  /// The triangles nearest to these places, ascending. No allocation.
  std::span<const int> choose(std::span<const Vec3> places) noexcept;

 private:
  int choose_near(const Vec3& place, std::size_t most, int vertices, double& reach) noexcept;
  const Surface& surface_;
  const VectorX& x_;
  std::span<const int> local_triangle_;
  ApronMotion motion_;
  std::unique_ptr<TriangleIndex> tree_;  // of the whole body; none: the window has all
  int most_triangles_ = 0, most_vertices_ = 0;
  double size_ = 0;  // of the body [m]
  struct Laid {
    Vec3 place = Vec3::Zero();
    double reach = std::numeric_limits<double>::infinity();  // [m] all within it is in the window
  };
  std::vector<Laid> laid_;  // of each tool
  std::vector<int> chosen_, candidates_, seen_node_;
  std::vector<char> is_chosen_;
  std::vector<std::pair<double, int>> by_distance_;
  int call_ = 0;
};

}  // namespace kt
