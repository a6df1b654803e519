#include "core/body/check_model.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "core/base/error.hpp"
#include "core/body/difference_tangent.hpp"
#include "core/linear/sparse_solver.hpp"

namespace kt {
namespace {

constexpr double kRounding = 1e-10;   // of a sum of many numbers
constexpr double kDefinite = 1e-8;    // of the largest diagonal entry: far above rounding, far below what is felt
constexpr double kSqueezed = 0.7;     // of its length in every direction: springs push, tangents are indefinite
constexpr double kDifference = 1e-5;  // of the random motion
constexpr int kDirections = 3;

SparseMatrix symmetric_part(const SparseMatrix& m) { return 0.5 * (m + SparseMatrix(m.transpose())); }
double asymmetry(const SparseMatrix& m) {
  const double size = m.norm();
  return size > 0 ? (m - SparseMatrix(m.transpose())).norm() / size : 0;
}

/// Whether the symmetric matrix is positive definite once `share` of its largest diagonal entry is added there.
bool is_definite(const SparseMatrix& matrix, double share) {
  SparseMatrix shifted(matrix.rows(), matrix.cols());
  shifted.setIdentity();
  shifted = matrix + share * std::max(VectorX(matrix.diagonal()).cwiseAbs().maxCoeff(), 1e-300) * shifted;
  return make_sparse_solver()->factor(shifted);
}

bool all_finite(const SparseMatrix& m) { return Eigen::Map<const VectorX>(m.valuePtr(), m.nonZeros()).allFinite(); }

class Checker {
 public:
  Checker(const DeformableModel& model, const ModelCheckOptions& options)
      : model_(model), options_(options), n_(model.mesh().x.size()), bits_(options.seed) {}

  ModelCheck run() {
    if (check_sizes()) {
      edges_ = shortest_edges(model_.mesh()).replicate<1, 3>().transpose().reshaped();
      rest_ = rest_state(model_);
      shaken_ = rest_;
      shaken_.x += options_.strain * random_motion();
      shaken_.v = options_.speed * random_motion();
      State squeezed = shaken_;
      const Vec3 centre = bounds(model_.mesh()).centre();
      squeezed.x = kSqueezed * squeezed.x + (1 - kSqueezed) * centre.replicate(n_ / 3, 1);
      if (check_tangent("at rest", rest_) && check_tangent("deformed and moving", shaken_) &&
          check_tangent("squeezed", squeezed)) {
        check_same_twice();
        check_balance();
        check_work();
        check_turning();
        check_free_share();
      }
    }
    return out_;
  }

 private:
  /// Adds a finding; true when it is kept.
  bool expect(const std::string& name, double value, double allowed, const std::string& meaning,
              ModelVerdict otherwise = ModelVerdict::broken) {
    const bool kept = value <= allowed;  // false for what is no number, too
    out_.findings.push_back({name, kept ? ModelVerdict::kept : otherwise, value, allowed, meaning});
    return kept;
  }
  /// The same of something that is so or not.
  bool expect(const std::string& name, bool holds, const std::string& meaning) {
    return expect(name, holds ? 0 : 1, 0, meaning);
  }

  VectorX random_motion() {
    VectorX out(n_);
    for (double& value : out) value = std::ldexp(static_cast<double>(bits_() >> 11), -52) - 1;
    return out.cwiseProduct(edges_);
  }

  VectorX force(const State& s) const {
    VectorX out;
    model_.force(s, out);
    return out;
  }

  bool check_sizes() {
    const auto& fixed = model_.fixed_nodes();
    const SparseMatrix& mass = model_.mass();
    VectorX f;
    const bool body = expect("nodes", n_ > 0 && n_ % 3 == 0, "the mesh has no nodes, or not three numbers for each") &&
                      expect("positions at rest", model_.mesh().x.allFinite(), "not every number is finite");
    if (!body) return false;
    bool right = expect("fixed nodes", std::ranges::adjacent_find(fixed, std::ranges::greater_equal{}) == fixed.end(),
                        "they have to ascend, each once") &&
                 expect("fixed nodes in the mesh", fixed.empty() || (fixed.front() >= 0 && 3 * fixed.back() < n_),
                        "some are not nodes of the mesh");
    right = expect("size of the mass", mass.rows() == n_ && mass.cols() == n_, "it has to be (3n x 3n)") && right;
    model_.force(rest_state(model_), f);
    right = expect("size of the force", f.size() == n_, "it has to be (3n)") && right;
    if (!right) return false;
    right = expect("force at rest", f.allFinite(), "not every number is finite");
    return expect("mass", all_finite(mass) && asymmetry(mass) <= kRounding && is_definite(mass, 0),
                  "it has to be finite, symmetric and positive definite") &&
           right;
  }

  /// False: of the wrong size, or not finite.
  bool check_tangent(const std::string& where, const State& state) {
    Tangent exact, symmetric, definite;
    model_.update_tangent(state, TangentKind::exact, exact);
    model_.update_tangent(state, TangentKind::symmetric, symmetric);
    model_.update_tangent(state, TangentKind::definite, definite);
    for (const Tangent* t : {&exact, &symmetric, &definite})
      for (const SparseMatrix* m : {&t->dfdx, &t->dfdv})
        if (m->rows() != n_ || m->cols() != n_ || !all_finite(*m))
          return expect("tangent " + where, false, "it has to be (3n x 3n), twice, and finite");
    if (!expect("force " + where, force(state).allFinite(), "not every number is finite")) return false;
    check_derivative("dfdx " + where, exact.dfdx, state, &State::x);
    check_derivative("dfdv " + where, exact.dfdv, state, &State::v);
    double apart = 0;
    for (const auto& [a, b] : {std::pair(&exact.dfdx, &symmetric.dfdx), std::pair(&exact.dfdv, &symmetric.dfdv)})
      apart = std::max(apart, (symmetric_part(*a) - symmetric_part(*b)).norm() / std::max(a->norm(), 1e-300));
    expect("symmetric tangent " + where, apart, options_.accuracy, "it is not the symmetric part of the exact one");
    expect("definite tangent " + where,
           std::max(asymmetry(definite.dfdx), asymmetry(definite.dfdv)) <= kRounding &&
               is_definite(-definite.dfdx, kDefinite) && is_definite(-definite.dfdv, kDefinite),
           "-dfdx and -dfdv have to be symmetric and positive semidefinite; implicit steps fail where they are not");
    return true;
  }

