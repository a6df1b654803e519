#include "haptics/tick/prepared_local_model.hpp"

#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "core/base/wide.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/linear/sparse_solver.hpp"

namespace kt {
namespace {

/// out += three columns; each entry is a sum of its own, so that every width gives the same bits.
KT_WIDE void add_columns(const double* __restrict a, Eigen::Index stride, double s0, double s1, double s2,
                         Eigen::Index n, double* __restrict out) noexcept {
  const double* __restrict a1 = a + stride, * __restrict a2 = a1 + stride;
  for (Eigen::Index i = 0; i < n; ++i) out[i] += a[i] * s0 + a1[i] * s1 + a2[i] * s2;
}

}  // namespace

void PreparedLocalModel::recover_patch(const VectorX& reduced, VectorX& out) const noexcept {
  const bool is_whole = surface.num_yielding() == 0;
  if (!dense_patch_basis.empty()) {
    if (is_whole && out.size() != dense_patch_basis.rows()) out.resize(dense_patch_basis.rows());
    dense_patch_basis.multiply(reduced, out);
  } else if (is_whole) {
    out.noalias() = patch_basis * reduced;
  } else {
    out.head(patch_basis.rows()).noalias() = patch_basis * reduced;
  }
}

void PreparedLocalModel::yield_freely(VectorX& out) const noexcept {
  out.tail(state.yielded.size()) = -yield_rate * state.yielded;
}

/// Mean velocity over the tick: R p / (h (retardation + h)), h that of the dynamics.
void PreparedLocalModel::add_yield(const VectorX& impulse, VectorX& out) const noexcept {
  if (!surface.fine) return;
  const double scale = yield_rate / dynamics->h();
  auto yields = out.tail(state.yielded.size());
  for (int i = surface.num_nodes, k = 0; i < surface.num_moving(); ++i, ++k)
    if (const Vec3 own = scale * node(impulse, i); !own.isZero(0)) {
      const MatrixX& R = surface.fine->R;
      add_columns(R.col(3 * k).data(), R.outerStride(), own[0], own[1], own[2], yields.size(), yields.data());
    }
}

std::pair<int, Vec3> PreparedLocalModel::facet_at(const SurfacePlace& place) const noexcept {
  const int pieces = surface.facets_per_triangle(), facet = local_facet(place.triangle * pieces);
  if (facet < 0 || surface.is_apron(facet)) return {facet, place.weights};
  return surface.facet_at(facet / pieces, place);
}

double Overlap::allowed() const noexcept {
  if (!(left > 0)) return 0;
  const double share = left / time;
  return start * share * share * (3 - 2 * share);
}

double softest_contact(const PreparedLocalModel& model) noexcept {
  constexpr double kHeaviest = 1;      // [kg]
  constexpr double kGivesLess = 1e-3;  // of the patch's: nothing but a clamped node's neighbourhood is so much stiffer
  const double own = kGivesLess * model.mobility;
  return own > 0 ? std::min(1 / kHeaviest, own) : 1 / kHeaviest;
}

namespace {

void make_room_for_contacts(std::size_t count, int vertices, LocalWorkspace& w) {
  w.candidates.resize(count);
  for (int k = 0; k < kMaxTools; ++k) {
    w.ignored[k].resize(count);
    w.near_facets[k].resize(count);
    w.near[k] = NearFeatures(static_cast<int>(count), vertices);
    w.chosen[k].is_left_out.assign(static_cast<std::size_t>(vertices), 0);
  }
}

}  // namespace

std::unique_ptr<PreparedLocalModel> prepare(LocalModel model, LocalScheme scheme, Metric metric, double h,
                                            const std::string& collision_backend, int num_nodes, int num_triangles,
                                            const Smoothing& smoothing) {
  auto out = std::make_unique<PreparedLocalModel>();
  out->model = std::move(model);
  const LocalModel& m = out->model;
  const int p3 = 3 * m.patch.num_vertices(), r = m.dof();
  const int triangles = static_cast<int>(m.patch.triangles.size());
  out->surface = make_contact_surface(m.patch, smoothing, m.fine);
  turn_offsets(m.patch, m.x0, out->surface);
  const ContactSurface& surface = out->surface;
  out->dynamics = std::make_unique<LocalDynamics>(m, scheme, metric, h);
  out->patch_basis = m.basis.topRows(p3);
  if (2 * out->patch_basis.nonZeros() > out->patch_basis.rows() * out->patch_basis.cols())
    out->dense_patch_basis = PanelMatrix(MatrixX(out->patch_basis));

  out->index = make_triangle_index(collision_backend);
  VectorX x0 = VectorX::Zero(3 * surface.facets.num_vertices());
  const Eigen::Index moving = 3 * static_cast<Eigen::Index>(surface.num_moving());
  VectorX moved = VectorX::Zero(moving);
  moved.head(p3) = m.x0.head(p3);
  surface.place(moved, x0);
  out->index->build(surface.facets.triangles, x0);

  const MatrixX& C = out->dynamics->metric().C;
  for (int i = 0; i < m.patch.num_vertices(); ++i)
    out->mobility = std::max(out->mobility, C.block<3, 3>(3 * i, 3 * i).trace() / 3);

  VectorX row_weight = VectorX::Zero(p3);
  for (int c = 0; c < out->patch_basis.outerSize(); ++c)
    for (SparseMatrix::InnerIterator it(out->patch_basis, c); it; ++it) row_weight[it.row()] += std::abs(it.value());
  const auto moves = [&](int vertex) {
    if (!m.patch.embedded) return row_weight[3 * vertex] > 0;
    const EmbeddedPatch& e = *m.patch.embedded;
    const auto first = e.from.begin() + e.first[vertex], last = e.from.begin() + e.first[vertex + 1];
    return std::any_of(first, last, [&](int node) { return row_weight[3 * node] > 0; });
  };
  for (const Triangle& t : m.patch.triangles) out->moves.push_back({moves(t[0]), moves(t[1]), moves(t[2])});

  out->recovered_row.assign(num_nodes, -1);
  for (int i = 0; i < static_cast<int>(m.recovered_node.size()); ++i) out->recovered_row[m.recovered_node[i]] = i;
  out->local_triangle.assign(num_triangles, -1);
  for (int t = 0; t < triangles; ++t) out->local_triangle[m.patch.global_triangle[t]] = t;

  out->state.q = out->adopted_q = VectorX::Zero(r);
  out->state.q_rate = m.q_rate0;
  out->state.yielded = VectorX::Zero(moving - p3);
  if (surface.fine) out->yield_rate = 1 / (surface.fine->retardation + h);
  LocalWorkspace& w = out->work;
  w.v_free = w.v_free_end = w.q_pushed = w.force = w.fitted = VectorX::Zero(r);
  w.x = w.x_event = w.x_end = w.x_guess = w.x_near = w.u = x0;
  w.patch_motion = VectorX::Zero(p3);
  w.motion_of = VectorX::Constant(r, std::numeric_limits<double>::quiet_NaN());
  w.motion = w.u_free = w.du = w.du_guess = w.step = w.step_before = VectorX::Zero(moving);
  w.impulse = w.impulse_weighted = w.motion;
  w.x_recovered = w.followed = m.x0;
  w.v_recovered = m.v0;
  w.coupling = CouplingRoom(surface.num_moving());
  make_room_for_contacts(surface.facets.triangles.size(), surface.facets.num_vertices(), w);
  return out;
}

namespace {

/// Room for all vertices and facets that an apron can have; the apron's vertices where they are.
void widen(const VectorX& patch_x, PreparedLocalModel& model) {
  const ContactSurface& surface = model.surface;
  LocalWorkspace& w = model.work;
  const ApronRoom& room = model.apron_room;
  const auto vertices = static_cast<Eigen::Index>(room.vertices) + room.most_vertices;
  VectorX x0 = VectorX::Zero(3 * vertices);
  VectorX moving = VectorX::Zero(3 * static_cast<Eigen::Index>(surface.num_moving()));
  moving.head(patch_x.size()) = patch_x;
  surface.place(moving, x0);
  surface.place_apron(moving, x0);
  for (Eigen::Index v = surface.facets.num_vertices(); v < vertices; ++v) x0.segment<3>(3 * v) = x0.head<3>();
  w.x = w.x_event = w.x_end = w.x_guess = w.x_near = w.u = x0;
  w.u.setZero();
  make_room_for_contacts(room.triangles + static_cast<std::size_t>(room.most_triangles), static_cast<int>(vertices), w);
}

void number_apron(PreparedLocalModel& model) noexcept {
  const ContactSurface& s = model.surface;
  for (std::size_t f = static_cast<std::size_t>(s.apron_facets); f < s.facets.triangles.size(); ++f)
    model.apron_facet[static_cast<std::size_t>(s.facets.global_triangle[f])] = static_cast<int>(f);
}

/// The backend's for a window that stays; for one that is laid again within a tick, one that is built without
/// allocation.
std::unique_ptr<TriangleIndex> make_wide_index(const PreparedLocalModel& model, const std::string& backend) {
  const SurfacePatch& facets = model.surface.facets;
  if (model.apron->has_all()) {
    auto out = make_triangle_index(backend);
    out->build(facets.triangles, model.work.x);
    return out;
  }
  auto out = make_triangle_index("brute_force");
  const ApronRoom& room = model.apron_room;
  const std::vector<Triangle> most(room.triangles + static_cast<std::size_t>(room.most_triangles), facets.triangles[0]);
  out->build(most, model.work.x);
  out->build(facets.triangles, model.work.x);
  return out;
}

/// How far each tool's place was from the patch's rim and the apron.
void measure_clearance(PreparedLocalModel& model, std::span<const Vec3> places) {
  const SurfacePatch& facets = model.surface.facets;
  model.clear.fill(std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < places.size(); ++k) {
    double nearest_sq = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < facets.triangles.size(); ++t) {
      if (!facets.on_rim[t]) continue;
      const Triangle& v = facets.triangles[t];
      const VectorX& x = model.work.x;
      nearest_sq = std::min(
          nearest_sq, closest_point_on_triangle(places[k], node(x, v[0]), node(x, v[1]), node(x, v[2])).distance_sq);
    }
    model.clear[k] = std::sqrt(nearest_sq);
    model.clear_from[k] = places[k];
  }
}

/// Of each vertex of the patch, whether the local model answers to a load on it alone: those in reach, and what cannot
/// move or is a coordinate itself, as behind a wall. All for a tool with corners, which may rest on the rim: there the
/// place of the rim counts for more than how it yields; a ball's patch ends beyond what it touches at rest.
/// @param radius  of the largest rounding [m]
std::vector<char> find_answering(const PreparedLocalModel& model, double radius) {
  constexpr double kRound = 0.1;  // of the reach
  if (radius <= kRound * model.site.reach) return std::vector<char>(model.model.patch.in_reach.size(), 1);
  std::vector<int> entries(static_cast<std::size_t>(model.patch_basis.rows()), 0);
  for (int c = 0; c < model.patch_basis.outerSize(); ++c)
    for (SparseMatrix::InnerIterator it(model.patch_basis, c); it; ++it) entries[it.row()] += it.value() != 0;
  std::vector<char> out = model.model.patch.in_reach;
  for (std::size_t v = 0; v < out.size(); ++v)
    out[v] = out[v] || (entries[3 * v] <= 1 && entries[3 * v + 1] <= 1 && entries[3 * v + 2] <= 1);
  return out;
}

}  // namespace

