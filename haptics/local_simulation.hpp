#pragma once
// The 1 kHz side: free motion, first time of impact, rollback, stick or slip, force.          Paper section IV, fig. 2.
#include <span>
#include <vector>

#include "collision/moving_tool.hpp"
#include "core/global_simulation.hpp"
#include "haptics/force_blend.hpp"
#include "haptics/haptic_method.hpp"
#include "haptics/local_motion.hpp"
#include "haptics/push_force.hpp"

namespace kt {

/// Things that a tick reports besides its force.
enum LocalFlag : unsigned {
  kEventsExhausted = 1,     ///< more impacts in one tick than kMaxEvents
  kLeftPatch = 2,           ///< the contact lies on the edge of the patch: the model is wrong there, a refresh is due
  kLostAnchor = 4,          ///< a refresh brought a patch that does not hold the contact
  kRigidContact = 8,        ///< contact with a part that cannot move: see softest_contact()
  kNotFinite = 16,          ///< the local state left the finite numbers; it was reset and the force is zero
  kContactsExhausted = 32,  ///< kMaxContacts places touch at once, and more may
  kPushedOut = 64,          ///< the tool was inside, and the body is being pushed off it
  kStaleModel = 128,        ///< the body has not followed for long: the local model in use is old
  kBodyFailed = 256,        ///< the body's simulation has ended with an error: the last local model goes on
  kNoModel = 512,           ///< nothing is touched: there is no local model yet
  kBadPose = 1024,          ///< the tool's pose was not finite, or far beyond any body: it stayed where it was
  kLateTick = 2048,         ///< more time had passed than is caught up with in one call
};

constexpr int kMaxEvents = 8;  ///< impacts resolved within one tick

/// One tick's result. Plain values: it is recorded, sent and compared as it is.
struct LocalFrame {
  double t = 0;                ///< end of the tick [s]
  Pose pose;                   ///< of the tool at t
  Vec3 force = Vec3::Zero();   ///< on the tool [N]
  double f_n = 0, f_t = 0;     ///< its normal and tangential parts [N]
  Vec3 normal = Vec3::Zero();  ///< of the contact that carries most: unit, from the body towards the tool
  Vec3 point = Vec3::Zero();   ///< where that one touches the tool [m]
  Vec3 torque = Vec3::Zero();  ///< on the tool about its reference point, of the contacts' own forces [N m]
  double cone_ratio = 0;       ///< largest |f_t| / f_n over the contacts
  ContactMode mode = ContactMode::free;
  int triangle = -1;    ///< of the body's surface: the contact that carries most
  int facet = -1;       ///< of the contact surface, see ContactSurface::global_facet()
  double toi = 0;       ///< of the first impact in this tick, 0 when already in contact
  double gap = 0;       ///< smallest gap of a held contact after the tick [m]
  double residual = 0;  ///< largest that the contact solver left in this tick, all tools: ContactSolution::residual
  int model_frame = -1;
  int contacts = 0, events = 0;
  unsigned flags = 0;
};

/// A tool, what a tick has found about it, and what goes on from tick to tick.
struct TouchingTool {
  TouchingTool(const ToolShape& shape, double h, double fade)
      : moving(shape), reach(tool_reach(shape)), blend(h, fade) {}
  MovingTool moving;
  double reach;  ///< tool_reach() [m]
  ForceBlend blend;
  PushForce push;
  ToolSweep rest{};           ///< of this tick's sweep, after the last event
  int start = -1;             ///< facet that it touches in this tick, -1: none yet
  unsigned flags = 0;         ///< LocalFlag
  bool was_on_rim = false;    ///< the last tick's contact was at the edge of the patch
  bool is_off_patch = false;  ///< contact ended there: the tool may have got into the body unseen
};

/// One tool, or two that touch the same body at the same time: one local model, one W over all contacts, so that each
/// hand feels what the other does in the same tick.
class LocalSimulation final : public HapticMethod {
 public:
  /// @param blend  over which the difference between two local models fades from the force [s]; 0: not at all
  LocalSimulation(const ToolShape& tool, double h, std::unique_ptr<ContactSolver> solver, double blend = 0);
  /// @param tools  1 to kMaxTools; the paper's laws know one
  LocalSimulation(std::span<const ToolShape> tools, double h, std::unique_ptr<ContactSolver> solver, double blend = 0);

  /// Goes over to a new local model: patch motion and contacts are carried over by node and triangle, unless the new
  /// model is caught up already. No allocation; gives the old model back, to be freed elsewhere.
  std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> next) noexcept override;

  /// Puts the model in and takes the present one out, as they are.
  void swap_model(std::unique_ptr<PreparedLocalModel>& model) noexcept {
    model_.swap(model);
    if (model_) take_settings();
  }

