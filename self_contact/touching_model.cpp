#include "self_contact/touching_model.hpp"

#include <limits>

#include "collision/held/pair_distance.hpp"
#include "collision/held/surface_motion.hpp"
#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr double kLeave = 0.9;      // of the way to the next contact: never all of it
constexpr double kParallel = 1e-3;  // sin^2 of the angle below which edges count less: their closest points jump there

double mean_edge(const SurfacePairs& pairs, const VectorX& x) {
  double sum = 0;
  for (const auto& [a, b] : pairs.edges()) sum += (node(x, a) - node(x, b)).norm();
  return sum / static_cast<double>(std::max<std::size_t>(1, pairs.edges().size()));
}

double surface_stiffness(const DeformableModel& model, const SurfacePairs& pairs) {
  const VectorX diagonal = model.tangent(rest_state(model), TangentKind::definite).dfdx.diagonal();
  double sum = 0;
  for (int i : pairs.vertices()) sum -= node(diagonal, i).sum() / 3;
  return sum / static_cast<double>(std::max<std::size_t>(1, pairs.vertices().size()));
}

/// Friction over slip: rises smoothly from 0 to 1 at slip 1.
double grip(double slip) { return slip < 1 ? slip * (2 - slip) : 1; }

}  // namespace

SelfContact::SelfContact(const DeformableModel& model, SelfContactOptions given)
    : options(std::move(given)), pairs(model.mesh().triangles, model.mesh().x, options.backend), rest(model.mesh().x) {
  if (!(options.mu >= 0) || !(options.creep > 0) || !(options.reach >= 0) || !(options.stiffness >= 0))
    throw InputError(text("self-contact: mu ", options.mu, ", reach ", options.reach, " m, stiffness ",
                          options.stiffness, " N/m must not be negative, creep ", options.creep, " m/s not zero"));
  if (options.reach == 0) options.reach = 0.02 * mean_edge(pairs, rest);
  if (options.stiffness == 0) options.stiffness = surface_stiffness(model, pairs);
  barrier = {options.reach, options.stiffness};
}

TouchingModel::TouchingModel(const DeformableModel& model, SelfContact& contact, const State& start, double dt)
    : WrappingModel(model), contact_(contact), x_start_(start.x), dt_(dt), slip_scale_(contact.options.creep * dt) {
  find_near(start.x);
  for (const Touch& touch : touches(start.x))
    if (contact_.options.mu > 0) rubs_.push_back({touch.nodes, touch.weight, touch.normal, -touch.slope});
}

std::vector<TouchingModel::Touch> TouchingModel::touches(const VectorX& x) const {
  std::vector<Touch> out;
  for (const SurfacePair& pair : candidates_) {
    const PairDistance apart = pair_distance(pair, x);
    if (apart.distance >= contact_.barrier.reach) continue;
    const double d = apart.distance;
    Touch touch{pair.nodes, apart.weight, apart.normal, contact_.barrier.slope(d), contact_.barrier.bend(d)};
    touch.distance = d;
    touch.energy = contact_.barrier.energy(d);
    touch.turn.fill(Vec3::Zero());
    if (pair.kind == SurfacePair::Kind::edge_edge) {
      const auto& n = pair.nodes;
      const Vec3 u = node(x, n[1]) - node(x, n[0]), v = node(x, n[3]) - node(x, n[2]), cross = u.cross(v);
      const double least = kParallel * (node(contact_.rest, n[1]) - node(contact_.rest, n[0])).squaredNorm() *
                           (node(contact_.rest, n[3]) - node(contact_.rest, n[2])).squaredNorm();
      const double angle = cross.squaredNorm() / least;
      if (angle < 1) {
        const double share = angle * (2 - angle), rise = 2 * (1 - angle) / least;
        const Vec3 by_u = touch.energy * rise * 2 * v.cross(cross), by_v = touch.energy * rise * 2 * cross.cross(u);
        touch.turn = {-by_u, by_u, -by_v, by_v};
        touch.slope *= share;
        touch.bend *= share;
        touch.energy *= share;
      }
    }
    out.push_back(touch);
  }
  return out;
}

