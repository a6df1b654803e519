#pragma once
// What the stages of a tick hand on, each field under the stage that writes it. The vectors of a local model's size are
// in its LocalState, which goes on from tick to tick, and its LocalWorkspace.
#include <memory>
#include <span>
#include <vector>

#include "collision/held/moving_tool.hpp"
#include "haptics/contact/contact_solver.hpp"
#include "haptics/tick/force_blend.hpp"
#include "haptics/tick/local_frame.hpp"
#include "haptics/tick/local_motion.hpp"
#include "haptics/tick/push_force.hpp"

namespace kt {

/// A tool, what a tick has found about it, and what goes on from tick to tick.
struct TouchingTool {
  TouchingTool(const ToolShape& shape, double h, double fade)
      : whole(shape), rest(shape), reach(tool_reach(shape)), blend(h, fade), push(h) {}
  const ToolShape& shape() const noexcept { return whole.shape(); }

  // step_tick(): the pose.
  MovingTool whole;  ///< along this tick's sweep
  // Events within the tick.
  MovingTool rest;  ///< along what is left of that after the last event
  int start = -1;   ///< facet that it touches in this tick, -1: none yet
  // Any stage.
  unsigned flags = 0;  ///< LocalFlag
  // use_model(): the radius in use.
  double reach;  ///< tool_reach() [m]
  // shape_force(): from tick to tick.
  ForceBlend blend;
  PushForce push;
  bool was_on_rim = false;    ///< the last tick's contact was at the edge of the patch
  bool is_off_patch = false;  ///< contact ended there: the tool may have got into the body unseen
};

struct TickState {
  /// @param blend  over which the difference between two local models fades from the force [s]; 0: not at all
  TickState(std::span<const ToolShape> shapes, double step, std::unique_ptr<ContactSolver> law, double blend);

  double h;  ///< tick [s]
  std::unique_ptr<ContactSolver> solver;
  std::vector<TouchingTool> tools;

  // use_model(), change_model().
  PreparedLocalModel* model = nullptr;  ///< in use; borrowed
  LocalMotion motion;                   ///< room for that of the model before
  bool has_new_patch = false;           ///< since the last tick

  // step_tick().
  double t = 0;  ///< end of the tick [s]

  // find_free_motion().
  bool near_apron = false;  ///< a tool may meet what is beyond the patch in this tick

  // Events within the tick.
  double toi = 0;  ///< of the last one, as a share of the tick

  // Places that are held, and the law's answer. Of the paper's laws: one.
  ContactSet found;     ///< room, of one tool
  ContactSet contacts;  ///< the first tool's first
  ContactProblem problem;
  ContactSet coupled;   ///< contacts whose responses are in problem.W; those of nodes stay from tick to tick
  int coupled_in = -1;  ///< frame of their local model
  ContactSolution solution;
  double residual = 0;  ///< largest of this tick
  /// Of a tick, at most. Some 4 ms of a core that does two multiply-adds a nanosecond. A ball at rest on a scan of more
  /// vertices than its cells have nodes takes up to 6 million: with 1.5 million its force went to and fro by a third.
  long most_work = 8'000'000;
  ContactWork work;  ///< that is left of this tick's

  // report_contacts().
  std::array<TickContact, kMaxContacts> samples{};
  int num_samples = 0;

  int num_tools() const noexcept { return static_cast<int>(tools.size()); }
  const TouchingTool& tool_of(const Contact& contact) const noexcept { return tools[contact.tool]; }
  /// Of all that tools may meet in this tick.
  TriangleIndex& index() const noexcept { return near_apron ? *model->wide_index : *model->index; }
  double h_left() const noexcept { return (1 - toi) * h; }  ///< of the tick after the last event [s]
  void add_flag(unsigned flag) noexcept {
    for (TouchingTool& tool : tools) tool.flags |= flag;
  }
};

/// From now on `model`, with the friction and the tools' radii that came with it.
void use_model(TickState& tick, PreparedLocalModel& model) noexcept;

}  // namespace kt
