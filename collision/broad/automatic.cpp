// The faster of the backends for the number of triangles (docs/collision.md has both measured).
#include "collision/broad/triangle_index.hpp"

namespace kt {
namespace {

constexpr std::size_t kFew = 4096;  // triangles

class AutomaticIndex final : public TriangleIndex {
 public:
  void build(std::span<const Triangle> triangles, const VectorX& x) override {
    chosen_ = make_triangle_index(triangles.size() <= kFew ? "flat" : "refit_bvh");
    chosen_->build(triangles, x);
  }
  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override { chosen_->refit(x_t0, x_t1); }
  void refit_moved(std::span<const int> vertices, const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    chosen_->refit_moved(vertices, x_t0, x_t1);
  }
  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    return chosen_->candidates(sweep, margin, out);
  }

 private:
  std::unique_ptr<TriangleIndex> chosen_ = make_triangle_index("flat");  // until there are triangles
};

}  // namespace

std::unique_ptr<TriangleIndex> make_auto_triangle_index() { return std::make_unique<AutomaticIndex>(); }

}  // namespace kt
