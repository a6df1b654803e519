#include "lab/check/hand_paths.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

constexpr double kShortestStroke = 0.075;  // [s] of a drag to and fro, however short the way

/// Lets the hand move on to a place, or along a line of places, as people do: with the least jerk, from rest to rest
/// (Flash and Hogan 1985). A tool that starts or stops at once knocks light bodies away.
void move_hand(std::vector<TimedPoint>& path, double until, const std::vector<Vec3>& line) {
  constexpr double kSample = 2e-3;  // [s]
  const TimedPoint from = path.back();
  std::vector<Vec3> places{from.x};
  places.insert(places.end(), line.begin(), line.end());
  const double length = length_of(places);
  const int samples = std::max(1, static_cast<int>(std::lround((until - from.t) / kSample)));
  std::size_t next = 1;
  double before = 0;  // length up to places[next - 1]
  for (int i = 1; i <= samples; ++i) {
    const double s = static_cast<double>(i) / samples;
    const double gone = i == samples ? length : length * s * s * s * (10 - s * (15 - 6 * s));
    const auto piece = [&] { return (places[next] - places[next - 1]).norm(); };
    for (; next + 1 < places.size() && before + piece() < gone; ++next) before += piece();
    const double share = piece() > 0 ? std::min(1.0, (gone - before) / piece()) : 1;
    path.push_back({from.t + s * (until - from.t), places[next - 1] + share * (places[next] - places[next - 1])});
  }
}

}  // namespace

double length_of(const std::vector<Vec3>& line) {
  double out = 0;
  for (std::size_t i = 1; i < line.size(); ++i) out += (line[i] - line[i - 1]).norm();
  return out;
}

PressPath press_path(const ContactSpot& s) {
  constexpr double kComing = 0.05, kPressing = 0.05, kResting = 0.05, kLeaving = 0.15;  // [s]
  constexpr int kDepths = 4;
  const auto at = [&](double above) { return Vec3(s.place + (s.radius + above) * s.normal); };
  PressPath out;
  out.path = {{0, at(kClearance)}};
  move_hand(out.path, kComing, {at(0)});
  for (int i = 1; i <= kDepths; ++i) {
    out.pressed = out.path.back().t + kPressing;
    move_hand(out.path, out.pressed, {at(-s.depth * i / kDepths)});
    out.rests.push_back(out.pressed + kResting);
    out.path.push_back({out.rests.back(), out.path.back().x});
  }
  move_hand(out.path, out.rests.back() + kLeaving, {at(kClearance)});
  return out;
}

std::vector<TimedPoint> drag_path(const ContactSpot& spot, const std::vector<Vec3>& walk, double speed,
                                  double duration) {
  std::vector<TimedPoint> out{{0, spot.place + (spot.radius + kClearance) * spot.normal}};
  move_hand(out, kDragPressTime, {walk[0]});
  const std::vector<Vec3> back(walk.rbegin(), walk.rend());
  const double one_way = std::max(length_of(walk) / speed, kShortestStroke);
  for (bool is_forth = true; out.back().t < duration && walk.size() > 1; is_forth = !is_forth)
    move_hand(out, out.back().t + one_way, is_forth ? walk : back);
  if (out.back().t < duration) out.push_back({duration, out.back().x});
  return out;
}

}  // namespace kt
