// What most toolkits do: the tool is tied by a spring and a damper to a proxy that stays on the surface (virtual
// coupling; Zilles and Salisbury 1995, Colgate 1995), with friction between proxy and surface. Contact is looked for
// once per tick, after the fact; the force of one tick acts on the body in the next.
//
// The proxy is massless, so it is where the coupling and the surface's contact forces balance: Coulomb's law on the
// coupling's compliance, the surface standing still meanwhile.
#include "lab/methods/tick_parts.hpp"

namespace kt {
namespace {

class Penalty final : public Baseline {
 public:
  explicit Penalty(const HapticMethodOptions& options) : Baseline("penalty", options), coupling_(options.coupling) {
    if (!(coupling_.stiffness > 0 && coupling_.damping >= 0))
      throw InputError(text("contact.penalty: stiffness = ", coupling_.stiffness,
                            " N/m must be above 0, damping = ", coupling_.damping, " N.s/m at least 0"));
  }

  std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> next) noexcept override {
    std::swap(model_, next);
    model_->work.impulse.setZero();
    if (!next) {
      motion_ = make_local_motion(static_cast<int>(model_->recovered_row.size()));
      return next;
    }
    record_motion(*next, 0, motion_);
    carry_motion(motion_, *model_);
    for (int i = 0; i < contacts_.count; ++i) {
      int& triangle = contacts_.contacts[i].triangle;
      triangle = model_->local_triangle[next->model.patch.global_triangle[triangle]];
      if (triangle < 0)
        solution_.impulse.segment<3>(3 * i).setZero();
      else
        add_impulse(*model_, triangle, contacts_.contacts[i].bary, solution_.impulse.segment<3>(3 * i));
    }
    return next;
  }

  LocalFrame step(const ToolSweep& sweep) noexcept override {
    PreparedLocalModel& m = *model_;
    LocalFrame frame = next_frame(sweep);

    // The body moves under the force of the tick before; where it is then, the proxy meets it.
    find_free_motion(m);
    step_body(m);
    find_contacts(sweep.x_t1 + stretch_);
    fill_problem(sweep);
    solver_->solve(problem_, solution_);
    Vec3 force = Vec3::Zero();
    m.work.impulse.setZero();
    for (int i = 0; i < contacts_.count; ++i) {
      const Contact& contact = contacts_.contacts[i];
      const Vec3 impulse = solution_.impulse.segment<3>(3 * i);
      force -= impulse / h_;
      add_impulse(m, contact.triangle, contact.bary, impulse);
      point_[i] = at_point(m.work.x_end, m.model.patch.triangles[contact.triangle], contact.bary);
    }
    stretch_ = relaxed() * stretch_ + force / resistance();
    report_contacts(m.model.patch, contacts_, solution_, point_, h_, frame, samples_);
    if (!keep_finite(m, frame, samples_) || !stretch_.allFinite()) {
      contacts_.count = 0;
      m.work.impulse.setZero();
      stretch_.setZero();
    }
    sliding_ = frame.mode == ContactMode::frictional_slide;
    return frame;
  }

 private:
  /// Force of the coupling per stretch gained in one tick [N/m], and how much of the old stretch its damper keeps.
  double resistance() const noexcept { return coupling_.stiffness / (1 - kOwnShare) + coupling_.damping / h_; }
  double relaxed() const noexcept { return coupling_.damping / h_ / resistance(); }

  /// Around the place to which the tool would have carried the proxy.
  void find_contacts(const Vec3& proxy) noexcept {
    PreparedLocalModel& m = *model_;
    const VectorX& x = m.work.x_end;
    before_ = contacts_;
    impulse_before_ = solution_.impulse;
    int start = -1;
    for (const Contact& contact : before_) start = std::max(start, contact.triangle);
    contacts_.count = 0;
    if (!proxy.allFinite()) return;
    if (tool_.kind == ToolShape::Kind::point) {
      const Contact contact = start < 0 ? nearest_point_contact(m.model.patch, x, proxy)
                                        : track_point_contact(m.model.patch, x, proxy, start);
      if (contact.gap < kMargin) contacts_.add(contact);
      return;
    }
    m.index->refit(x, x);
    const int found = m.index->candidates({proxy, proxy}, tool_.radius + kMargin, m.work.candidates);
    find_sphere_contacts(m.model.patch, x, proxy, tool_.radius, kMargin,
                         {m.work.candidates.data(), static_cast<std::size_t>(found)}, start, contacts_);
  }

  /// Between surface and proxy, in displacements over one tick: "impulse" / h is the force, "velocity" h the way.
  void fill_problem(const ToolSweep& sweep) noexcept {
    const LocalWorkspace& w = model_->work;
    const int c = contacts_.count;
    const Vec3 back = relaxed() * stretch_ - stretch_;  // what the proxy does on its own, against the tool
    const Vec3 way = sweep.x_t1 - sweep.x_t0 + back;
    problem_.count = c;
    problem_.h = h_;
    problem_.sliding.fill(sliding_);
    problem_.velocity.resize(3 * c);
    problem_.W.resize(3 * c, 3 * c);
    solution_.impulse.setZero(3 * c);
    for (int i = 0; i < c; ++i) {
      const Contact& contact = contacts_.contacts[i];
      const Triangle& t = model_->model.patch.triangles[contact.triangle];
      const Vec3& n = contact.normal;
      const Vec3 relative = at_point(w.x_end, t, contact.bary) - at_point(w.x, t, contact.bary) - way;
      problem_.normal[i] = n;
      problem_.triangle[i] = model_->model.patch.global_triangle[contact.triangle];
      problem_.velocity.segment<3>(3 * i) = (relative - n.dot(relative) * n - (contact.gap + n.dot(back)) * n) / h_;
      for (int k = 0; k < c; ++k)  // one proxy: all its contacts stretch the same coupling
        problem_.W.block<3, 3>(3 * i, 3 * k) = Mat3::Identity() / (resistance() * h_ * h_);
      problem_.W.block<3, 3>(3 * i, 3 * i) += kOwnShare / (coupling_.stiffness * h_ * h_) * n * n.transpose();
      for (int k = 0; k < before_.count; ++k)
        if (before_.contacts[k].triangle == contact.triangle)
          solution_.impulse.segment<3>(3 * i) = impulse_before_.segment<3>(3 * k);
    }
  }

  // Part of the compliance along the normal that each contact has for itself: else the one that is solved first carries
  // the load alone, and neighbours take it from each other tick by tick. One contact alone feels the stiffness as
  // given.
  static constexpr double kOwnShare = 0.25;
  static constexpr double kMargin = 1e-3;  // [m] more than proxy and surface move towards each other in a tick

  ProxyCoupling coupling_;
  LocalMotion motion_;           // room, for the refresh
  Vec3 stretch_ = Vec3::Zero();  // from the tool to the proxy [m]
  ContactSet contacts_, before_;
  ContactVector impulse_before_;
};

}  // namespace

std::unique_ptr<HapticMethod> make_penalty_method(const HapticMethodOptions& options) {
  return std::make_unique<Penalty>(options);
}

}  // namespace kt
