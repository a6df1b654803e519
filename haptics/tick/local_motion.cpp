#include "haptics/tick/local_motion.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace kt {
namespace {

/// Makes a motion smaller where `fit` would make the nodes' mean square motion larger than it was. A basis that follows
/// another's badly would do so at each refresh, until the patch is far from the body.
/// @param motion  of the recovered nodes [m or m/s], zero of those that have none, (3 recovered)
/// @param share   of the nodes that have one
void keep_from_growing(const SparseMatrix& fit, const PreparedLocalModel& model, double share, VectorX& motion,
                       LocalWorkspace& w) noexcept {
  w.fitted.noalias() = fit * motion;
  w.followed.noalias() = model.model.basis * w.fitted;
  const double had = motion.squaredNorm(), has = share * w.followed.squaredNorm();
  if (has > had) motion *= std::sqrt(had / has);
}

}  // namespace

LocalMotion make_local_motion(int num_nodes) {
  LocalMotion out;
  out.x = out.v = out.du = VectorX::Zero(3 * num_nodes);
  out.yielded = VectorX::Zero(3 * kMostYielding);
  out.row.assign(static_cast<std::size_t>(num_nodes), -1);
  return out;
}

void record_motion(const PreparedLocalModel& model, int tick, LocalMotion& out) noexcept {
  out.tick = tick;
  out.frame = model.model.frame;
  const LocalModel& m = model.model;
  const Eigen::Index rows = m.basis.rows(), patch = 3 * static_cast<Eigen::Index>(m.patch.num_vertices());
  auto x = out.x.head(rows), v = out.v.head(rows);
  x = m.x0;
  x.noalias() += m.basis * model.state.q;
  v.noalias() = m.basis * model.state.q_rate;
  out.du.head(patch) = model.work.du.head(patch);
  out.yielded.head(model.state.yielded.size()) = model.state.yielded;
  out.num_patch = static_cast<int>(patch / 3);
  out.row = model.recovered_row;
  out.overlap = model.state.overlap;
}

void carry_motion(const LocalMotion& motion, PreparedLocalModel& model, const FinePatch* fine) noexcept {
  const LocalModel& m = model.model;
  LocalWorkspace& w = model.work;
  const auto count = static_cast<int>(m.recovered_node.size());
  int known = 0;
  for (int i = 0; i < count; ++i) {
    const int row = motion.row[m.recovered_node[i]];
    known += row >= 0;
    node(w.x_recovered, i) = row < 0 ? Vec3(Vec3::Zero()) : Vec3(node(motion.x, row) - node(m.x0, i));
    node(w.v_recovered, i) = row < 0 ? Vec3(Vec3::Zero()) : Vec3(node(motion.v, row) - node(m.v0, i));
  }
  const double share = static_cast<double>(known) / std::max(count, 1);
  keep_from_growing(m.fit, model, share, w.x_recovered, w);
  keep_from_growing(m.fit_rate, model, share, w.v_recovered, w);
  LocalState& s = model.state;
  s.q.noalias() = m.fit * w.x_recovered;
  s.q_rate = m.q_rate0;
  s.q_rate.noalias() += m.fit_rate * w.v_recovered;
  s.overlap = motion.overlap;
  if (model.surface.fine)
    carry_yield(motion.yielded.size() > 0 ? fine : nullptr, motion.yielded, *model.surface.fine, s.yielded);
  w.du.tail(s.yielded.size()).setZero();
  // The motion that contact causes goes on: the first guess of the next tick.
  for (int i = 0; i < m.patch.num_vertices(); ++i) {
    const int row = motion.row[m.patch.global_node[i]];
    node(w.du, i) = row >= 0 && row < motion.num_patch ? Vec3(node(motion.du, row)) : Vec3(Vec3::Zero());
  }
}

void place_contacts(PreparedLocalModel& model, std::span<const TickContact> contacts,
                    const std::array<bool, kMaxTools>& sliding) noexcept {
  LocalState& s = model.state;
  s.anchors.count = 0;
  for (const TickContact& sample : contacts) {
    const auto [facet, bary] = model.facet_at({sample.triangle, sample.bary});
    if (facet < 0) continue;
    s.impulse[s.anchors.count] = sample.impulse;
    s.anchors.add({.triangle = facet, .bary = bary, .normal = sample.normal, .tool = sample.tool});
  }
  s.sliding = sliding;
}

}  // namespace kt
