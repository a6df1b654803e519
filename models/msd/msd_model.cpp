// Mass-spring-damper network: f_ab = (k (|d| - L) + c (d'.u)) u with d = x_b - x_a, u = d / |d|.   Paper section III.
#include <mutex>

#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/fine/isotropic_cells.hpp"
#include "models/embedded_model.hpp"
#include "models/model.hpp"
#include "models/msd/calibration.hpp"
#include "models/msd/spring_tangent.hpp"
#include "models/msd/volume_guard.hpp"

namespace kt {
namespace {

class MsdModel final : public DeformableModel, public Refinable {
 public:
  /// @param share  of each tetrahedron, how much of it is material; empty: all
  MsdModel(Mesh mesh, const ModelOptions& options, std::vector<double> share = {})
      : mesh_(std::move(mesh)), options_(options), share_(std::move(share)) {
    springs_ = make_springs(mesh_);
    make_mass();  // refuses nodes without an element, which the calibration would stumble over
    if (options.stiffness)
      make_even(springs_);
    else
      calibration_ = calibrate_springs(mesh_, options.young, options.poisson, springs_, share_);
    // After calibration: that is a statement about the body without them.
    const std::vector<double> factors = stiffness_factors(mesh_, options.inclusions);
    stiffen(mesh_, factors, springs_);
    stiffened_ = num_stiffened(factors);
    for (Spring& s : springs_) s.damper = options.damper.value_or(options.damping_stiffness * s.stiffness);
    guards_ = make_volume_guards(mesh_, springs_, options.least_volume);
    tangent_ = SpringTangent(mesh_.num_nodes(), springs_);
    for (int d = 0; d < mesh_.x.size(); ++d) diagonal_.push_back(slot(d, d));
  }

  const Mesh& mesh() const override { return mesh_; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return options_.fixed_nodes; }

  void force(const State& state, VectorX& out) const override {
    out = -options_.damping_mass * mass_diagonal_.cwiseProduct(state.v);
    if (!options_.gravity.isZero(0))
      out += mass_diagonal_.cwiseProduct(options_.gravity.replicate(mesh_.num_nodes(), 1));
    for (const Spring& s : springs_) {
      const Stretch now = stretch(s, state);
      const Vec3 f = (s.stiffness * (now.length - s.rest_length) + s.damper * now.rate) * now.direction;
      node(out, s.a) += f;
      node(out, s.b) -= f;
    }
    Eigen::Matrix<double, 3, 4> push;
    for (const VolumeGuard& g : guards_)
      if (guard_force(g, state.x, push))
        for (int i = 0; i < 4; ++i) node(out, g.nodes[i]) += push.col(i);
  }

  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    tangent_.update(springs_, state, kind, out);
    double* dfdx = out.dfdx.valuePtr();
    double* dfdv = out.dfdv.valuePtr();
    GuardForce push;
    for (const VolumeGuard& g : guards_)
      if (guard_force(g, state.x, kind == TangentKind::definite, push)) add_guard(dfdx, g.nodes, push.dfdx);
    for (Eigen::Index d = 0; d < mass_diagonal_.size(); ++d)
      dfdv[diagonal_[d]] -= options_.damping_mass * mass_diagonal_[d];
  }

  std::span<const int> cell_nodes(int cell) const override { return mesh_.tetrahedra[cell]; }
  /// Of the solid that the springs stand for.
  Moduli moduli(TangentKind, const Mat3& F, const Mat3&) const override {
    const IsotropicSolid& s = solid();
    return isotropic_moduli(s.young, s.poisson, nearest_rotation(F));
  }
  double stiffness_factor(const Vec3& place) const override { return stiffness_in(options_.inclusions, place); }
  double retardation() const override {
    if (!options_.damper) return options_.damping_stiffness;
    double sum = 0;
    for (const Spring& s : springs_) sum += s.stiffness;
    return sum > 0 ? *options_.damper * static_cast<double>(springs_.size()) / sum : 0;
  }