  /// The body's force at the present state is `force` [N], (r), whatever the linear model has for it: the model's
  /// constant part follows. For bodies whose nonlinear force is at hand at every tick.
  void set_force(const VectorX& force) noexcept;

  /// One haptic tick with the tool moving along `sweep`. Needs an adopted model. No allocation, lock or clock.
  LocalFrame step(const ToolSweep& sweep) noexcept override;

  /// The same with each tool moving along its own sweep; a frame for each.
  void step_tools(std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) noexcept override;

  /// What the last tick did to the body, for the global side.
  std::span<const ContactSample> samples() const noexcept override {
    return {samples_.data(), static_cast<std::size_t>(num_samples_)};
  }

  const PreparedLocalModel& model() const noexcept override { return *model_; }
  bool has_model() const { return model_ != nullptr; }
  double h() const noexcept override { return h_; }
  const ToolShape& tool() const noexcept override { return tools_[0].moving.shape(); }
  int num_tools() const noexcept { return static_cast<int>(tools_.size()); }

 private:
  void take_settings() noexcept;
  void find_free_motion() noexcept;
  bool comes_near_apron(double moved) const noexcept;
  TriangleIndex& index() noexcept { return near_apron_ ? *model_->wide_index : *model_->index; }
  void follow(const VectorX& patch, VectorX& out) noexcept;
  bool find_impact(Contact& impact) noexcept;
  bool find_impact_of(int tool, Contact& impact) noexcept;
  void accept_free_motion() noexcept;
  void recover_patch_motion() noexcept;
  void step_constrained(std::span<LocalFrame> frames) noexcept;  // local_simulation_constrained.cpp
  void start_tick() noexcept;
  bool may_be_inside(int tool) const noexcept;
  void hold_contacts(double& toi, std::span<LocalFrame> frames) noexcept;
  void rewind_to(const Contact& impact, double& toi, std::span<LocalFrame> frames) noexcept;
  void ignore_around(const Contact& contact) noexcept;
  void end_tick(double toi, std::span<LocalFrame> frames) noexcept;
  void resolve_contacts(double h_left) noexcept;
  void find_contacts(const VectorX& x) noexcept;
  void find_contacts_of(int tool, const VectorX& x, ContactSet& out) noexcept;
  Vec3 place_of(const Contact& contact, const VectorX& x) const noexcept;
  void place_surface(double h_left, VectorX& out) noexcept;
  void couple_contacts(const MatrixX& C, ContactMatrix& out) noexcept;
  void fill_problem(double h_left) noexcept;
  void warm_start(const ContactSet& before) noexcept;
  void drop_clear_places(const ContactSet& before) noexcept;
  void keep_pushing(const ContactSet& before) noexcept;
  void spread_impulses() noexcept;
  void settle_velocities() noexcept;        // local_simulation_velocities.cpp
  bool close_gaps(double h_left) noexcept;  // local_simulation_gaps.cpp
  struct PaperContact;  // local_simulation_geometric.cpp, with the stages of its tick in their order:
  void step_geometric(const ToolSweep& sweep, LocalFrame& frame) noexcept;
  bool return_to_collision(PaperContact& c, LocalFrame& frame) noexcept;
  bool push_triangle_onto_tool(const ToolSweep& sweep, PaperContact& c) noexcept;
  void find_constraint_force(PaperContact& c) noexcept;
  void let_surface_go(const PaperContact& c, LocalFrame& frame) noexcept;
  void advance_constrained(const PaperContact& c) noexcept;
  void report_paper_force(const PaperContact& c, LocalFrame& frame) noexcept;
  void carry_contact_over(const PaperContact& c) noexcept;
  void report_contacts(int tool, LocalFrame& frame) noexcept;
  int find_overlap(int tool) noexcept;
  void sweep_refresh(const PreparedLocalModel& old) noexcept;
  void shape_force(int tool, LocalFrame& frame) noexcept;
  const TouchingTool& tool_of(const Contact& contact) const noexcept { return tools_[contact.tool]; }
  void add_flag(unsigned flag) noexcept {
    for (TouchingTool& tool : tools_) tool.flags |= flag;
  }

  std::vector<TouchingTool> tools_;
  double h_, t_ = 0;
  double residual_ = 0;  // largest of this tick
  std::unique_ptr<ContactSolver> solver_;
  std::unique_ptr<PreparedLocalModel> model_;
  ContactSet contacts_;  // of this tick, the first tool's first
  ContactSet found_;     // room, of one tool
  ContactProblem problem_;
  ContactSolution solution_;
  std::array<ContactSample, kMaxContacts> samples_{};
  int num_samples_ = 0;
  LocalMotion motion_;          // room, for the refresh
  bool has_new_patch_ = false;  // since the last tick
  bool near_apron_ = false;     // a tool may meet what is beyond the patch in this tick
};

}  // namespace kt
