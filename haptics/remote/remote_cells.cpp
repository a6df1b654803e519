#include "haptics/remote/remote_cells.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/body/tangent_model.hpp"
#include "core/fine/fine_size.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {
namespace {

constexpr double kFarthest = 1e6;     // [m] or [m/s]
constexpr double kMostLeaves = 2e5;   // of the finest size
constexpr double kMostReach = 2;      // times the place of the finest cells, fine_options()
constexpr double kLeastSlope = 0.25;  // of sizes over the distance: leaves away from the tool are few

bool is_within(const VectorX& v) {
  return std::ranges::all_of(v, [](double x) { return std::abs(x) <= kFarthest; });  // NaN is not
}
bool is_length(double v) { return v >= 0 && v <= kFarthest; }

bool is_same(const FineOrigin& a, const FineOrigin& b) {
  return a.options == b.options && a.kind == b.kind && a.fineness == b.fineness && a.x.size() == b.x.size() &&
         a.x == b.x && a.v == b.v;
}

}  // namespace

RemoteCells::RemoteCells(const DeformableModel& model, const Surface& surface, int nodes,
                         const std::string& contact_surface)
    : model_(model),
      surface_(surface),
      nodes_(nodes),
      refinable_(make_refinable_body(model, surface)),
      solver_(make_block_solver()) {
  if (contact_surface != "flat") smooth_.emplace(surface, model.mesh().x);
}

std::string RemoteCells::trouble(const FineOrigin& origin) const {
  const FineZoneOptions& o = origin.options;
  const auto is_place = [](const Vec3& v) { return is_within(v); };
  if (o.others.size() >= static_cast<std::size_t>(kMaxTools * kPlacesOfTool))
    return "refined cells: there are too many places";
  if (!is_place(o.centre) || !std::ranges::all_of(o.others, is_place) || !is_length(o.radius) || !is_length(o.reach) ||
      !is_length(o.size.flat) || !is_length(o.size.least_flat) || !(o.size.edge > 0 && o.size.edge <= kFarthest) ||
      o.reach > kMostReach * o.size.flat || !(o.size.flat > 0) || !is_length(o.apart) ||
      (body_.mesh->embedded && !(o.apart > 0)) || !(o.size.slope >= kLeastSlope && o.size.slope <= kFarthest) ||
      !is_length(origin.fineness))
    return "refined cells: a length is wrong";
  const double places = 1 + static_cast<double>(o.others.size());
  const double leaves = 5 * places * std::pow(1 + o.size.flat / o.size.edge, 3);
  if (!(leaves <= kMostLeaves) || o.most_nodes < 1 || o.most_nodes > nodes_ * kMaxTools)
    return "refined cells: they are too small";
  if (origin.x.size() != origin.v.size() || !is_within(origin.x) || !is_within(origin.v))
    return "refined cells: a node's place is wrong";
  return "";
}

std::shared_ptr<const FinePatch> RemoteCells::find(const std::shared_ptr<const FineOrigin>& origin) {
  if (patch_ && is_same(*patch_->origin, *origin)) return patch_;
  if (!patch_ || !(patch_->origin->options == origin->options)) zone_ = make_fine_zone(body_, origin->options);
  patch_.reset();
  const std::vector<int> nodes = zone_nodes(body_, zone_);
  if (zone_.num_yielding == 0 || origin->x.size() != 3 * static_cast<Eigen::Index>(nodes.size()))
    throw RunError("refined cells: they do not fit the body");
  State state{0, model_.mesh().x, VectorX::Zero(model_.mesh().x.size())};
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) {
    node(state.x, nodes[i]) = node(origin->x, i);
    node(state.v, nodes[i]) = node(origin->v, i);
  }
  // What the zone's inner nodes answer is of its cells alone: the rest of the body may be anywhere.
  const State own = own_part(model_, state);
  TangentModel tangent;
  linearize(model_.own(), own, origin->kind, tangent);
  const auto made = make_fine_patch(body_, zone_, surface_.triangles,
                                    find_yield(body_, zone_, {own, origin->kind}, tangent.dfdx, *solver_));
  made->fineness = origin->fineness;
  made->origin = origin;
  if (smooth_) smooth_->raise(*made);
  patch_ = made;
  return patch_;
}

}  // namespace kt
