// What SOFA's LCPForceFeedback does: contacts, their normals and the body's compliance there (the Delassus operator)
// are computed once per global step. Each tick moves the gaps on with the tool, to first order, and solves Coulomb's
// law on the frozen operator: quasi-static, no dynamics at the haptic rate, no contact that the last global step did
// not know.
//
// Kinder than the original: the compliance is the static one (SOFA: of a step of the global rate), friction remembers
// where it slipped to (SOFA: counts from the pose at the refresh), and the force is not scaled.
#include <Eigen/SparseCholesky>

#include "lab/methods/tick_parts.hpp"

namespace kt {
namespace {

constexpr double kAlarmDistance = 0.004;  // [m] the tool's way in one global step of a quick motion

/// One global step's contacts (c) and how the body gives way there.
struct FrozenContacts final : MethodData {
  ContactSet contacts;
  ContactMatrix compliance;  ///< displacement of the contact points per force [m/N], (3c x 3c)
  ContactVector u_free;      ///< their displacement at rest without contact [m], (3c)
  VectorX q_free;            ///< the body's, (r)
  MatrixX Y;                 ///< the body's per contact force, (r x 3c)
};

/// Solver of (K + the mass term of one interval where K alone does not hold the body).
class Statics {
 public:
  Statics(const LocalModel& model, double interval) {
    solver_.compute(model.stiffness);
    if (holds()) return;
    solver_.compute(SparseMatrix(model.stiffness + model.mass / (interval * interval)));
    if (!holds()) throw RunError("local.method frozen: the local model's stiffness is not positive definite");
  }
  MatrixX solve(const MatrixX& rhs) const { return solver_.solve(rhs); }

 private:
  bool holds() const {
    constexpr double kSingular = 1e-10;  // a body that floats: pivots of rounding size
    if (solver_.info() != Eigen::Success) return false;
    const VectorX pivots = solver_.vectorD();
    return pivots.size() == 0 || pivots.minCoeff() > kSingular * pivots.maxCoeff();
  }
  Eigen::SimplicialLDLT<SparseMatrix> solver_;
};

class Frozen final : public Baseline {
 public:
  explicit Frozen(const HapticMethodOptions& options) : Baseline("frozen", options) { u_.setZero(0); }

  void prepare_method_data(PreparedLocalModel& m, double interval) const override {
    auto out = std::make_unique<FrozenContacts>();
    find_contacts(m, out->contacts);
    const Statics statics(m.model, interval);
    const int p3 = 3 * m.model.patch.num_vertices(), c3 = 3 * out->contacts.count;
    MatrixX J = MatrixX::Zero(c3, p3);
    for (int i = 0; i < out->contacts.count; ++i) {
      const Contact& contact = out->contacts.contacts[i];
      const Triangle& t = m.model.patch.triangles[contact.triangle];
      for (int c = 0; c < 3; ++c) J.block<3, 3>(3 * i, 3 * t[c]) += contact.bary[c] * Mat3::Identity();
    }
    const MatrixX rows = J * m.patch_basis;
    out->q_free = statics.solve(m.model.f0);
    out->u_free = rows * out->q_free;
    out->Y = statics.solve(rows.transpose());
    const MatrixX compliance = rows * out->Y;
    out->compliance = 0.5 * (compliance + compliance.transpose());
    m.data = std::move(out);
  }

  std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> next) noexcept override {
    std::swap(model_, next);
    const FrozenContacts* frozen = data();
    u_.setZero(frozen ? 3 * frozen->contacts.count : 0);  // where the body was linearized,
    solution_.impulse.setZero(u_.size());
    before_ = model_->tool;  // with the tool there
    return next;
  }

