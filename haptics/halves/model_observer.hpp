#pragma once
// Follows the local models of a touch from outside the engine: for checks that need them.
#include "haptics/refresh/refresh_record.hpp"
#include "haptics/tick/prepared_local_model.hpp"

namespace kt {

class ModelObserver {
 public:
  virtual ~ModelObserver() = default;
  /// The local model in use from now on. In the thread that ticks: no allocation where ticks are against the wall
  /// clock.
  virtual void adopted(const PreparedLocalModel& /*model*/) noexcept {}
  /// Time for up to `most` of the ticks that this local model was in use for, which is over. False: none is left of
  /// them. In the body's thread, where it has one.
  virtual bool look_back(const PreparedLocalModel& /*model*/, int /*most*/) { return false; }
  /// A refresh whose local model has been adopted, or never will be: one after another, each once. In the body's
  /// thread, where it has one.
  virtual void refreshed(const RefreshRecord& /*record*/) {}
};

}  // namespace kt
