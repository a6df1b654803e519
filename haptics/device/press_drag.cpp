#include "haptics/device/press_drag.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "collision/held/first_contact.hpp"
#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr double kSpacing = 5e-4;   // [m] between points of the drag
constexpr double kSteepest = 0.6;   // rise per run
constexpr double kThinnest = 3.0;   // thickness of the body under the tool, in depths
constexpr double kEase = 0.1;       // [s] in which an eased tool takes up its speed
constexpr double kEaseStep = 1e-3;  // [s] between points of an eased path

/// A body that is touched along an axis, again and again: its triangles by where they are across it, the
/// highest first.
class Touched {
 public:
  Touched(const Mesh& mesh, int axis)
      : mesh_(mesh), axis_(axis), box_(bounds(mesh)), bins_(kBins * kBins), seen_(mesh.triangles.size(), 0) {
    std::vector<int> order(mesh.triangles.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::greater{},
                             [&](int t) { return box_of(mesh.triangles[static_cast<std::size_t>(t)]).high[axis]; });
    for (const int t : order) {
      for_bins(box_of(mesh.triangles[static_cast<std::size_t>(t)]), [&](std::size_t bin) { bins_[bin].push_back(t); });
    }
  }

  const Bounds& box() const { return box_; }

  /// First touch of a tool moving from one end of a line along the axis to the other.
  std::optional<Vec3> sweep(MovingTool& tool, const ToolSweep& sweep) const {
    tool.move(sweep);
    constexpr double kRounding = 1e-6;
    const double radius = tool.shape().radius;
    Box box = tool.box();
    box.low.array() -= radius;
    box.high.array() += radius;
    const double from = sweep.x_t0[axis_], way = sweep.x_t1[axis_] - from, reach = tool_reach(tool.shape());
    double first = 2;
    ++sweeps_;
    for_bins(box, [&](std::size_t bin) {
      const std::size_t count = bins_[bin].size();
      for (std::size_t i = 0; i < count; ++i) {  // what lies nearest first
        const int t = bins_[bin][way < 0 ? i : count - 1 - i];
        if (std::exchange(seen_[static_cast<std::size_t>(t)], sweeps_) == sweeps_) continue;  // from another bin
        const Triangle& v = mesh_.triangles[static_cast<std::size_t>(t)];
        const Box its = box_of(v);
        const double ahead = way < 0 ? from - its.high[axis_] : its.low[axis_] - from;
        if (is_apart(box, its) || ahead - reach > (first + kRounding) * std::abs(way)) continue;
        const Vec3 triangle[3] = {node(mesh_.x, v[0]), node(mesh_.x, v[1]), node(mesh_.x, v[2])};
        if (const auto hit = find_tool_impact(tool, triangle, triangle)) first = std::min(first, hit->toi);
      }
    });
    if (first > 1) return std::nullopt;
    return Vec3(sweep.x_t0 + first * (sweep.x_t1 - sweep.x_t0));
  }

  /// A line through the whole body, from above.
  ToolSweep line_through(const MovingTool& tool, const Vec3& over, const Quaternion& turn) const {
    const double above = tool_reach(tool.shape()) + 0.01 * box_.size().norm();
    ToolSweep sweep{over, over, turn, turn};
    sweep.x_t0[axis_] = box_.max[axis_] + above;
    sweep.x_t1[axis_] = box_.min[axis_] - above;
    return sweep;
  }

 private:
  static constexpr int kBins = 64;  // along each of the other two axes

  Box box_of(const Triangle& t) const {
    const Vec3 a = node(mesh_.x, t[0]), b = node(mesh_.x, t[1]), c = node(mesh_.x, t[2]);
    return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
  }
  int bin(double x, int along) const {
    const double share = (x - box_.min[along]) / std::max(box_.size()[along], 1e-300);
    return static_cast<int>(std::clamp(share * kBins, 0.0, kBins - 1.0));
  }
  template <class Take>
  void for_bins(const Box& box, const Take& take) const {
    const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
    for (int j = bin(box.low[v], v); j <= bin(box.high[v], v); ++j)
      for (int i = bin(box.low[u], u); i <= bin(box.high[u], u); ++i) take(static_cast<std::size_t>(i + kBins * j));
  }

