#include "haptics/refresh/look_ahead.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "collision/shape/closest_point.hpp"
#include "core/base/ticks.hpp"
#include "core/body/near_triangles.hpp"
#include "core/body/node_weights.hpp"
#include "haptics/touched/contact_length.hpp"

namespace kt {

namespace {

Vec3 force_on_body(const ContactHold& hold) { return hold.friction - hold.force * hold.normal; }

/// One hold of a tool's contacts on refined cells, or of a section of them: of their mean by normal force, which yields
/// as they do together. Its force is the resultant's along the mean normal: on a ball that is pressed in, the normals
/// spread, and how far the mean sinks depends on all of the forces.
/// @param all      contacts of the tool      @param at  of each
/// @param section  in it: indices
ContactHold mean_hold(std::span<const ContactHold> all, std::span<const ContactNodes::OnFine> at,
                      std::span<const std::size_t> section) {
  ContactHold out;
  double sum_of_forces = 0, sticking = 0;
  Vec3 normal = Vec3::Zero(), total = Vec3::Zero(), sunk = Vec3::Zero();
  for (const std::size_t i : section) {
    const ContactHold& hold = all[i];
    const double force = std::max(hold.force, 0.0);
    sum_of_forces += force;
    normal += force * hold.normal;
    total += force_on_body(hold);
    if (hold.sticks) sticking += force;
  }
  out.normal = normal.normalized();
  out.force = -out.normal.dot(total);
  out.friction = total + out.force * out.normal;
  out.sticks = 2 * sticking > sum_of_forces;
  std::vector<NodeWeights> yields;
  std::vector<double> share;
  std::map<int, double> moves;
  share.assign(all.size(), 0);
  for (const std::size_t i : section) {
    share[i] = std::max(all[i].force, 0.0) / sum_of_forces;
    out.point += share[i] * all[i].point;
    for (int k = 0; k < all[i].moves.count; ++k)
      moves[all[i].moves.node[static_cast<std::size_t>(k)]] +=
          share[i] * all[i].moves.weight[static_cast<std::size_t>(k)];
  }
  for (const ContactNodes::OnFine& fine : at)
    yields.push_back(fine.patch ? fine.patch->yields_with(fine.facet, fine.bary) : NodeWeights());
  std::vector<std::pair<int, double>> heaviest(moves.begin(), moves.end());
  constexpr std::size_t kHeaviest = 32;
  if (heaviest.size() > kHeaviest) {
    std::ranges::stable_sort(heaviest, std::ranges::greater{}, &std::pair<int, double>::second);
    heaviest.resize(kHeaviest);
  }
  double sum = 0;
  for (const auto& [node, weight] : heaviest) sum += weight;
  for (const auto& [node, weight] : heaviest) out.moves.add(node, weight / sum);
  for (const std::size_t i : section)
    for (std::size_t j = 0; j < all.size(); ++j) {
      if (!at[i].patch || at[i].patch != at[j].patch) continue;
      const NodeWeights &a = yields[i], &b = yields[j];
      Mat3 response = Mat3::Zero();
      for (int k = 0; k < a.count; ++k)
        for (int l = 0; l < b.count; ++l)
          response += a.weight[static_cast<std::size_t>(k)] * b.weight[static_cast<std::size_t>(l)] *
                      at[i].patch->R.block<3, 3>(3 * a.node[static_cast<std::size_t>(k)],
                                                 3 * b.node[static_cast<std::size_t>(l)]);
      out.yields += share[i] * share[j] * response;
      sunk += share[i] * (response * force_on_body(all[j]));
    }
  // Along the normal as under all of the forces, and still positive semidefinite.
  const Vec3& n = out.normal;
  const double along = -n.dot(sunk) / out.force, mean = n.dot(out.yields * n);
  if (out.force > 0 && along > 0 && mean > 0) {
    const Mat3 scale = Mat3::Identity() + (std::sqrt(along / mean) - 1) * n * n.transpose();
    out.yields = (scale * out.yields * scale).eval();
  }
  return out;
}

/// Contacts of a tool that are held together: all of a round contact, and of a long one those beside one another, since
/// the body may bend along it.
std::vector<std::vector<std::size_t>> sections_of(std::span<const ContactHold> holds,
                                                  const std::optional<ContactLength>& length) {
  constexpr double kSection = 2;  // times its width
  constexpr int kMost = 4;
  const int count =
      length
          ? std::clamp(static_cast<int>(std::lround(length->half_length / (kSection * length->half_width))), 2, kMost)
          : 1;
  std::vector<std::vector<std::size_t>> out(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < holds.size(); ++i) {
    const double s = length ? (holds[i].point - length->middle).dot(length->along) / length->half_length : 0;
    out[static_cast<std::size_t>(std::clamp(static_cast<int>(0.5 * (s + 1) * count), 0, count - 1))].push_back(i);
  }
  return out;
}

/// No: the tool is pressed from both sides there.
bool is_one_sided(std::span<const ContactHold> holds, std::span<const std::size_t> section) {
  constexpr double kOneSide = 0.1;  // of the sum of the forces
  double sum = 0;
  Vec3 resultant = Vec3::Zero();
  for (const std::size_t i : section) {
    sum += std::max(holds[i].force, 0.0);
    resultant += std::max(holds[i].force, 0.0) * holds[i].normal;
  }
  return resultant.norm() > kOneSide * sum;
}

}  // namespace

std::vector<ContactHold> last_holds(std::span<const LocalReport> reports, const ContactNodes& nodes, double rate_hz,
                                    const ToolShape& shape, int tool) {
  std::vector<ContactHold> out;
  if (reports.empty()) return out;
  const LocalReport& last = reports.back();
  std::vector<ContactNodes::OnFine> fine;
  for (const TickContact& s : last.contacts()) {
    if (s.tool != tool) continue;
    const Vec3 force = rate_hz * s.impulse;
    const double along = s.normal.dot(force);
    out.push_back({.moves = nodes.moved_by(last.model_frame, s),
                   .normal = s.normal,
                   .point = s.point - nodes.offset(last.model_frame, s),
                   .sticks = s.sticks,
                   .force = -along,
                   .friction = force - along * s.normal});
    fine.push_back(nodes.on_fine(last.model_frame, s));
  }
  if (std::ranges::none_of(fine, [](const auto& at) { return at.patch != nullptr; })) return out;
  std::vector<ContactHold> means;
  for (const std::vector<std::size_t>& section : sections_of(
           out, contact_length(shape, last.tools[static_cast<std::size_t>(tool)].pose.r, last.contacts(), tool))) {
    if (is_one_sided(out, section))
      means.push_back(mean_hold(out, fine, section));
    else
      for (const std::size_t i : section) means.push_back(out[i]);
  }
  return means;
}

LastContacts last_contacts(std::span<const LocalReport> reports, const ContactNodes& nodes, double rate_hz,
                           std::span<const TouchTool> tools, bool are_refined) {
  LastContacts out;
  std::array<std::vector<ContactHold>, kMaxTools> means{};  // of several contacts each: held alike
  for (int k = 0; k < static_cast<int>(tools.size()); ++k) {
    const auto tool = static_cast<std::size_t>(k);
    std::vector<ContactHold> own = last_holds(reports, nodes, rate_hz, tools[tool].shape, k);
    const bool is_merged =
        own.size() == 1 ||
        (!own.empty() && std::ranges::count(reports.back().contacts(), k, &TickContact::tool) > std::ssize(own));
    if (are_refined && is_merged) means[tool] = own;
    std::ranges::move(own, std::back_inserter(out.holds));
  }
  for (const LocalReport& report : reports)
    for (const TickContact& c : report.contacts()) {
      const std::vector<ContactHold>& own = means[static_cast<std::size_t>(c.tool)];
      const auto hold = std::ranges::min_element(
          own, {}, [&](const ContactHold& mean) { return (mean.point - c.point).squaredNorm(); });
      const bool is_held = hold != own.end();
      out.history.push_back({c.t, nodes.moved_by(report.model_frame, c), c.impulse, is_held ? hold->normal : c.normal,
                             c.sticks && !(is_held && !hold->sticks)});
    }
  return out;
}

Vec3 tool_velocity(std::span<const LocalReport> reports, double rate_hz, int tool) {
  if (reports.size() < 2) return Vec3::Zero();
  const std::size_t ticks = std::min<std::size_t>(reports.size() - 1, ticks_in(kVelocityTime, rate_hz));
  const LocalReport& before = reports[reports.size() - 1 - ticks];
  const Vec3 way = reports.back().tools[tool].pose.x - before.tools[tool].pose.x;
  return rate_hz / static_cast<double>(std::max(1, reports.back().tick - before.tick)) *
         way;  // some between may be lost
}

Vec3 expected_way(const Vec3& velocity, const Vec3& came, double seconds) {
  const Vec3 way = seconds * velocity;
  const double size_sq = way.squaredNorm();
  return size_sq > 0 ? Vec3(std::clamp(came.dot(way) / size_sq, 0.0, 1.0) * way) : way;
}

Vec3 along_surface(const Vec3& way, std::span<const ContactHold> holds) {
  Vec3 normal = Vec3::Zero();
  for (const ContactHold& hold : holds) normal += std::max(hold.force, 0.0) * hold.normal;
  const double size = normal.norm();
  return size > 0 ? Vec3(way - way.dot(normal) / (size * size) * normal) : way;
}

void PastPlaces::add(double t, std::span<const Pose> tools) {
  constexpr double kKept = 1;  // [s]
  Place& now = places_.emplace_back(t);
  for (std::size_t k = 0; k < tools.size(); ++k) now.x[k] = tools[k].x;
  while (places_.size() > 2 && places_[1].t < t - kKept) places_.pop_front();
}

Vec3 PastPlaces::came(int tool, double seconds) const {
  if (places_.empty()) return Vec3::Zero();
  const auto k = static_cast<std::size_t>(tool);
  const Place& now = places_.back();
  const double t = now.t - seconds;
  const auto after = std::ranges::lower_bound(places_, t, {}, &Place::t);
  if (after == places_.begin()) return now.x[k] - places_.front().x[k];
  if (after == places_.end()) return Vec3::Zero();
  const Place& before = *std::prev(after);
  const double share = (t - before.t) / (after->t - before.t);
  return now.x[k] - (before.x[k] + share * (after->x[k] - before.x[k]));
}

std::vector<ContactHold> moved_holds(std::vector<ContactHold> holds, const Surface& surface, const Smoothing& smoothing,
                                     const VectorX& rest, const Vec3& step) {
  for (ContactHold& hold : holds) {
    hold.point += step;
    if (hold.sticks) {
      hold.friction.setZero();
      continue;
    }
    const Vec3 place = hold.moves.of(rest) + step;
    int triangle = -1;
    Vec3 bary;
    double nearest = std::numeric_limits<double>::infinity();
    for_each_near(surface, rest, place, nearest, [&](int i) {
      const Triangle& t = surface.triangles[i];
      const Vec3 a = node(rest, t[0]), b = node(rest, t[1]), c = node(rest, t[2]);
      if ((b - a).cross(c - a).dot(hold.normal) <= 0) return;  // the other side of a thin body
      const ClosestPoint at = closest_point_on_triangle(place, a, b, c);
      if (at.distance_sq >= nearest) return;
      nearest = at.distance_sq;
      triangle = i;
      bary = at.bary;
    });
    if (triangle >= 0) hold.moves = moved_by(surface, smoothing, triangle, bary);
  }
  return holds;
}

}  // namespace kt
