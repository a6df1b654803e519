#pragma once
// What the interfaces of other languages hold by one handle: a body, its touch, and a safety chain for each tool.
#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "haptics/guard/safety_chain.hpp"
#include "haptics/setup/session_parts.hpp"
#include "haptics/touch/touch.hpp"

namespace kt {

class HeldTouch {
 public:
  /// What is wrong with a setting is told before the body is made. Throws InputError.
  /// @param make_body  once; none: of the scene's own mesh
  explicit HeldTouch(const Scene& scene, const std::function<Body()>& make_body = {});
  /// On a body that another touch holds, with the first local model that it found. Throws InputError for a body with
  /// self-contact, whose contact search has one user.
  HeldTouch(const Scene& scene, std::shared_ptr<const Body> shared);

  /// One tick for devices that somebody holds: Touch::tick() between SafetyChain::tool() and make_safe(). Forces and
  /// torques of the frames, which are there until the next call, are what is to be written to the devices now.
  /// @param devices  where they are, one a tool, in the world's frame
  /// @param dt       since the last call [s], > 0
  std::span<const LocalFrame> tick_devices(std::span<const Pose> devices, std::span<const DeviceState> states,
                                           double dt) noexcept;

  /// Touch::findings(), and what the devices were not given: a gate that was shut, forces that were cut or held back,
  /// poses that leapt or were old. In the thread that ticks.
  std::vector<Finding> findings() const;

  /// Touch::reset(), and the chains anew. While nobody ticks.
  /// @param state  null: the start
  void reset(const TouchState* state = nullptr);

  /// Of tool k, for gauges.
  const SafetyChain& chain(std::size_t k) const { return chains_[k]; }

 private:
  using BodyMaker = std::function<std::shared_ptr<const Body>()>;
  HeldTouch(const Scene& scene, const TouchOptions& options, const BodyMaker& make);

  std::shared_ptr<const Body> held_;

 public:
  const Body& body;
  Touch touch;

  /// For another touch of the same body.
  const std::shared_ptr<const Body>& shared_body() const { return held_; }

 private:
  std::vector<SafetyOptions> safety_;
  std::vector<SafetyChain> chains_;
  std::array<LocalFrame, kMaxTools> given_;
};

/// A surface in metres that the scene's `object` fills, a solid as it is. For HeldTouch.
Body body_of_mesh(Mesh mesh, const Scene& scene);

}  // namespace kt
