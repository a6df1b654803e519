#pragma once
// Stick, slide or slide with friction? From contacts and the body's response to impulses, the impulses and the force on
// the tool. Backends: contact_solver.def.
#include <memory>
#include <string>
#include <vector>

#include "collision/held/surface_contacts.hpp"
#include "core/base/backend.hpp"
#include "haptics/contact/contact_work.hpp"
#include "haptics/contact/friction.hpp"

namespace kt {

/// Stacked over contacts, with room for kMaxContacts and no heap.
using ContactVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3 * kMaxContacts, 1>;
using ContactMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3 * kMaxContacts, 3 * kMaxContacts>;

/// One tick's contacts as seen by a solver; c contacts, world frame. v+ = velocity + W p.
struct ContactProblem {
  int count = 0;
  std::array<bool, kMaxContacts> sliding{};  ///< its tool slid in the last tick: static friction is overcome, the
                                             ///< kinetic coefficient alone holds until it sticks
  bool is_bounded = false;                   ///< of many contacts, few direct solutions: refined cells have many
  bool is_first = false;                     ///< its answer only says where to solve it again
  ContactWork* work = nullptr;               ///< that is left of the tick's; null: no bound
  bool is_repeated = false;                  ///< it was solved some times in this tick, at other places of the surface
  double h = 0;                              ///< [s], over which the impulses act as forces
  std::array<Vec3, kMaxContacts> normal;     ///< unit, from the body towards the tool
  std::array<int, kMaxContacts> triangle{};  ///< of the body's surface: where it has regions, their friction holds
  std::array<double, kMaxContacts> lost_grip{};  ///< share of that friction that a place has lost
  ContactVector velocity;       ///< of the body's contact points without contact, relative to the tool [m/s];
                                ///< its normal part is -gap/h, so that v+ = 0 closes the gap exactly
  ContactMatrix W;              ///< velocity change per impulse through the chosen metric [1/kg]
  Vec3 force = Vec3::Zero();    ///< J f / s: what the paper's operators project [N]; geometric laws only
  Mat3 inertia = Mat3::Zero();  ///< J M^-1 J^T [1/kg]; geometric laws only
};

struct ContactSolution {
  std::array<ContactMode, kMaxContacts> mode{};
  std::array<double, kMaxContacts> grip{};  ///< sticking holds up to this share of the normal impulse
  ContactVector impulse;                    ///< on the body through the metric [N s]
  Vec3 inertial_impulse = Vec3::Zero();     ///< on the body through its inertia [N s]; geometric laws only
  Vec3 force_on_tool = Vec3::Zero();        ///< [N]
  int iterations = 0;
  double residual = 0;  ///< how far from the law's conditions, relative: natural_residual in contact_sweeps.hpp
};

/// How the surface is put under the tool before forces are computed.
enum class Deformation {
  none,    ///< it is not: the solver's impulses move it (consistent laws)
  normal,  ///< pushed along the normal (paper, frictionless)
  full     ///< carried along with the tool (paper, with friction)
};

/// solve() runs in the haptic tick: no allocation, no exception, bounded work. A solver belongs to one thread.
class ContactSolver {
 public:
  virtual ~ContactSolver() = default;
  virtual Deformation deformation() const noexcept = 0;
  /// From now on the coefficients at `friction`, which stays there until the next call; none: those of construction.
  virtual void use(const SurfaceFriction* /*friction*/) noexcept {}
  /// @param solution  in: impulses to start from (or zero); out: the result
  virtual void solve(const ContactProblem& problem, ContactSolution& solution) noexcept = 0;
};

std::vector<BackendInfo> contact_solver_backends();

/// @param of_triangle  friction of each surface triangle; empty: `friction` everywhere
/// Throws InputError for an unknown law or coefficients outside 0 <= mu_kinetic <= mu_static.
std::unique_ptr<ContactSolver> make_contact_solver(const std::string& law, const Friction& friction,
                                                   std::vector<Friction> of_triangle = {});

}  // namespace kt
