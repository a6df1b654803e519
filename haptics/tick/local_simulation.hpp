#pragma once
// The 1 kHz side: free motion, first time of impact, rollback, stick or slip, force.          Paper section IV, fig. 2.
#include <span>
#include <vector>

#include "collision/held/moving_tool.hpp"
#include "core/global/global_simulation.hpp"
#include "haptics/tick/force_blend.hpp"
#include "haptics/tick/haptic_method.hpp"
#include "haptics/tick/local_frame.hpp"
#include "haptics/tick/local_motion.hpp"
#include "haptics/tick/push_force.hpp"

namespace kt {

/// A tool, what a tick has found about it, and what goes on from tick to tick.
struct TouchingTool {
  TouchingTool(const ToolShape& shape, double h, double fade)
      : moving(shape), reach(tool_reach(shape)), blend(h, fade), push(h) {}
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
  std::span<const TickContact> samples() const noexcept override {
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
  void cover_tools(bool at_end, double moved) noexcept;
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
  std::array<TickContact, kMaxContacts> samples_{};
  int num_samples_ = 0;
  LocalMotion motion_;          // room, for the refresh
  bool has_new_patch_ = false;  // since the last tick
  bool near_apron_ = false;     // a tool may meet what is beyond the patch in this tick
};

}  // namespace kt