  ModelInfo info() const override {
    ModelInfo out{"msd", "", {}};
    out.parameters = {{"springs", static_cast<double>(springs_.size())},
                      {"density", options_.density},
                      {"stiffened_elements", stiffened_},
                      {"damping_mass", options_.damping_mass},
                      {"damping_stiffness", options_.damping_stiffness}};
    if (options_.stiffness) {
      out.parameters["stiffness"] = *options_.stiffness;
    } else {
      out.parameters.insert({{"young", options_.young},
                             {"poisson", options_.poisson},
                             {"calibration_residual", calibration_.residual},
                             {"calibration_young_error", calibration_.young_error},
                             {"calibration_shear_error", calibration_.shear_error}});
    }
    return out;
  }

 private:
  void make_even(std::vector<Spring>& springs) const {
    for (Spring& s : springs) s.stiffness = *options_.stiffness;
    stiffen(mesh_, share_, springs);
  }

  void make_mass() {
    double length = 0;
    for (const Spring& s : springs_) length += s.rest_length;
    // A surface without inside is a membrane; a tenth of its mean edge stands for its thickness.
    const VectorX nodal =
        lumped_masses(mesh_, options_.density, 0.1 * length / static_cast<double>(springs_.size()), share_);
    mass_diagonal_.resize(mesh_.x.size());
    for (int i = 0; i < mesh_.num_nodes(); ++i) {
      if (!(nodal[i] > 0)) throw InputError(text("msd: node ", i, " belongs to no element and would have no mass"));
      node(mass_diagonal_, i).setConstant(nodal[i]);
    }
    mass_ = SparseMatrix(mass_diagonal_.asDiagonal());
  }

  /// What calibrated springs were made for; of others the solid nearest to what the network does.
  const IsotropicSolid& solid() const {
    std::call_once(solid_is_known_, [this] {
      solid_ = {options_.young, options_.poisson};
      if (!options_.stiffness || mesh_.tetrahedra.empty()) return;
      std::vector<Spring> even = springs_;  // without inclusions
      make_even(even);
      solid_ = nearest_isotropic(network_elasticity(mesh_, even, share_));
    });
    return solid_;
  }

  /// Where an entry of the pattern lies.
  int slot(int row, int column) const {
    const SparseMatrix& pattern = tangent_.pattern();
    const int* begin = pattern.innerIndexPtr() + pattern.outerIndexPtr()[column];
    const int* end = pattern.innerIndexPtr() + pattern.outerIndexPtr()[column + 1];
    return static_cast<int>(std::lower_bound(begin, end, row) - pattern.innerIndexPtr());
  }

  void add_guard(double* values, const Tetrahedron& nodes, const Eigen::Matrix<double, 12, 12>& dfdx) const {
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 4; ++i) {
        double* column = values + slot(3 * nodes[i], 3 * nodes[j / 3] + j % 3);
        for (int r = 0; r < 3; ++r) column[r] += dfdx(3 * i + r, j);
      }
  }

  Mesh mesh_;
  ModelOptions options_;
  std::vector<double> share_;
  std::vector<Spring> springs_;
  std::vector<VolumeGuard> guards_;
  Calibration calibration_;
  int stiffened_ = 0;  // elements in inclusions
  VectorX mass_diagonal_;
  SparseMatrix mass_;
  SpringTangent tangent_;
  std::vector<int> diagonal_;
  mutable std::once_flag solid_is_known_;
  mutable IsotropicSolid solid_;
};

}  // namespace

std::unique_ptr<DeformableModel> make_msd_model(Mesh mesh, const ModelOptions& options) {
  if (!mesh.embedded) return std::make_unique<MsdModel>(std::move(mesh), options);
  ModelOptions of_cells = options;
  of_cells.fixed_nodes = own_fixed_nodes(mesh, options.fixed_nodes);
  auto cells = std::make_unique<MsdModel>(without_embedded(mesh), of_cells, mesh.embedded->share);
  return embed_surface(std::move(mesh), std::move(cells));
}

}  // namespace kt