  const Mesh& mesh_;
  int axis_;
  Bounds box_;
  std::vector<std::vector<int>> bins_;
  mutable std::vector<int> seen_;  // the last sweep that a triangle was met in
  mutable int sweeps_ = 0;
};

/// Extent of the tool along an axis [m].
double height(const MovingTool& tool, int axis) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vec3& x : tool.core().corners) {
    low = std::min(low, x[axis]);
    high = std::max(high, x[axis]);
  }
  return high - low + 2 * tool.shape().radius;
}

/// Touch points along a line, as far as the surface goes on, is not steep, and the body is thick enough to press into.
std::vector<Vec3> touch_line(const Touched& body, MovingTool& tool, int axis, double depth, Vec3 over,
                             const Vec3& direction, double length, const Quaternion& turn) {
  std::vector<Vec3> out;
  const int points = 1 + static_cast<int>(std::min(1e9, std::ceil(length / kSpacing)));  // it ends with the body
  for (int i = 0; i < points; ++i) {
    const auto touch = body.sweep(tool, body.line_through(tool, over + i * kSpacing * direction, turn));
    if (!touch) break;
    if (!out.empty() && std::abs((*touch)[axis] - out.back()[axis]) > kSteepest * kSpacing) break;
    const ToolSweep down = body.line_through(tool, *touch, turn);
    const auto bottom = body.sweep(tool, {down.x_t1, down.x_t0, turn, turn});
    const double thickness = bottom ? (*touch)[axis] - (*bottom)[axis] - height(tool, axis) : 0;
    if (!out.empty() && thickness < kThinnest * depth) break;
    out.push_back(*touch);
  }
  return out;
}

/// Way from rest to rest with least jerk; all from 0 to 1.
double rest_to_rest(double t) { return t * t * t * (10 + t * (6 * t - 15)); }

/// Way made while the speed rises from 0 to 1 with least jerk: 1/2 at t = 1.
double speeding_up(double t) { return t * t * t * (1 - 0.5 * t); }

/// From one end of the drag to the other.
struct Stroke {
  double length, speed;  // [m], [m/s]
  double ramp = std::min(kEase, length / speed);
  double time = length / speed + ramp;
  double way(double t) const {
    if (t < ramp) return speed * ramp * speeding_up(t / ramp);
    if (t > time - ramp) return length - speed * ramp * speeding_up((time - t) / ramp);
    return speed * (t - 0.5 * ramp);
  }
};

