// CGAL's tree over the swept boxes: a second opinion for tests and comparisons, not for the haptic tick. It has no
// refit, so every refit builds anew and asks for memory.
//
// A kernel of doubles suffices: boxes are only compared. Still everything CGAL names is sifted with our own comparison.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>

#include "collision/broad/triangle_index.hpp"
#include "collision/shape/swept_box.hpp"

namespace kt {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;

/// A swept box as CGAL wants its primitives.
class BoxPrimitive {
 public:
  using Id = int;
  using Point = Kernel::Point_3;
  using Datum = Kernel::Iso_cuboid_3;

  BoxPrimitive(int triangle, const Box& box)
      : triangle_(triangle),
        cuboid_(Point(box.low.x(), box.low.y(), box.low.z()), Point(box.high.x(), box.high.y(), box.high.z()), 0) {}
  Id id() const { return triangle_; }
  Datum datum() const { return cuboid_; }
  Point reference_point() const { return cuboid_.min(); }

 private:
  Id triangle_;
  Datum cuboid_;
};

using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, BoxPrimitive>>;

/// Counts what the tree names, and keeps what is near.
class Sieve {
 public:
  using iterator_category = std::output_iterator_tag;
  using value_type = void;
  using difference_type = void;
  using pointer = void;
  using reference = void;

  Sieve(const std::vector<Box>& boxes, const Box& path, std::span<int> out, int& count)
      : boxes_(&boxes), path_(&path), out_(out), count_(&count) {}
  Sieve& operator*() { return *this; }
  Sieve& operator++() { return *this; }
  Sieve& operator++(int) { return *this; }
  Sieve& operator=(int triangle) {
    if (!is_apart((*boxes_)[triangle], *path_)) out_[(*count_)++] = triangle;
    return *this;
  }

 private:
  const std::vector<Box>* boxes_;
  const Box* path_;
  std::span<int> out_;
  int* count_;
};

class CgalIndex final : public TriangleIndex {
 public:
  void build(std::span<const Triangle> triangles, const VectorX& x) override {
    triangles_.assign(triangles.begin(), triangles.end());
    boxes_.resize(triangles_.size());
    refit(x, x);
  }

  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    tree_.clear();
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      boxes_[t] = swept_box(triangles_[t], x_t0, x_t1);
      tree_.insert(BoxPrimitive(static_cast<int>(t), boxes_[t]));
    }
    tree_.build();
  }

  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    const Box path = path_box(sweep, margin);
    if (boxes_.empty()) return 0;
    int count = 0;
    tree_.all_intersected_primitives(BoxPrimitive(-1, path).datum(), Sieve(boxes_, path, out, count));
    std::sort(out.begin(), out.begin() + count);
    return count;
  }

 private:
  std::vector<Triangle> triangles_;
  std::vector<Box> boxes_;
  Tree tree_;
};

}  // namespace

std::unique_ptr<TriangleIndex> make_cgal_triangle_index() { return std::make_unique<CgalIndex>(); }

}  // namespace kt
