#pragma once
// What the ticks of the baselines have in common: motion of the local body, the contact problem's regularization, the
// report to both sides. LocalSimulation has its own, with time of impact and rollback in them.
#include "haptics/tick/local_simulation.hpp"

namespace kt {

/// What one tick did at its contacts.
struct SampleList {
  std::array<TickContact, kMaxContacts> samples{};
  int count = 0;
  std::span<const TickContact> view() const noexcept { return {samples.data(), static_cast<std::size_t>(count)}; }
};

/// What baselines with ticks of their own hold.
class Baseline : public HapticMethod {
 public:
  std::span<const TickContact> samples() const noexcept override { return samples_.view(); }
  const PreparedLocalModel& model() const noexcept override { return *model_; }
  double h() const noexcept override { return h_; }
  const ToolShape& tool() const noexcept override { return tool_; }

 protected:
  /// Throws InputError for a law that is not Coulomb's cone.
  Baseline(const std::string& method, const HapticMethodOptions& options);
  /// Of the tick that begins; nothing is touched yet.
  LocalFrame next_frame(const ToolSweep& sweep) noexcept;

  ToolShape tool_;
  double h_, t_ = 0;
  std::unique_ptr<ContactSolver> solver_;
  std::unique_ptr<PreparedLocalModel> model_;
  bool sliding_ = false;  // in the last tick
  ContactProblem problem_;
  ContactSolution solution_;
  std::array<Vec3, kMaxContacts> point_{};
  SampleList samples_;
};

/// Point of a patch triangle in a stacked array (3p).
inline Vec3 at_point(const VectorX& stacked, const Triangle& t, const Vec3& bary) noexcept {
  return bary[0] * node(stacked, t[0]) + bary[1] * node(stacked, t[1]) + bary[2] * node(stacked, t[2]);
}

/// Starts a tick: patch positions work.x, and velocities work.v_free (r) and work.u_free (3p) at its end if nothing
/// touched the body.
void find_free_motion(PreparedLocalModel& m) noexcept;

/// Ends the tick with the patch impulses work.impulse (3p) acting over it; work.x_end are the positions then.
void step_body(PreparedLocalModel& m) noexcept;

/// Adds an impulse at a patch point to work.impulse.
void add_impulse(PreparedLocalModel& m, int triangle, const Vec3& bary, const Vec3& impulse) noexcept;

/// Makes a contact with an immovable part solvable: there it gives way like a stiff spring. True when it had to.
bool soften(const PreparedLocalModel& m, ContactProblem& problem) noexcept;

/// Tells what the impulses of `solution` did, at contacts whose points end at `point`: forces and modes in the frame,
/// samples for the global side. Contacts without an impulse are left out.
void report_contacts(const SurfacePatch& patch, const ContactSet& contacts, const ContactSolution& solution,
                     const std::array<Vec3, kMaxContacts>& point, double h, LocalFrame& frame,
                     SampleList& out) noexcept;

/// Ends the tick like a broken one when a number left the finite range: no force, the body where it was linearized.
/// True when all was well.
bool keep_finite(PreparedLocalModel& m, LocalFrame& frame, SampleList& samples) noexcept;

}  // namespace kt
