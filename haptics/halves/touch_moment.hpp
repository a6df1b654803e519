#pragma once
// What a touch's ticks and refreshes have come to, apart from the body: what an episode that begins there goes on from.
#include <optional>

#include "haptics/refresh/reducer_choice.hpp"
#include "haptics/tick/local_motion.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

struct TouchMoment {
  std::size_t num_tools = 0;                           ///< that the touch had
  LocalMotion motion;                                  ///< of the local model in use, at tick 0; frame kBefore
  std::shared_ptr<const FinePatch> fine;               ///< that motion.yielded is of; null: none
  std::array<std::optional<Vec3>, kMaxTools> force{};  ///< as the hand had it, of tools in contact [N]
  LocalReport report;                  ///< of the last tick, numbered -1, its contacts on triangles of the body
  std::optional<ReducerStart> choice;  ///< of the last refresh

  static constexpr int kBefore = -1;  ///< frame of the local model: before those of the new episode
};

}  // namespace kt
