#pragma once
// What both halves of an advice share: the scene made comparable, and the clock.
#include <chrono>

#include "core/mesh.hpp"
#include "haptics/advise.hpp"
#include "haptics/session.hpp"

namespace kt {

/// The budget's clock; asks for the end when it is spent, or when the user does.
class AdviceClock {
 public:
  explicit AdviceClock(const AdviseOptions& options) : options_(options) {}
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  double left(double share = 1) const { return share * options_.budget_seconds - seconds(); }
  bool stopped() const { return options_.stop && options_.stop->load(); }
  void show() const {
    if (options_.progress) options_.progress(std::min(0.99, seconds() / options_.budget_seconds));
  }
  const std::atomic<bool>* stop() const { return options_.stop; }

 private:
  const AdviseOptions& options_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Where the tool is pressed in, for a body in equilibrium.
struct PressSite {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< of its reference point [m]
  double depth = 0;                             ///< [m]
};

/// The scene with its tool path written out, so that it is the same for every mesh and method.
struct AdviceScene {
  Scene scene;
  Mesh mesh = {};  ///< its own, in metres
  PressSite site = {};
  bool has_ladder = false;    ///< other meshes can be made of its surface
  std::string only_own = {};  ///< why other models and meshes cannot be judged; empty: they can
};

/// The scene with another model: msd, tet4, tet10.
Scene with_model(Scene scene, const std::string& model);
std::string model_name(const SceneModel& model);

/// Median CPU time of a step of the body on one core [ms].
double measure_global_step(const Session& session, const State& state);

struct AdviceBodies {
  AdviceTruth truth = {};
  std::string unjudged = {};  ///< why only the scene's own is there; empty: all were judged
  std::vector<AdviceBody> bodies = {};
  std::vector<Mesh> meshes = {};  ///< of each body; empty where it was not measured
};
/// @param share  of the budget at which it ends
AdviceBodies measure_bodies(const AdviceScene& scene, const AdviceClock& clock, double share,
                            std::vector<std::string>& notes);

/// Fills reference and rows for the scene, which has the chosen model, on `mesh`.
void measure_rates(const AdviceScene& scene, const Mesh& mesh, const AdviceClock& clock, Advice& out);

}  // namespace kt