/// Of the contact points since the start of the step, along the surface [m].
Vec3 TouchingModel::slip(const Rub& rub, const VectorX& x) const {
  Vec3 out = Vec3::Zero();
  for (int i = 0; i < 4; ++i) out += rub.weight[i] * (node(x, rub.nodes[i]) - node(x_start_, rub.nodes[i]));
  return out - rub.normal.dot(out) * rub.normal;
}

void TouchingModel::force(const State& state, VectorX& out) const {
  model_.force(state, out);
  for (const Touch& touch : touches(state.x))
    for (int i = 0; i < 4; ++i)
      node(out, touch.nodes[i]) -= touch.weight[i] * touch.slope * touch.normal + touch.turn[i];
  for (const Rub& rub : rubs_) {
    const Vec3 u = slip(rub, state.x);
    const double length = u.norm();
    if (length == 0) continue;
    const Vec3 pull = -contact_.options.mu * rub.normal_force * grip(length / slip_scale_) / length * u;
    for (int i = 0; i < 4; ++i) node(out, rub.nodes[i]) += rub.weight[i] * pull;
  }
}

void TouchingModel::update_tangent(const State& state, TangentKind kind, Tangent& out) const {
  model_.update_tangent(state, kind, own_);
  using Entries = std::vector<Eigen::Triplet<double>>;
  Entries springs, dampers;
  const auto add = [](Entries& to, const std::array<int, 4>& nodes, const std::array<double, 4>& weight,
                      const Mat3& k) {
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            to.emplace_back(3 * nodes[a] + r, 3 * nodes[b] + c, -weight[a] * weight[b] * k(r, c));
  };
  for (const Touch& touch : touches(state.x))
    add(springs, touch.nodes, touch.weight, touch.bend * touch.normal * touch.normal.transpose());
  for (const Rub& rub : rubs_) {
    const Vec3 u = slip(rub, state.x);
    const double length = u.norm(), y = length / slip_scale_, most = contact_.options.mu * rub.normal_force;
    const Mat3 plane = Mat3::Identity() - rub.normal * rub.normal.transpose();
    const double over_slip = most * (length > 0 ? grip(y) / length : 2 / slip_scale_);
    if (kind != TangentKind::exact && y < 1) {
      add(springs, rub.nodes, rub.weight, over_slip * plane);
    } else if (kind != TangentKind::exact) {
      add(dampers, rub.nodes, rub.weight, over_slip * dt_ * plane);
    } else {
      const Vec3 along = length > 0 ? Vec3(u / length) : Vec3(Vec3::Zero());
      const double rise = y < 1 ? 2 * (1 - y) / slip_scale_ : 0;
      add(springs, rub.nodes, rub.weight, over_slip * plane + (most * rise - over_slip) * along * along.transpose());
    }
  }
  const auto sum = [](const SparseMatrix& own, const Entries& entries) -> SparseMatrix {
    if (entries.empty()) return own;
    SparseMatrix extra(own.rows(), own.cols());
    extra.setFromTriplets(entries.begin(), entries.end());
    return own + extra;
  };
  out.dfdx = sum(own_.dfdx, springs);
  out.dfdv = sum(own_.dfdv, dampers);
}

void TouchingModel::find_near(const VectorX& x) const {
  candidates_ = contact_.pairs.find(x, x, contact_.options.reach);
}

double TouchingModel::free_share(const VectorX& x, const VectorX& dx) const {
  const VectorX x_end = x + dx;
  candidates_ = contact_.pairs.find(x, x_end, contact_.options.reach);
  return std::min(1.0, kLeave * first_meeting(candidates_, x, x_end));
}

SelfContactReport TouchingModel::report(const VectorX& x) const {
  find_near(x);
  SelfContactReport out{.nearest = std::numeric_limits<double>::infinity()};
  for (const Touch& touch : touches(x)) {
    ++out.contacts;
    out.nearest = std::min(out.nearest, touch.distance);
    out.normal -= touch.slope;
    out.energy += touch.energy;
  }
  return out;
}

}  // namespace kt
