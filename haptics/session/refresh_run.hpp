#pragma once
// The refreshes of a run, one after another.
#include <string>
#include <utility>
#include <vector>

#include "haptics/halves/touch_status.hpp"
#include "haptics/refresh/inverted_tetrahedra.hpp"
#include "haptics/refresh/refresh_record.hpp"

namespace kt {

/// The body's contacts with itself, over the refreshes of a run.
struct SelfContactRun {
  SelfContactReport extremes;  ///< most contacts, nearest pair, largest sum of normal forces, most energy
  double mean_normal = 0;      ///< of the sums of normal forces [N]
  double touching_share = 0;   ///< of the global steps, those that end with a contact [-]
  double reach = 0;            ///< in use [m]
  double stiffness = 0;        ///< of the barrier, in use [N/m]
  int crossings = -1;  ///< most pairs of triangles that crossed after a global step: 0, or a bug; -1: not looked
  int pressed = 0;     ///< most pairs that no step could bring nearer: the barrier is too soft for what presses
};

struct RefreshRun {
  std::vector<double> global_ms;   ///< of each global step
  std::vector<double> refresh_ms;  ///< of all that follows it
  std::vector<std::pair<std::string, std::vector<double>>> parts_ms{
      {"linearize", {}}, {"reduce", {}}, {"refine", {}}, {"certify", {}}, {"prepare", {}}};
  std::vector<double> cpu_ms;  ///< CPU time of all threads but the haptic one for each refresh, with global steps
  std::vector<double> linearization_error;  ///< of each interval
  std::vector<double> fineness;             ///< of each with refined cells: their size over the contact radius
  std::vector<double> refined_share;        ///< of each of these: refined_share() of the contacts before it
  double damping_coupling = 0;              ///< of the last local model
  RefreshEnergy energy{};                   ///< of the swaps of local models
  int exact_steps = 0;                      ///< local models that were stepped exactly
  int definite_tangents = 0;                ///< refreshes whose exact tangent was indefinite
  int looked_ahead = 0;                     ///< refreshes that linearized the body where it was expected to be
  InvertedTetrahedra inverted;

  void add(const RefreshRecord& record);
  /// Of a body with self-contact; reach and stiffness are left open.
  SelfContactRun self_contact() const;

 private:
  SelfContactRun sums_;  // of normal forces and of steps with contacts
  int self_contacts_ = 0;
};

}  // namespace kt
