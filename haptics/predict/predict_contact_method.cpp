#include "haptics/predict/predict_contact_method.hpp"

#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "haptics/setup/built_scene.hpp"
#include "haptics/tick/haptic_method.hpp"

namespace kt {
namespace {

/// Share of the way a..b at which it crosses the triangle's plane within it, from outside when `inward`; none.
std::optional<double> crossing(const Vec3& a, const Vec3& b, const VectorX& x, const Triangle& t, bool inward) {
  const Vec3 p = node(x, t[0]), e = node(x, t[1]) - p, f = node(x, t[2]) - p, n = e.cross(f), way = b - a;
  const double fall = -n.dot(way);
  if (inward ? !(fall > 0) : !(fall < 0)) return {};
  const double share = n.dot(a - p) / fall;
  if (!(share >= 0 && share <= 1)) return {};
  const Vec3 at = a + share * way - p;
  const double area_sq = n.squaredNorm(), u = at.cross(f).dot(n) / area_sq, v = e.cross(at).dot(n) / area_sq;
  if (u < -1e-9 || v < -1e-9 || u + v > 1 + 1e-9) return {};
  return share;
}

}  // namespace

std::optional<ToolMeeting> find_meeting(const BuiltScene& built) {
  const std::vector<TimedPoint>& path = built.path();
  const std::vector<Triangle>& triangles = built.surface().triangles;
  const VectorX& x = built.start().x;
  const double radius = built.tool().radius;
  ToolMeeting out;
  out.thickness = out.mass = std::numeric_limits<double>::infinity();
  bool has_touched = false;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double time = path[i].t - path[i - 1].t;
    const Vec3 way = path[i].x - path[i - 1].x;
    if (!(time > 0) || way.isZero(0)) continue;
    const double speed = way.norm() / time;
    const Vec3 ahead = radius * way.normalized();  // of the tool: its front touches first
    const Vec3 a = path[i - 1].x + ahead, b = path[i].x + ahead;
    double in = std::numeric_limits<double>::infinity(), through = in;
    for (const Triangle& t : triangles)
      if (const auto share = crossing(a, b, x, t, true)) {
        in = std::min(in, *share);
        for (const int v : t) out.mass = std::min(out.mass, built.model().mass().coeff(3 * v, 3 * v));
      }
    constexpr double kFarther = 1e3;  // ways: the body's end may lie beyond that of the path
    for (const Triangle& t : triangles)
      if (const auto share = crossing(a, a + kFarther * way, x, t, false); share && kFarther * *share > in)
        through = std::min(through, kFarther * *share);
    if (in <= 1) {
      out.speed = std::max(out.speed, speed);
      if (through > in) out.thickness = std::min(out.thickness, (through - in) * way.norm());
      has_touched = true;
    }
    if (has_touched) out.drag = std::max(out.drag, speed);
  }
  if (!has_touched) return {};
  return out;
}

std::optional<Prediction> predict_tunnelling(const Scene& scene, const ToolMeeting& m) {
  const std::string& method = scene.local.method;
  const double h = 1 / scene.local.rate_hz, refresh = 1 / scene.global.rate_hz;
  const double radius = scene.tool.shape == "point" ? 0 : scene.tool.radius;
  const auto warn = [&](const std::string& why) {
    return Prediction{"tunnelling", Finding{told("local.method ", method, ": the tool may go through the body, ", why),
                                            {set_to("local.method", "multirate"), advise("move the tool more slowly")}}
                                        .at("local.method")};
  };
  if (method == "penalty" && m.thickness < radius)
    return warn(told("which is ", 1e3 * m.thickness, " mm thin where a ball of ", 1e3 * radius,
                     " mm is pushed to the nearest side"));
  if ((method == "penalty" || method == "frozen") && radius > 0 && m.speed * h > 2 * radius)
    return warn(told("its ", 1e3 * m.speed * h, " mm a tick are more than its own ", 2e3 * radius, " mm"));
  if (method == "legacy" && m.speed * refresh > radius)
    return warn(told("its ", 1e3 * m.speed * refresh,
                     " mm between two refreshes, when contact is looked for, are more ", "than its radius of ",
                     1e3 * radius, " mm"));
  return {};
}

std::optional<Prediction> predict_chatter(const Scene& scene, const ToolMeeting& m) {
  const std::string& method = scene.local.method;
  const double h = 1 / scene.local.rate_hz, refresh = 1 / scene.global.rate_hz;
  const double radius = scene.tool.shape == "point" ? 0 : scene.tool.radius;
  if (method == "penalty") {
    // The spring's force is a tick old: a node between it and nothing else swings up when omega h > 2.
    const double stiffest = 4 * m.mass / (h * h);
    if (scene.contact.penalty.stiffness > stiffest)
      return Prediction{"friction", Finding{told("contact.penalty.stiffness ", scene.contact.penalty.stiffness,
                                                 " N/m chatters: surface nodes of ", 1e3 * m.mass, " g take at most ",
                                                 stiffest, " N/m at ", scene.local.rate_hz, " Hz"),
                                            {set_to("contact.penalty.stiffness", short_number(stiffest)),
                                             set_to("local.method", "multirate")}}
                                        .at("contact.penalty.stiffness", scene.contact.penalty.stiffness, stiffest)};
  }
  // Contact planes stay where they were at the refresh; a ball that has rolled off by its radius has left them.
  if (method == "frozen" && m.drag * refresh > std::max(radius, 1e-9))
    return Prediction{"friction", Finding{told("local.method frozen: the tool drags ", 1e3 * m.drag * refresh,
                                               " mm from refresh to refresh, more than its radius of ", 1e3 * radius,
                                               " mm, and sinks in"),
                                          {set_to("local.method", "multirate"), advise("raise global.rate_hz")}}
                                      .at("local.method", m.drag * refresh, radius)};
  return {};
}

void predict_contact_method(const BuiltScene& built, std::vector<Prediction>& out) {
  const std::string& method = built.scene().local.method;
  if (method != "penalty" && method != "frozen" && method != "legacy") return;
  const auto meeting = find_meeting(built);
  if (!meeting) return;
  if (auto p = predict_tunnelling(built.scene(), *meeting)) out.push_back(std::move(*p));
  if (auto p = predict_chatter(built.scene(), *meeting)) out.push_back(std::move(*p));
}

}  // namespace kt
