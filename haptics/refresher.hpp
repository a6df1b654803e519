#pragma once
// The slow side of a session: catch up, linearize, reduce around the contact, prepare.          Paper section II.
#include <span>

#include "core/graded_body.hpp"
#include "haptics/local_simulation.hpp"
#include "io/scene.hpp"

namespace kt {

/// What the haptic side reports after each tick.
struct LocalReport {
  int tick = 0;              ///< index of the tick that ended
  Vec3 tool = Vec3::Zero();  ///< [m]
  int triangle = -1;         ///< in contact: which surface triangle
  int count = 0;
  std::array<ContactSample, kMaxContacts> samples{};
};

class Refresher {
 public:
  /// @param max_speed  of the tool [m/s]: with the time that a local model is in use it gives the size of the patch
  Refresher(const DeformableModel& model, const Surface& surface, const Scene& scene, const ToolShape& tool,
            double max_speed, const State& start);

  /// The local model for the tick that starts at time t, after the reports of all ticks before it.
  std::unique_ptr<PreparedLocalModel> refresh(double t, const Vec3& tool, std::span<const LocalReport> reports);

  const State& state() const { return global_.state(); }
  StepStatistics statistics() const { return global_.statistics(); }
  std::vector<double> global_ms, refresh_ms;  ///< time of each integration; of linearize + reduce + prepare
  int definite_tangents = 0;
  int inverted_tetrahedra = 0;  ///< most at any refresh
  double inverted_from = -1;    ///< time of the first one [s]

 private:
  void count_inverted();
  ContactSite find_site(const Vec3& tool, int triangle, double reach) const;
  double reach(double t) const;
  const Surface& surface_;
  Scene scene_;
  ToolShape tool_;
  double max_speed_;
  GlobalSimulation global_;
  ReduceFn reduce_;
  TangentModel tangent_;  // its storage is used again
  GradedBody graded_;
  LocalScheme scheme_;
  Metric metric_;
  double last_ = 0;  // time of the last refresh [s]
  int frame_ = 0;
};

LocalScheme local_scheme(const std::string& integrator);
Metric contact_metric(const std::string& name);

}  // namespace kt
