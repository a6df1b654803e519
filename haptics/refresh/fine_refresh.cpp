#include "haptics/refresh/fine_refresh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/shape/closest_point.hpp"
#include "collision/shape/tool_shape.hpp"
#include "core/base/stages.hpp"
#include "haptics/cost/expected_touch.hpp"

namespace kt {
namespace {

constexpr double kStrain = 0.03;      // that counts
constexpr double kMostStrain = 0.08;  // that cannot wait for a refresh
constexpr double kApart = 0.6;        // contact radii: places along a way

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

}  // namespace

FineRefresh::FineRefresh(const DeformableModel& model, const Surface& surface, const LocalSettings& local)
    : surface_(surface),
      refinable_(make_refinable_body(model, surface)),
      fineness_(local.fineness),
      most_nodes_(local.refine_nodes),
      solver_(make_block_solver()) {}

FineRefresh::Wanted FineRefresh::wanted(const VectorX& x, std::span<const int> patch, std::span<const TouchTool> tools,
                                        std::span<const SeenTool> places) const {
  Wanted out;
  for (std::size_t k = 0; k < tools.size(); ++k) {
    const SeenTool& tool = places[k];
    const ToolShape& shape = tools[k].shape;
    const Vec3 way = tool.time * tool.velocity;
    const double expected = expected_contact_radius(shape);
    double own = std::max(tool.contact_radius, expected);
    Vec3 from;
    out.touches = out.touches || tool.touched.has_value();
    if (tool.touched) {
      own = pressed_radius(shape, own, -way.dot(tool.normal));
      from = *tool.touched;
    } else {
      const NearestPlace nearest = nearest_place(surface_, x, body_.mesh->x, patch, tool.core, 0.5 * way);
      const double gap = std::max(0.0, nearest.apart.norm() - shape.radius);
      own = std::max(own, pressed_radius(shape, 0, -way.dot(nearest.apart.normalized()) - gap));
      from = nearest.at_rest - 0.5 * way;
    }
    if (way.norm() > kLeastTravel * own) out.late = std::max(out.late, tool.late);
    out.contact_radius = std::max(out.contact_radius, own);
    out.ways.push_back({from, from + way});
  }
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
  return zone_ && wanted.touches ? std::max(wanted.contact_radius, kShrinks * zone_->contact.contact_radius)
                                 : wanted.contact_radius;
}

/// Cells that may be this large, in contact radii: there is less than half the room for the contacts of each of two.
double FineRefresh::largest_fineness(std::size_t tools) const {
  constexpr double kOfTwo = 1.4;
  return (tools > 1 ? kOfTwo : 1) * std::max(kLeastFineness, fineness_);
}

/// The zone that is there is large and fine enough for it: the contacts stay within its travel.
bool FineRefresh::serves(const Wanted& wanted) const {
  constexpr double kGrown = 1.15, kShrunk = 0.6, kShrunkFewer = 0.85, kShorter = 3;
  constexpr double kWithin = 0.75;  // of the travel: a contact that has grown reaches further
  if (!zone_) return false;
  const FineContact& has = zone_->contact;
  const bool is_capped = zone_->zone.edge > zone_->options.size.edge;  // a smaller one may have smaller cells
  const double grown = wanted.contact_radius / has.contact_radius;
  if (grown > kGrown || grown < (is_capped ? kShrunkFewer : kShrunk) || zone_->ways.size() != wanted.ways.size())
    return false;
  const double most = largest_fineness(wanted.ways.size()) * wanted.contact_radius;
  const bool stays_now = longest(zone_->ways) > kShorter * longest(wanted.ways) + has.travel;
  if (is_capped && ((zone_->late > 1 && wanted.late <= 1) || stays_now))
    return false;  // it moved on and now stays: as small as they get
  if (!is_capped && zone_->zone.largest > (1 + 1e-6) * most) return false;
  bool stays = true;
  for (std::size_t k = 0; k < wanted.ways.size(); ++k) {
    const Way &its = wanted.ways[k], &way = zone_->ways[k];
    stays = stays && std::max(way.distance(its.from), way.distance(its.to)) <= kWithin * has.travel;
  }
  return stays;
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

/// Around the ways of the tools, and half as far again, so that it serves for longer. The later models come under a
/// tool that moves, the fewer nodes: large cells are off by less than no refined ones under a tool that has moved on.
void FineRefresh::make_zone(const Wanted& wanted) {
  constexpr double kMargin = 1.5, kLeastNodes = 150;
  const std::size_t tools = wanted.ways.size();
  const double most = largest_fineness(tools), least = most / largest_fineness(1) * kLeastFineness;
  FineContact contact{.contact_radius = ahead_radius(wanted)};
  contact.travel = kLeastTravel * contact.contact_radius;
  std::vector<Way> ways;
  std::vector<Vec3> places;
  for (const Way& way : wanted.ways) {
    const double apart = kApart * contact.contact_radius, length = (way.to - way.from).norm();
    const double far = std::min(kMargin * length, (kPlacesOfWay - 1) * apart);
    const Vec3 to = length > 0 ? Vec3(way.from + far / length * (way.to - way.from)) : way.from;
    ways.push_back({way.from, to});
    const int count = static_cast<int>(std::ceil(far / apart));
    for (int i = 0; i <= count; ++i) places.push_back(way.from + i / std::max(1.0, 1.0 * count) * (to - way.from));
  }
  contact.centre = places.front();
  contact.others.assign(places.begin() + 1, places.end());
  FineZoneOptions options = fine_options(body_, contact, most);
  const double cell = cell_size_at(body_, contact.centre);
  options.size.edge = sized_ = cell_size(least * contact.contact_radius, most * contact.contact_radius, cell);
  const double nodes = std::max(std::min<double>(most_nodes_, kLeastNodes), most_nodes_ / wanted.late);
  options.most_nodes = static_cast<int>(nodes) * static_cast<int>(tools);
  zone_ = Zone{make_fine_zone(body_, options), options, contact, std::move(ways), {}, cell, wanted.late};
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
  if (!patch_ || !serves(wanted(all_x, patch, tools, places))) return Due::now;
  const double bent = bend(tangent.state.x);
  if (!(bent <= kMostStrain)) return Due::now;
  if (bent > kStrain || kind_ != kind || !serves(wanted(all_x, patch, tools, later))) return Due::next;
  return Due::not_yet;
}

std::shared_ptr<const FinePatch> FineRefresh::find(const TangentModel& tangent, TangentKind kind, const VectorX& all_x,
                                                   std::span<const int> patch, std::span<const TouchTool> tools,
                                                   std::span<const SeenTool> places) {
  const VectorX& x = tangent.state.x;
  if (const Wanted now = wanted(all_x, patch, tools, places); !serves(now)) make_zone(now);
  if (zone_->zone.num_yielding == 0) return nullptr;
  if (patch_ && kind_ == kind && bend(x) <= kStrain) return patch_;
  const FineState state{tangent.state, kind};
  const auto made = make_fine_patch(body_, zone_->zone, surface_.triangles,
                                    find_yield(body_, zone_->zone, state, tangent.dfdx, *solver_));
  FineOrigin origin = fine_origin(body_, zone_->zone, zone_->options, state);
  made->fineness = origin.fineness = zone_->zone.largest / zone_->contact.contact_radius;
  made->origin = std::make_shared<const FineOrigin>(std::move(origin));
  patch_ = made;
  x_ = x;
  kind_ = kind;
  return patch_;
}

}  // namespace kt
