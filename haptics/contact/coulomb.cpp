// Exact Coulomb friction at every contact of the tick. docs/friction.md.
#include "haptics/contact/contact_solver.hpp"
#include "haptics/contact/contact_sweeps.hpp"

namespace kt {
namespace {

class Coulomb final : public ContactSolver {
 public:
  explicit Coulomb(SurfaceFriction friction) : friction_(std::move(friction)), sweeps_(kMaxContacts) {}
  Deformation deformation() const noexcept override { return Deformation::none; }

  void use(const SurfaceFriction* friction) noexcept override { used_ = friction ? friction : &friction_; }
  void solve(const ContactProblem& problem, ContactSolution& out) noexcept override {
    const int c = problem.count;
    const auto count = static_cast<std::size_t>(c);
    if (out.impulse.size() != 3 * c) out.impulse.setZero(3 * c);
    out.inertial_impulse.setZero();
    for (int i = 0; i < c; ++i) {
      own_[i] = used_->at(problem.triangle[i]).times(1 - problem.lost_grip[i]);
      out.grip[i] = problem.sliding[i] ? own_[i].mu_kinetic : own_[i].mu_static;
    }
    const ContactSystem system{{problem.normal.data(), count},
                               {own_.data(), count},
                               {problem.sliding.data(), count},
                               problem.velocity,
                               problem.W};
    const SweepResult result = sweeps_.solve(system, limits_of(problem), out.impulse, {out.mode.data(), count});
    out.iterations = result.sweeps;
    out.residual = result.residual;
    Vec3 total = Vec3::Zero();
    for (int i = 0; i < c; ++i) total += out.impulse.segment<3>(3 * i);
    out.force_on_tool = -total / problem.h;
  }

 private:
  /// Of many contacts a tick has no time for more than a few direct solutions.
  static SweepLimits limits_of(const ContactProblem& problem) {
    constexpr int kMany = 12;
    constexpr double kRough = 1e-4;  // a fifth of the sweeps less, and no more rounds
    SweepLimits out{.pivots = 3 * problem.count, .work = problem.work};
    if (problem.is_first) out.residual = kRough;
    if (!problem.is_bounded || problem.count <= kMany) return out;
    out.sweeps = 60;
    out.direct_rounds = problem.is_repeated ? 0 : 1;
    out.pivots = 16;
    return out;
  }

  SurfaceFriction friction_;
  const SurfaceFriction* used_ = &friction_;
  std::array<Friction, kMaxContacts> own_{};
  ContactSweeps sweeps_;
};

}  // namespace

std::unique_ptr<ContactSolver> make_coulomb_solver(SurfaceFriction friction) {
  return std::make_unique<Coulomb>(std::move(friction));
}

}  // namespace kt
