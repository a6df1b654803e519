#pragma once
#include <vector>

namespace kt {

/// Where contact should have been in a run and was not, by the check of the whole body; see body_check.hpp.
struct LostContact {
  /// A tick in which the tool went through the body, or a part of it, and touched nothing; or so far in one tick that
  /// what it touched did not keep it outside.
  struct PassThrough {
    int tick = 0;         ///< its index
    double distance = 0;  ///< way of the tool in it [m]
  };
  int free_ticks_inside = 0;                ///< ticks without contact that end with the tool inside the body
  int pass_throughs = 0;                    ///< ticks in which it went through
  std::vector<PassThrough> went_through{};  ///< the first of these, at most kMostNamed
  int unchecked_ticks = 0;                  ///< looked at later: that the record had no room for
  int deep_ticks = 0;                       ///< that end with the tool deeper in the body than kNoticeableDepth
  double deepest = 0;                       ///< at the end of a tick [m]
  static constexpr std::size_t kMostNamed = 100;
  /// [m] Contact ends at micrometres: more is a fault, or a tool that a new patch has found inside.
  static constexpr double kNoticeableDepth = 1e-4;
};

}  // namespace kt