  LocalFrame step(const ToolSweep& sweep) noexcept override {
    PreparedLocalModel& m = *model_;
    LocalFrame frame = next_frame(sweep);
    if (const FrozenContacts* frozen = data()) {
      fill_problem(*frozen, sweep.x_t1);
      if (soften(m, problem_)) frame.flags |= kRigidContact;
      solver_->solve(problem_, solution_);
      move_body(*frozen, sweep.x_t1);
      report_contacts(m.model.patch, contacts_, solution_, point_, h_, frame, samples_);
    }
    if (keep_finite(m, frame, samples_)) {
      before_ = sweep.x_t1;
    } else {
      u_.setZero();
      solution_.impulse.setZero();
    }
    sliding_ = frame.mode == ContactMode::frictional_slide;
    return frame;
  }

 private:
  const FrozenContacts* data() const noexcept { return static_cast<const FrozenContacts*>(model_->data.get()); }

  void find_contacts(PreparedLocalModel& m, ContactSet& out) const {
    const SurfacePatch& patch = m.model.patch;
    const VectorX x = m.model.x0.head(3 * patch.num_vertices());
    if (tool_.kind == ToolShape::Kind::point) {
      const Contact contact = nearest_point_contact(patch, x, m.tool);
      if (contact.gap < kAlarmDistance) out.add(contact);
      return;
    }
    const int found = m.index->candidates({m.tool, m.tool}, tool_.radius + kAlarmDistance, m.work.candidates);
    find_sphere_contacts(patch, x, m.tool, tool_.radius, kAlarmDistance,
                         {m.work.candidates.data(), static_cast<std::size_t>(found)}, -1, out);
  }

  /// In displacements over one tick: "impulse" / h is the force, "velocity" h the way.
  void fill_problem(const FrozenContacts& frozen, const Vec3& tool) noexcept {
    problem_.count = frozen.contacts.count;
    problem_.h = h_;
    problem_.sliding.fill(sliding_);
    problem_.velocity.resize(3 * problem_.count);
    problem_.W = frozen.compliance / (h_ * h_);
    contacts_ = frozen.contacts;
    for (int i = 0; i < problem_.count; ++i) {
      const Contact& contact = frozen.contacts.contacts[i];
      const Vec3& n = contact.normal;
      const Vec3 free = frozen.u_free.segment<3>(3 * i);
      const double gap_free = contact.gap + n.dot(tool - model_->tool) - n.dot(free);
      const Vec3 way = free - u_.segment<3>(3 * i) - (tool - before_);
      problem_.normal[i] = n;
      problem_.triangle[i] = model_->model.patch.global_triangle[contact.triangle];
      problem_.velocity.segment<3>(3 * i) = (way - n.dot(way) * n - gap_free * n) / h_;
    }
  }

  /// The body at rest under the contact forces: for the reports, and the state that others see.
  void move_body(const FrozenContacts& frozen, const Vec3& tool) noexcept {
    PreparedLocalModel& m = *model_;
    u_ = frozen.u_free;
    u_.noalias() += frozen.compliance * solution_.impulse / h_;
    m.state.q = frozen.q_free;
    m.state.q_rate.setZero();
    for (int i = 0; i < contacts_.count; ++i) {
      const Vec3 force = solution_.impulse.segment<3>(3 * i) / h_;
      if (!force.isZero(0)) m.state.q.noalias() += frozen.Y.middleCols<3>(3 * i) * force;
      Contact& contact = contacts_.contacts[i];
      point_[i] = at_point(m.model.x0, m.model.patch.triangles[contact.triangle], contact.bary) + u_.segment<3>(3 * i);
      contact.gap += contact.normal.dot(tool - m.tool - u_.segment<3>(3 * i));
    }
  }

  Vec3 before_ = Vec3::Zero();  // the tool after the last tick
  ContactVector u_;             // displacement of the contact points then [m]
  ContactSet contacts_;
};

}  // namespace

std::unique_ptr<HapticMethod> make_frozen_method(const HapticMethodOptions& options) {
  return std::make_unique<Frozen>(options);
}

}  // namespace kt
