#pragma once
// What a touch's ticks and refreshes have come to, apart from the body: what an episode that begins there goes on from.
#include <optional>
#include <vector>

#include "haptics/refresh/refresher.hpp"
#include "haptics/tick/local_motion.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

struct TouchMoment {
  static constexpr int kBefore = -1;  ///< frame of the local model: before those of the new episode

  std::shared_ptr<const void> body;       ///< Body::identity()
  std::size_t num_tools = 0;              ///< that the touch had
  LocalMotion motion;                     ///< of the local model in use, at tick 0; frame kBefore
  std::shared_ptr<const FinePatch> fine;  ///< that motion.yielded is of; null: none
  std::vector<Vec3> offset;               ///< of its vertices, offsets_of()
  int age = 1;                            ///< ticks since the refresh that the body is of
  /// Of these ticks, the last one numbered -1, contacts on triangles of the body. Before them one of some ticks ago,
  /// with poses alone.
  std::vector<LocalReport> reports;
  std::array<std::optional<Vec3>, kMaxTools> force{};  ///< as the hand had it, of tools in contact [N]
  RefreshMemory memory;

  const LocalReport& last() const noexcept { return reports.back(); }
  bool is_at(std::size_t tool, const Pose& pose) const noexcept {
    const Pose& was = last().tools[tool].pose;
    return was.x == pose.x && was.r.coeffs() == pose.r.coeffs();
  }
};

}  // namespace kt
