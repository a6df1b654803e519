#include "models/embedded_model.hpp"

#include <numeric>

#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/body/refinable.hpp"

namespace kt {
namespace {

class EmbeddedModel final : public DeformableModel, public Refinable {
 public:
  EmbeddedModel(Mesh mesh, std::unique_ptr<DeformableModel> cells)
      : mesh_(std::move(mesh)),
        cells_(std::move(cells)),
        material_(dynamic_cast<const Refinable*>(cells_.get())),
        own_(3 * static_cast<Eigen::Index>(mesh_.num_own_nodes())),
        mass_(cells_->mass()),
        fixed_(cells_->fixed_nodes()) {
    if (!material_) throw InputError("embedded surface: the cells' model tells nothing of its material");
    mass_.conservativeResize(mesh_.x.size(), mesh_.x.size());
    const std::size_t clamped = fixed_.size();
    fixed_.resize(clamped + static_cast<std::size_t>(mesh_.num_nodes() - mesh_.num_own_nodes()));
    std::iota(fixed_.begin() + static_cast<std::ptrdiff_t>(clamped), fixed_.end(), mesh_.num_own_nodes());
  }

  const Mesh& mesh() const override { return mesh_; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return fixed_; }

  void force(const State& state, VectorX& out) const override {
    VectorX own;
    cells_->force(own_state(state), own);
    out.resize(mesh_.x.size());
    out.head(own_) = own;
    out.tail(out.size() - own_).setZero();
  }
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    for (SparseMatrix* matrix : {&out.dfdx, &out.dfdv})
      if (matrix->rows() > own_) matrix->conservativeResize(own_, own_);
    cells_->update_tangent(own_state(state), kind, out);
    for (SparseMatrix* matrix : {&out.dfdx, &out.dfdv}) matrix->conservativeResize(mesh_.x.size(), mesh_.x.size());
  }
  const DeformableModel& own() const override { return *cells_; }
  ModelInfo info() const override {
    ModelInfo out = cells_->info();
    out.parameters["embedded_vertices"] = mesh_.embedded->num_vertices();
    return out;
  }

  std::span<const int> cell_nodes(int cell) const override { return material_->cell_nodes(cell); }
  Moduli moduli(TangentKind kind, const Mat3& F, const Mat3& rate) const override {
    return material_->moduli(kind, F, rate);
  }
  double stiffness_factor(const Vec3& place) const override { return material_->stiffness_factor(place); }
  double retardation() const override { return material_->retardation(); }

 private:
  State own_state(const State& state) const { return {state.t, state.x.head(own_), state.v.head(own_)}; }

  Mesh mesh_;
  std::unique_ptr<DeformableModel> cells_;
  const Refinable* material_;
  Eigen::Index own_;  // coordinates
  SparseMatrix mass_;
  std::vector<int> fixed_;
};

}  // namespace

Mesh without_embedded(const Mesh& mesh) {
  return {mesh.x.head(3 * static_cast<Eigen::Index>(mesh.num_own_nodes())), boundary_triangles(mesh.tetrahedra),
          mesh.tetrahedra};
}

std::vector<int> own_fixed_nodes(const Mesh& mesh, const std::vector<int>& fixed) {
  std::vector<int> out;
  std::ranges::copy_if(fixed, std::back_inserter(out), [&](int i) { return i < mesh.num_own_nodes(); });
  return out;
}

std::unique_ptr<DeformableModel> embed_surface(Mesh mesh, std::unique_ptr<DeformableModel> cells) {
  return std::make_unique<EmbeddedModel>(std::move(mesh), std::move(cells));
}

}  // namespace kt
