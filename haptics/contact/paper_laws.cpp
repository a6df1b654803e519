// The paper's three modes: sticking (P), sliding (Q) and frictional sliding, for one contact.       Paper section V.
// With the identity metric the velocity correction is the paper's projector; the mass and the implicit metric are
// the same operator in another inner product. docs/method.md#6-the-papers-laws-528
#include "haptics/contact/contact_solver.hpp"
#include "haptics/contact/projection.hpp"

namespace kt {
namespace {

constexpr int kFirst = 0;  // the paper knows one contact point

Mat3 metric(const ContactProblem& problem) { return problem.W.topLeftCorner<3, 3>(); }

void release(ContactSolution& out) {
  out.mode[kFirst] = ContactMode::free;
  out.impulse.setZero(3);
  out.inertial_impulse.setZero();
  out.force_on_tool.setZero();
}

/// The contact point's velocity becomes zero; the tool feels the whole constraint force.       Paper eqs. (12), (14).
void stick(const ContactProblem& problem, ContactSolution& out) {
  out.mode[kFirst] = ContactMode::stick;
  out.impulse = paper::P(metric(problem), problem.velocity.head<3>());
  out.inertial_impulse.setZero();
  out.force_on_tool = paper::P_tilde(problem.force);
}

/// The paper leaves the end of contact open; the surface cannot pull the tool
/// (docs/method.md#5-the-haptic-tick-section-iv-figure-2).
bool pulls(const ContactProblem& problem) { return problem.force.dot(problem.normal[kFirst]) <= 0; }

class PaperSlide final : public ContactSolver {
 public:
  Deformation deformation() const noexcept override { return Deformation::normal; }
  void solve(const ContactProblem& problem, ContactSolution& out) noexcept override {
    if (pulls(problem)) return release(out);
    const Vec3& n = problem.normal[kFirst];
    out.mode[kFirst] = ContactMode::slide;
    out.inertial_impulse.setZero();
    out.force_on_tool = paper::Q_tilde(problem.force, n);                    // eq. (22)
    out.impulse = paper::Q(metric(problem), n, problem.velocity.head<3>());  // eq. (20)
  }
};

class PaperStick final : public ContactSolver {
 public:
  Deformation deformation() const noexcept override { return Deformation::full; }
  void solve(const ContactProblem& problem, ContactSolution& out) noexcept override {
    if (pulls(problem)) return release(out);
    stick(problem, out);
  }
};

class PaperStickSlip final : public ContactSolver {
 public:
  explicit PaperStickSlip(SurfaceFriction friction) : friction_(std::move(friction)) {}
  Deformation deformation() const noexcept override { return Deformation::full; }
  void use(const SurfaceFriction* friction) noexcept override { used_ = friction ? friction : &friction_; }
  void solve(const ContactProblem& problem, ContactSolution& out) noexcept override {
    if (pulls(problem)) return release(out);
    const double mu = used_->at(problem.triangle[kFirst]).mu_static;
    const Vec3& n = problem.normal[kFirst];
    const Vec3 sticking = paper::P_tilde(problem.force);  // eqs. (23), (27)
    const auto [f_n, f_t] = split(sticking, n);
    if (f_t.norm() <= mu * f_n) return stick(problem, out);  // eq. (5)
    out.mode[kFirst] = ContactMode::frictional_slide;
    out.force_on_tool = clip_to_cone(sticking, n, mu);      // eq. (28)
    out.inertial_impulse = -problem.h * out.force_on_tool;  // eqs. (24)-(25)
    out.impulse =
        paper::Q(metric(problem), n, problem.velocity.head<3>() + problem.inertia * out.inertial_impulse);  // eq. (26)
  }

 private:
  SurfaceFriction friction_;
  const SurfaceFriction* used_ = &friction_;
};

}  // namespace

// The paper has one coefficient: the static one decides and clips.
std::unique_ptr<ContactSolver> make_paper_slide_solver(SurfaceFriction) { return std::make_unique<PaperSlide>(); }
std::unique_ptr<ContactSolver> make_paper_stick_solver(SurfaceFriction) { return std::make_unique<PaperStick>(); }
std::unique_ptr<ContactSolver> make_paper_stick_slip_solver(SurfaceFriction friction) {
  return std::make_unique<PaperStickSlip>(std::move(friction));
}

}  // namespace kt
