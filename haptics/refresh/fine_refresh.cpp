#include "haptics/refresh/fine_refresh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "collision/held/surface_contacts.hpp"
#include "collision/shape/closest_point.hpp"
#include "collision/shape/tool_shape.hpp"
#include "core/base/stages.hpp"
#include "haptics/cost/expected_touch.hpp"
#include "haptics/touched/contact_length.hpp"

namespace kt {
namespace {

constexpr double kStrain = 0.03;      // that counts
constexpr double kMostStrain = 0.08;  // that cannot wait for a refresh
constexpr double kApart = 0.6;        // contact radii: places along a way
constexpr double kAlong = 1.2;        // contact radii: ways along a contact that is long
constexpr double kGrown = 1.15;       // a contact that has, needs another zone
constexpr int kMostAlong = 8;         // of these
constexpr double kKeptTravel = 1;     // contact radii: of a zone that stays where it is
constexpr double kMostAreas = 3;      // of a round contact: more are no reason for larger cells

/// Where a tool is nearest to the patch.
struct NearestPlace {
  Vec3 at_rest = Vec3::Zero();  ///< of the body at rest [m]
  Vec3 apart = Vec3::Zero();    ///< from the body as it is to the tool [m]
};

/// @param core  points of the tool, a radius within its surface
/// @param way   of all of them before
NearestPlace nearest_place(const Surface& surface, const VectorX& x, const VectorX& rest, std::span<const int> patch,
                           std::span<const Vec3> core, const Vec3& way) {
  double nearest_sq = std::numeric_limits<double>::infinity();
  NearestPlace out;
  for (const int t : patch) {
    const Triangle& v = surface.triangles[t];
    for (const Vec3& point : core) {
      const Vec3 place = point + way;
      const ClosestPoint at = closest_point_on_triangle(place, node(x, v[0]), node(x, v[1]), node(x, v[2]));
      if (at.distance_sq >= nearest_sq) continue;
      nearest_sq = at.distance_sq;
      out = {at.bary[0] * node(rest, v[0]) + at.bary[1] * node(rest, v[1]) + at.bary[2] * node(rest, v[2]),
             place - at.point};
    }
  }
  return out;
}

bool shape_is_long(const ToolShape& shape) { return shape.kind == ToolShape::Kind::capsule; }

/// A tool's contact until the next local model is there, on the body at rest.
struct ContactAhead {
  double radius = 0;  ///< half the width of one that is long [m]
  Vec3 middle = Vec3::Zero();
  Vec3 half_length = Vec3::Zero();  ///< from its middle to its end; zero: it is round
};

/// @param was_long  the zone that is there goes along it
ContactAhead touched_ahead(const ToolShape& shape, const SeenTool& tool, bool was_long) {
  const double width = std::max(tool.half_width, expected_contact_radius(shape));
  const bool is_long = tool.half_length.norm() > (was_long ? kStaysLong : kLong) * width;
  const double now = is_long ? width : std::max(tool.contact_radius, expected_contact_radius(shape));
  const double then = pressed_radius(shape, now, -tool.time * tool.velocity.dot(tool.normal));
  if (!is_long) return {then, *tool.touched, Vec3::Zero()};
  return {std::min(then, shape.radius), *tool.touched, tool.half_length};
}

/// Where it will touch. A tool that comes nearer may come faster than it is now: a model that is used some 0.08 s after
/// that was seen had cells for the first tenths of a millimetre. A capsule lies where both its ends are as near as a
/// contact is deep.
ContactAhead next_contact(const Surface& surface, const VectorX& x, const VectorX& rest, std::span<const int> patch,
                          const ToolShape& shape, const SeenTool& tool) {
  const Vec3 way = tool.time * tool.velocity;
  const auto nearest_to = [&](std::span<const Vec3> core) {
    return nearest_place(surface, x, rest, patch, core, 0.5 * way);
  };
  const NearestPlace nearest = nearest_to(tool.core);
  const double gap = std::max(0.0, nearest.apart.norm() - shape.radius);
  const double nearer = -way.dot(nearest.apart.normalized());
  const double faster = nearer > 0 ? 0.5 * tool.acceleration * tool.time * tool.time : 0;
  ContactAhead out{std::max(expected_contact_radius(shape), pressed_radius(shape, 0, nearer + faster - gap)),
                   nearest.at_rest - 0.5 * way};
  if (!shape_is_long(shape)) return out;
  const NearestPlace a = nearest_to({tool.core.data(), 1}), b = nearest_to({tool.core.data() + 1, 1});
  const double depth = out.radius * out.radius / shape.radius;
  if (std::abs(a.apart.norm() - b.apart.norm()) > depth) return out;
  out.middle = 0.5 * (a.at_rest + b.at_rest) - 0.5 * way;
  out.half_length = 0.5 * (b.at_rest - a.at_rest);
  out.radius = std::min(out.radius, shape.radius);
  return out;
}

}  // namespace

FineRefresh::FineRefresh(const DeformableModel& model, const Surface& surface, const LocalSettings& local,
                         const std::string& contact_surface)
    : surface_(surface),
      refinable_(make_refinable_body(model, surface)),
      fineness_(local.fineness),
      most_nodes_(local.refine_nodes),
      stays_(local.refine == "set-up"),
      may_be_wide_(model.info().type != "msd" && !surface.embedded),
      solver_(make_block_solver()) {
  if (contact_surface != "flat") smooth_.emplace(surface, model.mesh().x);
}

FineRefresh::Wanted FineRefresh::wanted(const VectorX& x, std::span<const int> patch, std::span<const TouchTool> tools,
                                        std::span<const SeenTool> places) const {
  Wanted out;
  double area = 0;  // of all contacts [m^2]
  for (std::size_t k = 0; k < tools.size(); ++k) {
    const SeenTool& tool = places[k];
    const Vec3 way = tool.time * tool.velocity;
    out.touches = out.touches || tool.touched.has_value();
    out.all_touch = out.all_touch && tool.touched.has_value();
    if (tools[k].shape.radius > 0) out.tool_radius = std::min(out.tool_radius, tools[k].shape.radius);
    const ContactAhead contact = tool.touched ? touched_ahead(tools[k].shape, tool, zone_ && zone_->is_long)
                                              : next_contact(surface_, x, body_.mesh->x, patch, tools[k].shape, tool);
    const double moves = std::min(1.0, way.norm() / (0.5 * kLeastTravel * contact.radius));
    out.late = std::max(out.late, 1 + moves * (tool.late - 1));
    out.contact_radius = std::max(out.contact_radius, contact.radius);
    const double length = contact.half_length.norm();
    const bool had_no_room = zone_ && !zone_->has_room && shape_is_long(tools[k].shape) && tool.touched;
    if (length > 0 || had_no_room) {
      out.is_long = true;
      out.whole_area = std::max(out.whole_area, 4 * tool_reach(tools[k].shape) * tools[k].shape.radius);
      out.whole_width = std::max(out.whole_width, tools[k].shape.radius);
    }
    area += contact.radius * (std::numbers::pi * contact.radius + 4 * length);
    const int count = std::min(kMostAlong, 1 + static_cast<int>(std::ceil(2 * length / (kAlong * contact.radius))));
    for (int i = 0; i < count; ++i) {
      const Vec3 from = count > 1 ? contact.middle + (2.0 * i / (count - 1) - 1) * contact.half_length : contact.middle;
      out.ways.push_back({from, from + way});
    }
  }
  out.areas = area / (std::numbers::pi * out.contact_radius * out.contact_radius);
  return out;
}

double FineRefresh::Way::distance(const Vec3& place) const {
  const Vec3 along = to - from;
  const double length_sq = along.squaredNorm();
  const double share = length_sq > 0 ? std::clamp((place - from).dot(along) / length_sq, 0.0, 1.0) : 0;
  return (place - from - share * along).norm();
}

double FineRefresh::longest(std::span<const Way> ways) {
  double out = 0;
  for (const Way& way : ways) out = std::max(out, (way.to - way.from).norm());
  return out;
}

/// A contact that jumps between two places, or at the rim of a zone, has one radius now and another one next: zones
/// shrink by steps.
double FineRefresh::ahead_radius(const Wanted& wanted) const {
  constexpr double kShrinks = 0.85;
  return zone_ && wanted.touches && wanted.is_long == zone_->is_long
             ? std::max(wanted.contact_radius, kShrinks * zone_->contact.contact_radius)
             : wanted.contact_radius;
}

/// Cells that may be this large, in contact radii: a tick has room for the places of one round contact, which two
/// tools share, and a long one; but between nodes further apart than it is wide a tool sinks in.
double FineRefresh::largest_fineness(double areas) const {
  return std::sqrt(std::clamp(areas, 1.0, kMostAreas)) * std::max(kLeastFineness, fineness_);
}

/// The zone that is there is large and fine enough for it: the contacts stay within its travel.
bool FineRefresh::serves(const Wanted& wanted) const {
  constexpr double kShrunk = 0.6, kShrunkFewer = 0.85, kShorter = 3;
  constexpr double kWithin = 0.75;  // of the travel: a contact that has grown reaches further
  constexpr double kLess = 0.5;     // of the lateness that a zone was made for
  if (!zone_) return false;
  const FineContact& has = zone_->contact;
  const bool is_capped = zone_->zone.edge > zone_->options.size.edge;  // a smaller one may have smaller cells
  const double grown = wanted.contact_radius / has.contact_radius;
  if (grown > kGrown || grown < (is_capped ? kShrunkFewer : kShrunk)) return false;
  const double most = largest_fineness(wanted.areas) * wanted.contact_radius;
  const bool stays_now = longest(zone_->ways) > kShorter * longest(wanted.ways) + has.travel;
  const bool is_in_time = wanted.late < 1 + kLess * (zone_->late - 1);
  // It moved on and now stays: cells as small as they get, in a zone as wide as it gets.
  if ((is_capped || zone_->may_widen) && (is_in_time || stays_now)) return false;
  if (!is_capped && zone_->zone.largest > (1 + 1e-6) * most) return false;
  const double within = kWithin * has.travel;
  return std::ranges::all_of(wanted.ways, [&](const Way& its) {
    return std::ranges::any_of(
        zone_->ways, [&](const Way& way) { return std::max(way.distance(its.from), way.distance(its.to)) <= within; });
  });
}

/// Of local.refine set-up: where all tools have touched the zone stays, but for contacts there that have grown.
bool FineRefresh::is_kept(const Wanted& wanted) const {
  if (!stays_ || !patch_ || !zone_->is_touched) return false;
  const bool is_there = std::ranges::all_of(wanted.ways, [&](const Way& its) {
    return std::ranges::any_of(zone_->ways,
                               [&](const Way& way) { return way.distance(its.from) <= zone_->contact.travel; });
  });
  return !is_there || wanted.contact_radius <= kGrown * zone_->contact.contact_radius;
}

/// Of the largest refined cells under a tool, from `least` to `most`. Cells are halved: a size that follows each
/// measured radius would jump to and fro between two halvings, since it is measured larger on small cells than on large
/// ones. Small cells stay where they may be that small, nearly.
double FineRefresh::cell_size(double least, double most, double cell) const {
  constexpr double kSmaller = 0.8;
  const double size = std::clamp(sized_, least, most);
  const auto halvings = [&](double to) { return std::ceil(std::log2(cell / to) - 1e-9); };
  const bool stays_small = zone_ && size > sized_ && sized_ >= kSmaller * least && halvings(size) < halvings(sized_);
  return stays_small ? sized_ : size;
}

/// A tick holds all places of a long contact, even of a tool that is pressed in by its radius. Of a contact that is
/// held in part the rest sinks in, another part from tick to tick.
bool FineRefresh::has_room(const Wanted& wanted, double cell, std::size_t tools) const {
  constexpr double kAdded = 4;  // of a tool's share, kept for places that are pushed at
  if (!(wanted.whole_area > 0)) return true;
  const double most = largest_fineness(kMostAreas) * wanted.whole_width;
  const double spacing = 0.5 * cell * std::exp2(-std::max(0.0, std::ceil(std::log2(cell / most))));
  return wanted.whole_area <= (kMaxContacts / static_cast<double>(tools) - kAdded) * spacing * spacing;
}

/// As wide as there are nodes for; empty: no wider than the options say. A wider zone makes springs, which are too
/// soft, softer still, and does not change the force on a lattice.
FineZone FineRefresh::make_wide_zone(double widest, FineZoneOptions& options) const {
  for (const double share : {1.0, 0.5}) {
    FineZoneOptions wide = options;
    wide.radius = std::lerp(options.radius, widest, share);
    if (wide.radius <= options.radius) return {};
    FineZone out = make_fine_zone_of_size(body_, wide);
    if (out.cells.empty()) continue;
    options = wide;
    return out;
  }
  return {};
}

/// Around the ways of the tools, and half as far again, so that it serves for longer. The later models come under a
/// tool that moves, the fewer nodes: large cells are off by less than no refined ones under a tool that has moved on.
void FineRefresh::make_zone(Wanted wanted, std::size_t tools) {
  constexpr double kMargin = 1.5, kLeastNodes = 150;
  constexpr double kLongRoom = 0.85;  // of what a long contact asks for: cells beyond that are told as too large
  if (stays_ && zone_ && zone_->is_touched && zone_->ways.size() == wanted.ways.size()) wanted.ways = zone_->ways;
  const double most = largest_fineness(wanted.areas), least = most / largest_fineness(1) * kLeastFineness;
  FineContact contact{.contact_radius = ahead_radius(wanted), .tool_radius = wanted.tool_radius};
  contact.travel = (stays_ ? kKeptTravel : kLeastTravel) * contact.contact_radius;
  std::vector<Way> ways;
  std::vector<Vec3> places;
  const bool is_long = wanted.ways.size() > tools;
  const double apart = (is_long ? kAlong : kApart) * contact.contact_radius;
  const std::size_t most_places = is_long ? tools * kPlacesOfTool / wanted.ways.size() : kPlacesOfWay;
  for (const Way& way : wanted.ways) {
    const double length = (way.to - way.from).norm();
    const double far = std::min(kMargin * length, (static_cast<double>(most_places) - 1) * apart);
    const Vec3 to = length > 0 ? Vec3(way.from + far / length * (way.to - way.from)) : way.from;
    ways.push_back({way.from, to});
    const int count = std::min(static_cast<int>(std::ceil(far / apart)), static_cast<int>(most_places) - 1);
    for (int i = 0; i <= count; ++i) places.push_back(way.from + i / std::max(1.0, 1.0 * count) * (to - way.from));
  }
  contact.centre = places.front();
  contact.others.assign(places.begin() + 1, places.end());
  FineZoneOptions options = fine_options(body_, contact, most);
  const double cell = cell_size_at(body_, contact.centre);
  options.size.edge = sized_ = cell_size(least * contact.contact_radius, most * contact.contact_radius, cell);
  const double late = stays_ ? 1 : wanted.late;  // one that stays is waited for once
  const double nodes = std::max(std::min<double>(most_nodes_, kLeastNodes), most_nodes_ / late);
  options.most_nodes = static_cast<int>(nodes) * static_cast<int>(tools);
  const bool fits = has_room(wanted, cell, tools);
  const double widest = may_be_wide_ ? wide_radius(body_, contact) : 0;
  FineZone zone;
  if (fits) zone = make_wide_zone(widest, options);
  if (fits && zone.cells.empty()) zone = make_fine_zone(body_, options);
  zone_ = Zone{std::move(zone), options, contact, std::move(ways), {}, cell, late};
  if (wanted.is_long) zone_->room = kLongRoom * most / largest_fineness(1);
  zone_->is_long = wanted.is_long;
  zone_->is_touched = wanted.all_touch;
  zone_->may_widen = options.radius < widest;
  zone_->has_room = fits;
  for (const int c : zone_->zone.cells) {
    const Tetrahedron& t = body_.mesh->tetrahedra[c];
    zone_->nodes.insert(zone_->nodes.end(), t.begin(), t.end());
  }
  std::ranges::sort(zone_->nodes);
  const auto [end, last] = std::ranges::unique(zone_->nodes);
  zone_->nodes.erase(end, last);
  patch_ = nullptr;
}

/// How much otherwise the zone's cells are strained than when they were looked at last: R follows by as much.
double FineRefresh::bend(const VectorX& x) const {
  Vec3 mean = Vec3::Zero();
  for (const int i : zone_->nodes) mean += node(x, i) - node(x_, i);
  mean /= static_cast<double>(zone_->nodes.size());
  double most = 0;
  for (const int i : zone_->nodes) most = std::max(most, (node(x, i) - node(x_, i) - mean).norm());
  return most / zone_->cell;
}

FineRefresh::Due FineRefresh::due(const TangentModel& tangent, TangentKind kind, const VectorX& all_x,
                                  std::span<const int> patch, std::span<const TouchTool> tools,
                                  std::span<const SeenTool> places, std::span<const SeenTool> later) const {
  const Wanted now = wanted(all_x, patch, tools, places);
  if (is_kept(now)) return Due::not_yet;
  if (!patch_ || !serves(now)) return Due::now;
  const double bent = bend(tangent.state.x);
  if (!(bent <= kMostStrain)) return Due::now;
  if (bent > kStrain || kind_ != kind || !serves(wanted(all_x, patch, tools, later))) return Due::next;
  return Due::not_yet;
}

std::shared_ptr<const FinePatch> FineRefresh::find(const TangentModel& tangent, TangentKind kind, const VectorX& all_x,
                                                   std::span<const int> patch, std::span<const TouchTool> tools,
                                                   std::span<const SeenTool> places) {
  const VectorX& x = tangent.state.x;
  const Wanted now = wanted(all_x, patch, tools, places);
  if (is_kept(now)) return patch_;
  if (!serves(now)) make_zone(now, tools.size());
  zone_->is_touched = zone_->is_touched || now.all_touch;
  if (zone_->zone.num_yielding == 0) return nullptr;
  if (patch_ && kind_ == kind && bend(x) <= kStrain) return patch_;
  const FineState state{tangent.state, kind};
  const auto made = make_fine_patch(body_, zone_->zone, surface_.triangles,
                                    find_yield(body_, zone_->zone, state, tangent.dfdx, *solver_));
  FineOrigin origin = fine_origin(body_, zone_->zone, zone_->options, state);
  made->fineness = origin.fineness = zone_->zone.largest / (zone_->room * zone_->contact.contact_radius);
  made->origin = std::make_shared<const FineOrigin>(std::move(origin));
  if (smooth_) smooth_->raise(*made);
  patch_ = made;
  x_ = x;
  kind_ = kind;
  return patch_;
}

}  // namespace kt
