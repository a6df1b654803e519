// The framework the paper set out from (GiPSi 2.0): at each refresh the vertex nearest to the tool becomes the contact,
// is put onto the tool, and a few rings around it are linearized against an immovable wall. Between refreshes that one
// vertex follows the tool from wherever it is when the model arrives, so the way made during the link's latency is
// lost; the local state starts from zero with each model. No new contact between refreshes.
//
// Kinder than the original: the vertex is held by the engine's implicit step and Coulomb cone (GiPSi: explicit, always
// sticking), it is pushed along its normal only, the whole patch moves, and the state of the tick before is not dropped
// within an interval, as a slip in GiPSi's loop does.
#include "lab/methods/tick_parts.hpp"

namespace kt {
namespace {

constexpr double kTouching = 1e-4;  // [m] tool and surface this near at a refresh: in contact

class Legacy final : public Baseline {
 public:
  explicit Legacy(const HapticMethodOptions& options) : Baseline("legacy", options) {}

  void prepare_method_data(PreparedLocalModel& m, double) const override {
    const SurfacePatch& patch = m.model.patch;
    const VectorX x = m.model.x0.head(3 * patch.num_vertices());
    const Contact surface = nearest_point_contact(patch, x, m.tool);
    if (surface.gap - tool_.radius > kTouching) return;
    const Triangle& t = patch.triangles[surface.triangle];
    const auto distance_sq = [&](int corner) { return (node(x, t[corner]) - m.tool).squaredNorm(); };
    int nearest = 0;
    for (int c = 1; c < 3; ++c)
      if (distance_sq(c) < distance_sq(nearest)) nearest = c;
    Contact contact{surface.triangle, Vec3::Unit(nearest), vertex_normal(patch, x, t[nearest]), 0, 0};
    contact.gap = contact.normal.dot(m.tool - node(x, t[nearest])) - tool_.radius;
    if (contact.gap < 0) m.state.q += m.model.lift.middleCols(3 * t[nearest], 3) * Vec3(contact.gap * contact.normal);
    m.state.anchors.add(contact);
  }

  std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> next) noexcept override {
    std::swap(model_, next);
    arrived_ = true;
    return next;
  }

  LocalFrame step(const ToolSweep& sweep) noexcept override {
    PreparedLocalModel& m = *model_;
    LocalFrame frame = next_frame(sweep);
    if (arrived_) reference_ = sweep.x_t0;
    arrived_ = false;

    find_free_motion(m);
    m.work.impulse.setZero();
    if (m.state.anchors.count) hold_vertex(sweep, frame);
    step_body(m);
    if (!keep_finite(m, frame, samples_)) m.state.anchors.count = 0;
    sliding_ = frame.mode == ContactMode::frictional_slide;
    return frame;
  }

 private:
  void hold_vertex(const ToolSweep& sweep, LocalFrame& frame) noexcept {
    PreparedLocalModel& m = *model_;
    const LocalWorkspace& w = m.work;
    Contact& contact = m.state.anchors.contacts[0];
    const Triangle& t = m.model.patch.triangles[contact.triangle];
    const Vec3& n = contact.normal;
    const int vertex = contact.bary[0] > 0 ? t[0] : contact.bary[1] > 0 ? t[1] : t[2];
    const Vec3 end = node(w.x, vertex) + h_ * node(w.u_free, vertex);  // without contact
    const Vec3 tool = m.tool + (sweep.x_t1 - reference_);              // as if it had waited for the model
    const double gap_free = n.dot(tool - end) - tool_.radius;
    const Vec3 relative = node(w.u_free, vertex) - (sweep.x_t1 - sweep.x_t0) / h_;

    problem_.count = 1;
    problem_.h = h_;
    problem_.sliding.fill(sliding_);
    problem_.normal[0] = n;
    problem_.triangle[0] = m.model.patch.global_triangle[contact.triangle];
    problem_.velocity = relative - n.dot(relative) * n - gap_free / h_ * n;
    problem_.W = m.dynamics->metric().C.block<3, 3>(3 * vertex, 3 * vertex);
    const Mat3 moves = problem_.W;
    if (soften(m, problem_)) frame.flags |= kRigidContact;
    solution_.impulse.setZero(3);
    solver_->solve(problem_, solution_);

    const Vec3 impulse = solution_.impulse;
    add_impulse(m, contact.triangle, contact.bary, impulse);
    point_[0] = end + h_ * (moves * impulse);
    contact.gap = n.dot(tool - point_[0]) - tool_.radius;
    report_contacts(m.model.patch, m.state.anchors, solution_, point_, h_, frame, samples_);
  }

  Vec3 reference_ = Vec3::Zero();  // the tool when the model arrived
  bool arrived_ = false;
};

}  // namespace

std::unique_ptr<HapticMethod> make_legacy_method(const HapticMethodOptions& options) {
  return std::make_unique<Legacy>(options);
}

}  // namespace kt
