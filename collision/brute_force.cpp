// Tests the swept box of every triangle: exact in double precision, the oracle of the other backends.
#include "collision/triangle_index.hpp"

namespace kt {
namespace {

class BruteForce final : public TriangleIndex {
 public:
  void build(std::span<const Triangle> triangles, const VectorX& x) override {
    triangles_.assign(triangles.begin(), triangles.end());
    low_.resize(triangles_.size());
    high_.resize(triangles_.size());
    refit(x, x);
  }

  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      Vec3 low = node(x_t0, triangles_[t][0]), high = low;
      for (int i : triangles_[t]) {
        low = low.cwiseMin(node(x_t0, i)).cwiseMin(node(x_t1, i));
        high = high.cwiseMax(node(x_t0, i)).cwiseMax(node(x_t1, i));
      }
      low_[t] = low;
      high_[t] = high;
    }
  }

  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    const Vec3 low = sweep.x_t0.cwiseMin(sweep.x_t1).array() - margin;
    const Vec3 high = sweep.x_t0.cwiseMax(sweep.x_t1).array() + margin;
    int found = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      // Written so that a NaN counts as near: it must not make a triangle vanish.
      if (!((low_[t].array() > high.array()).any() || (high_[t].array() < low.array()).any()))
        out[found++] = static_cast<int>(t);
    return found;
  }

 private:
  std::vector<Triangle> triangles_;
  std::vector<Vec3> low_, high_;
};

}  // namespace

std::unique_ptr<TriangleIndex> make_brute_force_triangle_index() { return std::make_unique<BruteForce>(); }

}  // namespace kt
