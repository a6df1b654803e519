#pragma once
// A body whose refresh is held up when asked for, as on a machine that is busy with something else.
#include <atomic>
#include <chrono>
#include <thread>

#include "core/body/wrapping_model.hpp"

namespace kt {

struct HeldUpModel final : WrappingModel {
  using WrappingModel::WrappingModel;
  void update_tangent(const State& s, TangentKind kind, Tangent& out) const override {
    if (const int ms = hold_ms.exchange(0); ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(ms));
    while (is_held) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    model_.update_tangent(s, kind, out);
  }
  mutable std::atomic<int> hold_ms{0};  ///< that the next tangent takes longer
  std::atomic<bool> is_held{false};     ///< no tangent is ready while this is set
};

}  // namespace kt