Vec3 place_on(const std::vector<Vec3>& line, double way) {
  const double at = std::clamp(way / kSpacing, 0.0, static_cast<double>(line.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(at), line.size() - 2);
  return line[i] + (at - static_cast<double>(i)) * (line[i + 1] - line[i]);
}

std::vector<TimedPoint> eased_path(const std::vector<Vec3>& line, const PressDragOptions& o) {
  const Vec3 up = Vec3::Unit(o.axis);
  std::vector<TimedPoint> path;
  const int pressing = std::max(1, static_cast<int>(std::ceil(o.press_time / kEaseStep)));
  for (int i = 0; i <= pressing; ++i) {
    const double share = i / static_cast<double>(pressing);
    path.push_back(
        {share * o.press_time, line[0] + (o.clearance - rest_to_rest(share) * (o.clearance + o.depth)) * up});
  }
  if (!(o.speed > 0) || line.size() < 2) return path;
  const Stroke stroke{kSpacing * static_cast<double>(line.size() - 1), o.speed};
  for (int i = 1; path.back().t < o.duration; ++i) {
    const double strokes = i * kEaseStep / stroke.time, begun = std::floor(strokes);
    const double way = stroke.way((strokes - begun) * stroke.time);
    const bool returns = std::fmod(begun, 2) == 1;
    path.push_back({o.press_time + i * kEaseStep, place_on(line, returns ? stroke.length - way : way) - o.depth * up});
  }
  return path;
}

std::vector<TimedPoint> even_path(const std::vector<Vec3>& line, const PressDragOptions& o) {
  const Vec3 up = Vec3::Unit(o.axis);
  std::vector<TimedPoint> path{{0, line[0] + o.clearance * up}, {o.press_time, line[0] - o.depth * up}};
  const double dt = o.speed > 0 ? kSpacing / o.speed : 0;
  const int last = static_cast<int>(line.size()) - 1;
  for (int i = 1; dt > 0 && last > 0 && path.back().t < o.duration; ++i) {
    const int turn = i % (2 * last);  // there and back again
    path.push_back({o.press_time + i * dt, line[turn <= last ? turn : 2 * last - turn] - o.depth * up});
  }
  return path;
}

/// A path is kept point by point: one that would fill the memory is told.
void check_length(const std::vector<Vec3>& line, const PressDragOptions& o) {
  constexpr double kMostPoints = 5e6;  // an hour and more at a point a millisecond, 160 MB
  const double step = o.eased ? kEaseStep : kSpacing / o.speed;
  const double points = (o.duration - o.press_time) / step;
  if (!(o.speed > 0) || line.size() < 2 || points <= kMostPoints) return;
  throw InputError(text("tool.path.press_drag.speed: a drag of ", o.duration - o.press_time, " s at ", o.speed,
                        " m/s has ", points, " points, must be at most ", kMostPoints, ": take a shorter duration",
                        o.eased ? "" : " or a lower speed"));
}

std::vector<TimedPoint> path_along(const std::vector<Vec3>& line, const PressDragOptions& o) {
  check_length(line, o);
  return o.eased ? eased_path(line, o) : even_path(line, o);
}

bool is_clear(const std::vector<Vec3>& line, const PressDragOptions& o) {
  return o.other.empty() || !(least_distance(path_along(line, o), o.other) < o.apart);
}

/// Of a grid of places, the one with the longest drag; ties go to the place nearest to the middle.
Vec3 choose_place(const Touched& body, MovingTool& tool, const PressDragOptions& o, const Vec3& direction,
                  double length) {
  const int axis = o.axis;
  const Bounds& box = body.box();
  const Vec3 side = Vec3::Unit(axis).cross(direction);
  const double along = box.size().dot(direction.cwiseAbs()), across = box.size().dot(side.cwiseAbs());
  Vec3 best = box.centre();
  double best_score = -1;
  for (int i = -3; i <= 3; ++i)
    for (int k = -3; k <= 3; ++k) {
      const Vec3 over = box.centre() + 0.11 * (i * along * direction + k * across * side);
      const auto line = touch_line(body, tool, axis, o.depth, over, direction, length, o.turn);
      if (line.empty() || !is_clear(line, o)) continue;
      const double height = (line.front()[axis] - box.min[axis]) / box.size()[axis];
      const double score = static_cast<double>(line.size()) * (0.5 + height) / (1 + 0.02 * (i * i + k * k));
      if (score > best_score) {
        best_score = score;
        best = over;
      }
    }
  if (best_score < 0 && !o.other.empty())
    throw InputError(text("second_tool.path.press_drag.at: no place on the body stays ", 1e3 * o.apart,
                          " mm clear of the first tool; name one, or take a smaller tool"));
  return best;
}

}  // namespace

std::vector<TimedPoint> make_press_drag(const Mesh& mesh, const ToolShape& tool, const PressDragOptions& o) {
  Vec3 direction = o.direction;
  direction[o.axis] = 0;
  if (!(direction.norm() > 0))
    throw InputError(text("tool.path.press_drag.direction: has no part across the pressing axis ", "xyz"[o.axis]));
  direction.normalize();
  const double drag_time = std::max(0.0, o.duration - o.press_time);

  MovingTool moving(tool);
  const Touched body(mesh, o.axis);
  Vec3 over = body.box().centre();
  if (o.at)
    for (int k = 0, i = 0; k < 3; ++k) {
      if (k != o.axis) over[k] = (*o.at)[i++];
    }
  else
    over = choose_place(body, moving, o, direction, o.speed * drag_time);
  const std::vector<Vec3> line =
      touch_line(body, moving, o.axis, o.depth, over, direction, o.speed * drag_time, o.turn);
  if (line.empty())
    throw InputError(text("tool.path.press_drag.at: a tool dropped along ", "xyz"[o.axis], " over (", over.transpose(),
                          ") misses the body, which spans (", body.box().min.transpose(), ") to (",
                          body.box().max.transpose(), ") m"));

  return path_along(line, o);
}

}  // namespace kt
