// A body's physics of one's own: four functions. The tangent is found by differences until update_tangent is written.
#include <cstdio>
#include <kilotouch/kilotouch.hpp>

/// Every node hangs on a spring to its place: a mattress of felt.
class Felt final : public kt::DeformableModel {
 public:
  explicit Felt(kt::Mesh mesh) : mesh_(std::move(mesh)), mass_(mesh_.x.size(), mesh_.x.size()) {
    mass_.setIdentity();
    mass_ *= 2e-5;  // kg a node
    const double bottom = kt::bounds(mesh_).min.z();
    for (int i = 0; i < mesh_.num_nodes(); ++i)
      if (mesh_.x[3 * i + 2] < bottom + 1e-3) fixed_.push_back(i);
  }
  const kt::Mesh& mesh() const override { return mesh_; }
  const kt::SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return fixed_; }
  void force(const kt::State& s, kt::VectorX& out) const override {
    out = -15 * (s.x - mesh_.x) - 0.02 * s.v;  // N/m, N s/m
  }

 private:
  kt::Mesh mesh_;
  kt::SparseMatrix mass_;
  std::vector<int> fixed_;
};

int main() {
  const kt::Mesh mesh = kt::load_mesh("meshes/block.msh");
  const kt::ModelCheck check = kt::check_model(Felt(mesh), {.anchored = true});
  std::printf("%s", check.text().c_str());
  const kt::Body body(std::make_unique<Felt>(mesh));
  kt::TouchOptions options;
  options.local.reducer = "wall";
  kt::Touch touch(body, options);
  const double top = kt::bounds(mesh).max.z() + 0.004;
  kt::LocalFrame f;
  for (int i = 1; i <= 300; ++i) f = touch.tick(kt::Pose{{0.03, 0.026, top - 1e-5 * i}});
  std::printf("3 mm deep: %.4f N\n", f.f_n);
  return check.passed() && f.f_n > 0 ? 0 : 1;
}
