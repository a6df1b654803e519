#include <cmath>

#include "core/local/damping.hpp"
#include "core/local/fine_patch.hpp"
#include "haptics/remote/sent_model.hpp"

namespace kt {
namespace {

/// An entry of a sparse one takes half as much again as one of a dense one.
SentMatrix pack_matrix(const SparseMatrix& m) {
  SentMatrix out;
  out.is_diagonal = is_diagonal(m);
  if (out.is_diagonal) {
    const VectorX d = m.diagonal();
    out.values.assign(d.begin(), d.end());
    return out;
  }
  if (3 * m.nonZeros() < 2 * m.rows() * m.cols()) {
    out.first.push_back(0);
    for (int c = 0; c < m.outerSize(); ++c) {
      for (SparseMatrix::InnerIterator it(m, c); it; ++it) {
        if (it.row() < c || it.value() == 0) continue;
        out.row.push_back(static_cast<int>(it.row()));
        out.values.push_back(it.value());
      }
      out.first.push_back(static_cast<int>(out.values.size()));
    }
    return out;
  }
  const MatrixX dense = m;
  for (Eigen::Index c = 0; c < dense.cols(); ++c)
    for (Eigen::Index r = c; r < dense.rows(); ++r) out.values.push_back(dense(r, c));
  return out;
}

SentBasis pack_basis(const SparseMatrix& basis, int bits) {
  const double most = bits == 8 ? 127 : 32767;
  SentBasis out{.rows = static_cast<int>(basis.rows()), .bits = bits, .scale = {}, .first = {}, .row = {}, .value = {}};
  out.is_dense = 3 * basis.nonZeros() > basis.rows() * basis.cols();
  if (!out.is_dense) out.first.push_back(0);
  for (int c = 0; c < basis.outerSize(); ++c) {
    double largest = 0;
    for (SparseMatrix::InnerIterator it(basis, c); it; ++it) largest = std::max(largest, std::abs(it.value()));
    // Upwards, so that the largest entry stays within its whole numbers.
    const float scale = std::nextafter(static_cast<float>(largest / most), std::numeric_limits<float>::infinity());
    out.scale.push_back(scale);
    const std::size_t from = out.value.size();
    if (out.is_dense) out.value.resize(from + static_cast<std::size_t>(basis.rows()));
    for (SparseMatrix::InnerIterator it(basis, c); it; ++it) {
      const auto value = static_cast<std::int16_t>(std::lround(it.value() / static_cast<double>(scale)));
      if (out.is_dense) {
        out.value[from + static_cast<std::size_t>(it.row())] = value;
      } else {
        out.row.push_back(static_cast<int>(it.row()));
        out.value.push_back(value);
      }
    }
    if (!out.is_dense) out.first.push_back(static_cast<int>(out.value.size()));
  }
  return out;
}

SentPositions pack_positions(const VectorX& x) {
  constexpr double kSteps = 65535;
  SentPositions out;
  const auto nodes = x.reshaped(3, x.size() / 3);
  out.low = nodes.rowwise().minCoeff();
  out.step = (nodes.rowwise().maxCoeff() - out.low) / kSteps;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double step = out.step[i % 3];
    const double at = step > 0 ? std::clamp((x[i] - out.low[i % 3]) / step, 0.0, kSteps) : 0;
    out.at.push_back(static_cast<std::uint16_t>(std::lround(at)));
  }
  return out;
}

}  // namespace

SentModel pack_model(const PreparedLocalModel& model, int basis_bits) {
  const LocalModel& m = model.model;
  const LocalState& s = model.state;
  SentModel out;
  out.frame = m.frame;
  out.linearized_tick = model.linearized_tick;
  out.t = m.t;
  out.triangles = m.patch.global_triangle;
  out.more_nodes.assign(m.recovered_node.begin() + m.patch.num_vertices(), m.recovered_node.end());
  out.x0 = m.x0;
  for (const double v : m.v0) out.v0.push_back(static_cast<float>(v));
  out.basis = pack_basis(m.basis, basis_bits);
  out.mass = pack_matrix(m.mass);
  out.damping = pack_matrix(m.damping);
  out.stiffness = pack_matrix(m.stiffness);
  out.f0 = m.f0;
  out.q_rate0 = m.q_rate0;
  out.definite_tangent = m.definite_tangent;
  out.reducer = m.reducer;
  out.certified_error = m.certified_error;
  out.scheme = model.scheme;
  out.site = model.site;
  out.places = model.places;
  out.way_out = model.way_out;
  out.q = s.q;
  out.q_rate = s.q_rate;
  out.du = model.work.du.head(model.patch_basis.rows());
  for (int i = 0; i < s.anchors.count; ++i) {
    SentAnchor anchor{s.anchors.contacts[static_cast<std::size_t>(i)], s.impulse[static_cast<std::size_t>(i)]};
    Contact& contact = anchor.contact;  // by its place on the body: aprons may differ
    if (model.surface.fine) {
      const SurfacePlace place = model.surface.place_of(contact.triangle, contact.bary);
      contact.triangle = place.triangle;
      contact.bary = place.weights;
    } else {
      contact.triangle = model.surface.global_facet(contact.triangle);
    }
    out.anchors.push_back(anchor);
  }
  for (const double v : model.unloaded) out.unloaded.push_back(static_cast<float>(v));
  out.sliding = s.sliding;
  out.overlap = s.overlap;
  out.body = pack_positions(model.body_x.head(3 * static_cast<Eigen::Index>(model.recovered_row.size())));
  out.friction = model.base_friction;
  out.tool_radius = model.tool_radius;
  out.material = model.material;
  if (m.fine) out.fine = m.fine->origin;
  return out;
}

}  // namespace kt
