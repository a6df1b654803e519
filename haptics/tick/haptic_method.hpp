#pragma once
// What runs in the haptic tick: the engine's own method (LocalSimulation) and the baselines that it is charted against,
// each the best honest form of its idea. docs/methods.md. Table: haptic_method.def.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "haptics/contact/contact_solver.hpp"
#include "haptics/tick/local_frame.hpp"
#include "haptics/tick/prepared_local_model.hpp"
#include "haptics/tick/tick_contact.hpp"

namespace kt {

class HapticMethod {
 public:
  virtual ~HapticMethod() = default;

  /// On the slow side, at each refresh: adds what this method computes once per local model. May allocate and throw.
  /// @param interval  from one refresh to the next [s]
  virtual void prepare_method_data(PreparedLocalModel& /*model*/, double /*interval*/) const {}

  // The rest belongs to the haptic thread: no allocation, lock or clock.

  /// Goes over to a new local model; gives the old one back, to be freed elsewhere.
  virtual std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> next) noexcept = 0;
  /// Before the first tick: forces of tools in contact go on from those of another run [N].
  virtual void go_on_from(std::span<const std::optional<Vec3>> /*forces*/) noexcept {}
  /// One haptic tick with the tool moving along `sweep`. Needs an adopted model.
  virtual LocalFrame step(const ToolSweep& sweep) noexcept = 0;
  /// The same with several tools: one frame for each. A method that knows one tool steps that one.
  virtual void step_tools(std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) noexcept;
  /// What the last tick did to the body, for the global side.
  virtual std::span<const TickContact> samples() const noexcept = 0;
  /// The local model with the body's state as this method sees it.
  virtual const PreparedLocalModel& model() const noexcept = 0;
  virtual double h() const noexcept = 0;
  virtual const ToolShape& tool() const noexcept = 0;  ///< the first one
};

/// Spring and damper between the tool and its proxy on the surface (method `penalty`).
struct ProxyCoupling {
  double stiffness = 200;  ///< [N/m], > 0
  double damping = 0;      ///< [N s/m], >= 0
};

struct HapticMethodOptions {
  std::vector<ToolShape> tools{ToolShape{}};  ///< multirate: 1 to kMaxTools, on the same body; the others know one
  double h = 1e-3;                            ///< haptic step [s]
  std::string law = "coulomb";                ///< contact.law
  Friction friction;
  ProxyCoupling coupling;
  std::vector<Friction> friction_of_triangle{};  ///< of the surface; empty: `friction` everywhere
  double blend = 0;                              ///< multirate: over which a new local model's force fades in [s]
};

std::vector<BackendInfo> haptic_method_backends();

/// Throws InputError for an unknown name, and for a law or a value that the method cannot use.
std::unique_ptr<HapticMethod> make_haptic_method(const std::string& name, const HapticMethodOptions& options);

}  // namespace kt
