// Compares all triangles with the path, as floats first. Of some thousand triangles that is faster than keeping a tree
// in step with them: a tick asks for candidates a few times only.
#include "collision/broad/triangle_index.hpp"
#include "collision/broad/vertex_bounds.hpp"

namespace kt {
namespace {

typedef float Four __attribute__((vector_size(16)));
typedef int FourBits __attribute__((vector_size(16)));

/// The lower and the upper half of a bound.
struct Halves {
  explicit Halves(const Bound& bound) noexcept {
    __builtin_memcpy(&low, bound.side.data(), sizeof low);
    __builtin_memcpy(&high, bound.side.data() + 4, sizeof high);
  }
  Four low, high;
};

Four smaller(const Four& a, const Four& b) noexcept { return a < b ? a : b; }

class Flat final : public TriangleIndex {
 public:
  void build(std::span<const Triangle> triangles, const VectorX& x) override {
    triangles_.assign(triangles.begin(), triangles.end());
    bounds_.adopt(x);
    bounds_.fit(x, x);
  }

  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override { bounds_.fit(x_t0, x_t1); }

  void refit_moved(std::span<const int> vertices, const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    for (const int v : vertices) bounds_.fit(v, x_t0, x_t1);
  }

  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    const Box path = path_box(sweep, margin);
    const Halves far(bounds_.farthest_sides(path));
    int found = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      if (!is_beyond(triangles_[t], far) && !is_apart(bounds_.exact(triangles_[t]), path))
        out[static_cast<std::size_t>(found++)] = static_cast<int>(t);
    return found;
  }

 private:
  /// Some side of the triangle's bound is. All six are compared at once.
  bool is_beyond(const Triangle& t, const Halves& far) const noexcept {
    const Halves a(bounds_.of(t[0])), b(bounds_.of(t[1])), c(bounds_.of(t[2]));
    const FourBits beyond =
        (smaller(smaller(a.low, b.low), c.low) > far.low) | (smaller(smaller(a.high, b.high), c.high) > far.high);
    long long bits[2];
    __builtin_memcpy(bits, &beyond, sizeof bits);
    return (bits[0] | bits[1]) != 0;
  }

  std::vector<Triangle> triangles_;
  VertexBounds bounds_;
};

}  // namespace

std::unique_ptr<TriangleIndex> make_flat_triangle_index() { return std::make_unique<Flat>(); }

}  // namespace kt
