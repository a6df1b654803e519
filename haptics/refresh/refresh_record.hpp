#pragma once
#include <limits>
#include <optional>
#include <vector>

#include "haptics/options/touch_options.hpp"
#include "self_contact/touching_model.hpp"

namespace kt {

/// One refresh, as it went: what it took, and what was found out on the way. Times are those of the clock but cpu_ms.
struct RefreshRecord {
  RefreshEvent event{};
  double t = 0;                       ///< at which the body was linearized [s]
  double delay = 0;                   ///< until its local model would be in use, as was expected [s]
  double cpu_ms = 0;                  ///< of all threads but the ticking one, with the global step
  double beside_ms = 0;               ///< part of cpu_ms that another core did meanwhile: the refresh is shorter by it
  std::optional<double> global_ms{};  ///< of the global step; none: the body was not stepped, as at the start
  double refresh_ms = 0;              ///< of all that follows it
  double linearize_ms = 0, reduce_ms = 0, certify_ms = 0, prepare_ms = 0;  ///< parts of refresh_ms
  double refine_ms = 0, refine_cpu_ms = 0;  ///< of the refined cells, which another core makes beside the local model
  double before_ms = 0;  ///< part of beside_ms: refined cells that were made while the model before was in use
  std::optional<double> fineness{};  ///< largest refined cell over the contact radius; none: not refined
  double refined_share = std::numeric_limits<double>::quiet_NaN();  ///< refined_share() of the contacts before it
  std::optional<double> linearization_error{};      ///< of the interval that ended, see GlobalSimulation::contact_error
  bool definite_tangent = false;                    ///< the exact one was indefinite
  bool looked_ahead = false;                        ///< linearized where the body was expected to be
  bool is_exact = false;                            ///< the local model is stepped exactly
  double coupling = 0;                              ///< of its vibrations, see damping_coupling()
  int inverted = 0;                                 ///< tetrahedra that are inside out
  std::optional<SelfContactReport> self_contact{};  ///< after the global step
  int crossings = -1;                               ///< pairs of triangles that cross after it; -1: not looked
  int pressed = 0;                                  ///< that are as near as makes no difference, and do not cross
  std::vector<SettingChange> settings{};            ///< changed at this refresh
  std::vector<ReducerChange> reducers{};            ///< changed up to its end
};

}  // namespace kt