void lay_apron(PreparedLocalModel& model, const Surface& surface, std::span<const int> fixed_nodes,
               std::span<const double> tool_radii, const std::string& collision_backend) {
  const SurfacePatch& patch = model.model.patch;
  if (patch.triangles.size() == surface.triangles.size()) return;
  std::vector<char> moves(static_cast<std::size_t>(patch.num_vertices()), 0);
  for (std::size_t t = 0; t < patch.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) moves[patch.triangles[t][c]] = model.moves[t][c];
  std::vector<char> is_fixed(static_cast<std::size_t>(model.body_x.size() / 3), 0);
  for (const int i : fixed_nodes) is_fixed[i] = 1;
  const double radius = *std::ranges::max_element(tool_radii);
  const std::vector<char> answers = find_answering(model, radius);
  const VectorX patch_x = model.model.x0.head(model.patch_basis.rows());
  model.apron =
      std::make_unique<ApronWindow>(surface, model.body_x, model.local_triangle,
                                    make_apron_motion(surface, model.body_x, model.site, patch,
                                                      {patch_x, moves, answers, is_fixed, radius, model.unloaded}),
                                    collision_backend);
  give_rim_to_apron(model.apron->motion(), patch, model.surface);
  model.apron_room = ApronRoom(static_cast<int>(is_fixed.size()), model.apron->num_triangles(),
                               model.apron->num_vertices(), model.surface);
  model.apron_surface = &surface;
  const std::span<const Vec3> places(model.places.data(), tool_radii.size());
  append_apron(surface, model.apron->motion(), patch, model.apron->choose(places), model.apron_room, model.surface);
  widen(patch_x, model);
  model.wide_index = make_wide_index(model, collision_backend);
  model.apron_facet.assign(surface.triangles.size(), -1);
  number_apron(model);
  measure_clearance(model, places);
}

