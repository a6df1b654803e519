// Tests the swept box of every triangle: exact in double precision, the oracle of the other backends.
#include "collision/broad/triangle_index.hpp"
#include "collision/shape/swept_box.hpp"

namespace kt {
namespace {

class BruteForce final : public TriangleIndex {
 public:
  void build(std::span<const Triangle> triangles, const VectorX& x) override {
    triangles_.assign(triangles.begin(), triangles.end());
    boxes_.resize(triangles_.size());
    refit(x, x);
  }

  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    for (std::size_t t = 0; t < triangles_.size(); ++t) boxes_[t] = swept_box(triangles_[t], x_t0, x_t1);
  }

  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    const Box path = path_box(sweep, margin);
    int found = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (!is_apart(boxes_[t], path)) out[static_cast<std::size_t>(found++)] = static_cast<int>(t);
    return found;
  }

 private:
  std::vector<Triangle> triangles_;
  std::vector<Box> boxes_;
};

}  // namespace

std::unique_ptr<TriangleIndex> make_brute_force_triangle_index() { return std::make_unique<BruteForce>(); }

}  // namespace kt
