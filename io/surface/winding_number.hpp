#pragma once
// How often a surface winds around a place: 1 inside of a closed one, 0 outside, and in between where it is open, for
// surfaces that overlap, cross themselves or are no more than a heap of triangles (Jacobson, Kavan and Sorkine-Hornung
// 2013). Far triangles count as one dipole with its first derivative (Barill, Dickson, Schmidt, Levin and Jacobson
// 2018).
#include <optional>
#include <span>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Of all triangles, one by one.
double winding_number(const VectorX& x, std::span<const Triangle> triangles, const Vec3& place);

/// The same to within some hundredths, quickly. Const, and asked from any number of threads.
class WindingNumber {
 public:
  /// Borrows the surface.
  explicit WindingNumber(const Mesh& surface);
  double at(const Vec3& place) const;
  /// Of a surface that is inside out, too.
  bool is_inside(const Vec3& place) const { return std::abs(at(place)) > 0.5; }
  /// The nearest place of the surface; none within `most`.
  std::optional<Vec3> nearest(const Vec3& place, double most) const;
  /// To it [m]; `most` where there is none.
  double distance(const Vec3& place, double most) const;
  /// Whether the surface lies between two places that are inside: the way from one to the other leaves the material.
  bool parts(const Vec3& a, const Vec3& b) const;

  /// Share of the way from one place to another at which it first passes through the surface; none: it does not.
  std::optional<double> first_crossing(const Vec3& a, const Vec3& b) const;

 private:
  struct Branch {
    Vec3 centre;                        // mean of the triangles by area
    Vec3 area;                          // sum of their vector areas [m^2]
    Mat3 spread;                        // of (centroid - centre) area^T [m^3]
    double radius = 0;                  // of a ball around the centre that holds them [m]
    int begin = 0, end = 0, right = 0;  // triangles in order_; the second half, 0: a leaf
  };
  int build(int begin, int end);
  template <class Take>
  void visit_along(const Vec3& a, const Vec3& b, const Take& take) const;
  template <class IsNear, class Take>
  void visit(const IsNear& is_near, const Take& take) const;
  const Mesh& surface_;
  std::vector<int> order_;
  std::vector<Vec3> centroid_, area_;
  std::vector<Branch> branches_;  // the first half follows its parent
};

}  // namespace kt
