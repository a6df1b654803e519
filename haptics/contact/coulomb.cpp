// Exact Coulomb friction at every contact: one contact is solved exactly, several by block Gauss-Seidel over them
// (Jourdan, Alart and Jean 1998). method.md section 5, notes 4 and 5.
#include "haptics/contact/one_contact.hpp"

namespace kt {
namespace {

constexpr int kMaxSweeps = 60;
constexpr double kConverged = 1e-3;  // of the largest impulse: well below what a hand or a device resolves

class Coulomb final : public ContactSolver {
 public:
  explicit Coulomb(const Friction& friction) : friction_(friction) {}
  Deformation deformation() const noexcept override { return Deformation::none; }

  void solve(const ContactProblem& problem, ContactSolution& out) const noexcept override {
    const int c = problem.count;
    if (out.impulse.size() != 3 * c) out.impulse.setZero(3 * c);
    out.inertial_impulse.setZero();
    const int sweeps = c == 1 ? 1 : kMaxSweeps;
    const Friction friction{problem.sliding ? friction_.mu_kinetic : friction_.mu_static, friction_.mu_kinetic};
    std::array<OneContact, kMaxContacts> contact;
    for (int i = 0; i < c; ++i) contact[i] = {problem.W.block<3, 3>(3 * i, 3 * i), problem.normal[i]};
    ContactVector velocity = problem.velocity;  // with the present impulses
    for (int i = 0; i < c; ++i) velocity += problem.W.middleCols<3>(3 * i) * out.impulse.segment<3>(3 * i);
    for (out.iterations = 0; out.iterations < sweeps;) {
      ++out.iterations;
      double change = 0, largest = 0;
      for (int i = 0; i < c; ++i) {
        const Vec3 before = out.impulse.segment<3>(3 * i);
        const Vec3 free = velocity.segment<3>(3 * i) - problem.W.block<3, 3>(3 * i, 3 * i) * before;
        const OneContactSolution one = contact[i].solve(free, friction, before);
        const Vec3 step = one.impulse - before;
        out.impulse.segment<3>(3 * i) = one.impulse;
        out.mode[i] = one.mode;
        out.grip[i] = friction.mu_static;
        if (!step.isZero(0)) velocity += problem.W.middleCols<3>(3 * i) * step;
        change = std::max(change, step.lpNorm<Eigen::Infinity>());
        largest = std::max(largest, one.impulse.lpNorm<Eigen::Infinity>());
      }
      out.residual = c == 1 || largest == 0 ? 0.0 : change / largest;
      if (out.residual <= kConverged) break;
    }
    Vec3 total = Vec3::Zero();
    for (int i = 0; i < c; ++i) total += out.impulse.segment<3>(3 * i);
    out.force_on_tool = -total / problem.h;
  }

 private:
  Friction friction_;
};

}  // namespace

std::unique_ptr<ContactSolver> make_coulomb_solver(const Friction& friction) {
  return std::make_unique<Coulomb>(friction);
}

}  // namespace kt
