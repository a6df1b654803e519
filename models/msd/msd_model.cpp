// Mass-spring-damper network: f_ab = (k (|d| - L) + c (d'.u)) u with d = x_b - x_a, u = d / |d|.   Paper section III.
#include "core/error.hpp"
#include "models/model.hpp"
#include "models/msd/calibration.hpp"
#include "models/msd/volume_guard.hpp"

namespace kt {
namespace {

class MsdModel final : public DeformableModel {
 public:
  MsdModel(Mesh mesh, const ModelOptions& options) : mesh_(std::move(mesh)), options_(options) {
    springs_ = make_springs(mesh_);
    make_mass();  // refuses nodes without an element, which the calibration would stumble over
    if (options.stiffness)
      for (Spring& s : springs_) s.stiffness = *options.stiffness;
    else
      calibration_ = calibrate_springs(mesh_, options.young, options.poisson, springs_);
    // After calibration: that is a statement about the body without them.
    const std::vector<double> factors = stiffness_factors(mesh_, options.inclusions);
    stiffen(mesh_, factors, springs_);
    stiffened_ = num_stiffened(factors);
    for (Spring& s : springs_) s.damper = options.damper.value_or(options.damping_stiffness * s.stiffness);
    guards_ = make_volume_guards(mesh_, springs_, options.least_volume);
    make_pattern();
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
    set_zero(out.dfdx, pattern_);
    set_zero(out.dfdv, pattern_);
    double* dfdx = out.dfdx.valuePtr();
    double* dfdv = out.dfdv.valuePtr();
    for (std::size_t i = 0; i < springs_.size(); ++i) {
      const Spring& s = springs_[i];
      const Stretch now = stretch(s, state);
      const Mat3 along = now.direction * now.direction.transpose();
      const Mat3 across = Mat3::Identity() - along;
      double tension = s.stiffness * (1 - s.rest_length / now.length);  // per length: the geometric stiffness
      if (kind == TangentKind::definite) tension = std::max(0.0, tension);
      Mat3 k = s.stiffness * along + tension * across;
      if (kind !=
          TangentKind::definite)  // the damper turns with the spring; not symmetric, left out of the definite one
        k += s.damper / now.length * (now.direction * (across * now.velocity).transpose() + now.rate * across);
      add_blocks(dfdx, i, k);
      add_blocks(dfdv, i, s.damper * along);
    }
    GuardForce push;
    for (const VolumeGuard& g : guards_)
      if (guard_force(g, state.x, kind == TangentKind::definite, push)) add_guard(dfdx, g.nodes, push.dfdx);
    for (Eigen::Index d = 0; d < mass_diagonal_.size(); ++d)
      dfdv[diagonal_[d]] -= options_.damping_mass * mass_diagonal_[d];
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
  struct Stretch {
    double length = 0, rate = 0;  ///< [m], [m/s]
    Vec3 direction, velocity;     ///< of b relative to a
  };

  static Stretch stretch(const Spring& s, const State& state) {
    Stretch out;
    const Vec3 d = node(state.x, s.b) - node(state.x, s.a);
    // A collapsed spring has no direction of its own: any fixed one keeps the force finite and the step reproducible.
    out.length = std::max(d.norm(), 1e-9 * s.rest_length);
    out.direction = d.squaredNorm() > 0 ? Vec3(d / d.norm()) : Vec3(Vec3::UnitX());
    out.velocity = node(state.v, s.b) - node(state.v, s.a);
    out.rate = out.velocity.dot(out.direction);
    return out;
  }

  void make_mass() {
    double length = 0;
    for (const Spring& s : springs_) length += s.rest_length;
    // A surface without inside is a membrane; a tenth of its mean edge stands for its thickness.
    const VectorX nodal = lumped_masses(mesh_, options_.density, 0.1 * length / static_cast<double>(springs_.size()));
    mass_diagonal_.resize(mesh_.x.size());
    for (int i = 0; i < mesh_.num_nodes(); ++i) {
      if (!(nodal[i] > 0)) throw InputError(text("msd: node ", i, " belongs to no element and would have no mass"));
      node(mass_diagonal_, i).setConstant(nodal[i]);
    }
    mass_ = SparseMatrix(mass_diagonal_.asDiagonal());
  }

  /// Where an entry of the pattern lies.
  int slot(int row, int column) const {
    const int* begin = pattern_.innerIndexPtr() + pattern_.outerIndexPtr()[column];
    const int* end = pattern_.innerIndexPtr() + pattern_.outerIndexPtr()[column + 1];
    return static_cast<int>(std::lower_bound(begin, end, row) - pattern_.innerIndexPtr());
  }

  /// The fixed sparsity pattern and, per spring, where its 36 entries lie in it.
  void make_pattern() {
    std::vector<Eigen::Triplet<double>> entries;
    const auto add_pair = [&](int a, int b) {
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) entries.emplace_back(3 * a + r, 3 * b + c, 0.0);
    };
    for (int i = 0; i < mesh_.num_nodes(); ++i) add_pair(i, i);
    for (const Spring& s : springs_) {
      add_pair(s.a, s.b);
      add_pair(s.b, s.a);
    }
    pattern_.resize(mesh_.x.size(), mesh_.x.size());
    pattern_.setFromTriplets(entries.begin(), entries.end());
    for (const Spring& s : springs_) {
      std::array<int, 12> first{};  // rows are consecutive inside a 3x3 block: the first of each column is enough
      for (int c = 0; c < 3; ++c) {
        first[c] = slot(3 * s.a, 3 * s.a + c);
        first[3 + c] = slot(3 * s.b, 3 * s.a + c);
        first[6 + c] = slot(3 * s.a, 3 * s.b + c);
        first[9 + c] = slot(3 * s.b, 3 * s.b + c);
      }
      slots_.push_back(first);
    }
    for (int d = 0; d < mesh_.x.size(); ++d) diagonal_.push_back(slot(d, d));
  }

  /// Adds -k on the diagonal blocks and +k off them: the derivative of the force on a spring's two ends.
  void add_blocks(double* values, std::size_t spring, const Mat3& k) const {
    const auto& first = slots_[spring];
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) {
        values[first[c] + r] -= k(r, c);
        values[first[3 + c] + r] += k(r, c);
        values[first[6 + c] + r] += k(r, c);
        values[first[9 + c] + r] -= k(r, c);
      }
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
  std::vector<Spring> springs_;
  std::vector<VolumeGuard> guards_;
  Calibration calibration_;
  int stiffened_ = 0;  // elements in inclusions
  VectorX mass_diagonal_;
  SparseMatrix mass_, pattern_;
  std::vector<std::array<int, 12>> slots_;
  std::vector<int> diagonal_;
};

}  // namespace

std::unique_ptr<DeformableModel> make_msd_model(Mesh mesh, const ModelOptions& options) {
  return std::make_unique<MsdModel>(std::move(mesh), options);
}

}  // namespace kt
