#pragma once
// The body's computer in this process: for a scene with link.type network that is run alone, as in a test. Everything
// goes through sockets as between two computers, with the delay and loss that the scene gives its link.
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "io/scene/scene.hpp"
#include "network/hand_link.hpp"

namespace kt {

/// A server, a relay and the hand's way to them, on this computer's own addresses and without keys.
class BodyBeside {
 public:
  using Say = std::function<void(const std::string&)>;
  /// Builds the body, which takes its time. @throws InputError, RunError as a session of the scene does
  /// @param scene    its link.latency_ms holds each way, its link.loss is the share of datagrams that are lost
  /// @param version  of the program
  /// @param stop     true: the hand waits for the body no longer; borrowed
  BodyBeside(const Scene& scene, const std::string& version, const std::atomic<bool>* stop, Say say);
  ~BodyBeside();  ///< the server has ended

  /// For one run. @param report  filled when the touch stops
  LinkMaker link(std::shared_ptr<HandLinkReport> report);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