  void check_derivative(const std::string& name, const SparseMatrix& derivative, const State& state,
                        VectorX State::*field) {
    double worst = 0;
    for (int i = 0; i < kDirections; ++i) {
      const VectorX motion = random_motion();
      const double h = field == &State::x ? kDifference : 100 * kDifference;
      State ahead = state, behind = state;
      ahead.*field += h * motion;
      behind.*field -= h * motion;
      const VectorX a = force(ahead), b = force(behind), found = derivative * motion, truth = (a - b) / (2 * h);
      const double rounding = 1e3 * std::numeric_limits<double>::epsilon() * (a.norm() + b.norm()) / h;
      const double off = (found - truth).norm();
      if (off > rounding) worst = std::max(worst, off / std::max(found.norm(), truth.norm()));
    }
    expect(
        name, worst, options_.accuracy,
        "not the derivative of force(): a sign, a term that is left out, or nodes that act on one another from afar");
  }

  void check_same_twice() {
    expect("equal bits", force(shaken_) == force(shaken_), "the same state twice gives two forces: runs do not replay");
  }

  void check_balance() {
    const ModelVerdict otherwise = options_.anchored ? ModelVerdict::told : ModelVerdict::broken;
    State a = rest_, b = shaken_;
    b.v.setZero();
    const VectorX change = force(b) - force(a);
    const Vec3 sum = change.reshaped(3, n_ / 3).rowwise().sum();
    expect("momentum", sum.norm() / std::max(change.lpNorm<1>(), 1e-300), options_.accuracy,
           "forces inside the body do not add up to nothing: it pushes itself off", otherwise);
    State moved = shaken_;
    moved.x += bounds(model_.mesh()).size().norm() * Vec3(0.3, -0.2, 0.5).replicate(n_ / 3, 1);
    expect("forces elsewhere", (force(moved) - force(shaken_)).norm() / std::max(change.norm(), 1e-300),
           options_.accuracy, "forces depend on where the body is", otherwise);
  }

  void check_work() {
    State still = shaken_;
    still.v.setZero();
    expect("springs give back", asymmetry(model_.tangent(still, TangentKind::exact).dfdx), options_.accuracy,
           "dfdx is not symmetric where nothing moves: a round trip gains or loses energy");
    const VectorX damping = force(shaken_) - force(still);
    const double size = shaken_.v.norm() * damping.norm();
    expect("dampers take", size > 0 ? shaken_.v.dot(damping) / size : 0, kRounding,
           "dampers push along the motion: it gains energy");
  }

  /// Weight is taken off first, as the share of the mass in the force at rest.
  void check_turning() {
    State still = shaken_;
    still.v.setZero();
    const VectorX at_rest = force(rest_);
    VectorX all_at_once = Vec3(1, 1, 1).replicate(n_ / 3, 1);
    const VectorX masses = model_.mass() * all_at_once;
    const Vec3 sum = at_rest.reshaped(3, n_ / 3).rowwise().sum(), mass = masses.reshaped(3, n_ / 3).rowwise().sum();
    const VectorX weight = masses.cwiseProduct(sum.cwiseQuotient(mass).replicate(n_ / 3, 1));
    const Mat3 turn = Eigen::AngleAxisd(0.8, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    const auto turned = [&](const VectorX& v) { return VectorX((turn * v.reshaped(3, n_ / 3)).reshaped()); };
    const VectorX expected = turned(force(still) - weight);
    still.x = turned(still.x);
    expect("forces of a turned body", (force(still) - weight - expected).norm() / std::max(expected.norm(), 1e-300),
           options_.accuracy, "forces do not turn with the body: right for small turns only, as of a linear material",
           ModelVerdict::told);
  }

  void check_free_share() {
    const double share = model_.free_share(rest_.x, shaken_.x - rest_.x);
    expect("free share", share >= 0 && share <= 1, "it has to be in [0, 1]");
  }

  const DeformableModel& model_;
  ModelCheckOptions options_;
  Eigen::Index n_;
  std::mt19937_64 bits_;
  VectorX edges_;  // (3n)
  State rest_, shaken_;
  ModelCheck out_;
};

}  // namespace

bool ModelCheck::passed() const {
  return std::ranges::none_of(findings, [](const ModelFinding& f) { return f.verdict == ModelVerdict::broken; });
}

std::string ModelCheck::text() const {
  std::string out;
  for (const ModelFinding& f : findings) {
    const char* verdict = f.verdict == ModelVerdict::kept   ? "ok   "
                          : f.verdict == ModelVerdict::told ? "note "
                                                            : "WRONG";
    out += kt::text(verdict, " ", f.name, ": ", f.value, " (at most ", f.allowed, ")");
    if (f.verdict != ModelVerdict::kept) out += ": " + f.meaning;
    out += '\n';
  }
  return out;
}

ModelCheck check_model(const DeformableModel& model, const ModelCheckOptions& options) {
  return Checker(model, options).run();
}

}  // namespace kt