void move_apron(PreparedLocalModel& model, std::span<const Vec3> places) noexcept {
  ContactSurface& surface = model.surface;
  ContactSet& anchors = model.state.anchors;
  std::array<int, kMaxContacts> held;  // triangles of the body, of those on the apron; -1: on the patch
  for (int i = 0; i < anchors.count; ++i) {
    const int facet = anchors.contacts[i].triangle;
    held[i] = surface.is_apron(facet) ? surface.facets.global_triangle[facet] : -1;
  }
  for (std::size_t f = static_cast<std::size_t>(surface.apron_facets); f < surface.facets.triangles.size(); ++f)
    model.apron_facet[static_cast<std::size_t>(surface.facets.global_triangle[f])] = -1;
  append_apron(*model.apron_surface, model.apron->motion(), model.model.patch, model.apron->choose(places),
               model.apron_room, surface);
  number_apron(model);
  model.wide_index->build(surface.facets.triangles, model.work.x);
  int kept = 0;
  for (int i = 0; i < anchors.count; ++i) {
    Contact contact = anchors.contacts[i];
    if (held[i] >= 0) contact.triangle = model.apron_facet[static_cast<std::size_t>(held[i])];
    if (contact.triangle < 0) continue;
    anchors.contacts[kept] = contact;
    model.state.impulse[kept++] = model.state.impulse[i];
  }
  anchors.count = kept;
}

VectorX find_unloaded(const PreparedLocalModel& model, const VectorX& patch_force) {
  const LocalModel& m = model.model;
  const VectorX load = model.patch_basis.transpose() * patch_force;
  const VectorX diagonal = m.stiffness.diagonal();
  if (m.dof() == 0 || !(diagonal.minCoeff() > 0)) return {};
  VectorX answer;
  if (m.stiffness.nonZeros() == m.dof()) {
    answer = load.cwiseQuotient(diagonal);
  } else {
    const auto solver = make_sparse_solver();
    if (!solver->factor(m.stiffness)) return {};
    answer = solver->solve(load);
  }
  VectorX out = -(model.patch_basis * answer);
  return out.allFinite() ? out : VectorX();
}

}  // namespace kt
