#include "haptics/remote/model_unpacker.hpp"

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <tuple>
#include <utility>

#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"
#include "haptics/contact/scene_friction.hpp"
#include "haptics/halves/live_settings.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "haptics/refresh/touch_parts.hpp"

namespace kt {
namespace {

constexpr double kFarthestSent = 1e6;  // [m], as places in a scene
constexpr double kLargest = 1e15;      // of any number besides places
constexpr std::size_t kMostDof = 4096, kMostSites = 16;

bool is_within(const auto& numbers, double most) {
  return std::ranges::all_of(numbers, [&](double v) { return std::abs(v) <= most; });  // NaN is not
}
bool is_place(const Vec3& v) { return is_within(v, kFarthestSent); }

bool are_below(const std::vector<int>& indices, int end) {
  return std::ranges::all_of(indices, [&](int i) { return i >= 0 && i < end; });
}

bool is_ascending(const std::vector<int>& v) {
  return std::ranges::adjacent_find(v, std::greater_equal<>()) == v.end();
}

bool is_weight(const Vec3& bary) {
  constexpr double kRounding = 1e-5;
  return bary.minCoeff() >= -kRounding && bary.maxCoeff() <= 1 + kRounding && std::abs(bary.sum() - 1) <= kRounding;
}

bool is_unit(const Vec3& v) { return std::abs(v.norm() - 1) < 1e-3; }

/// A value that the setting may have.
bool is_setting(const char* key, double value) { return is_within(in_range_of(live_setting(key), value)); }

/// The whole matrix of lower columns.
MatrixX full(const SentMatrix& m, Eigen::Index r) {
  MatrixX out(r, r);
  std::size_t k = 0;
  for (Eigen::Index c = 0; c < r; ++c)
    for (Eigen::Index i = c; i < r; ++i) out(i, c) = out(c, i) = m.values[k++];
  return out;
}

SparseMatrix unpack_matrix(const SentMatrix& m, Eigen::Index r) {
  if (m.is_diagonal) return SparseMatrix(VectorX(Eigen::Map<const VectorX>(m.values.data(), r)).asDiagonal());
  if (!m.is_sparse()) return full(m, r).sparseView();
  const Eigen::Map<const SparseMatrix> lower(r, r, static_cast<Eigen::Index>(m.values.size()), m.first.data(),
                                             m.row.data(), m.values.data());
  return SparseMatrix(lower.selfadjointView<Eigen::Lower>());
}

/// @param least  smallest eigenvalue allowed, over the largest entry of the diagonal
bool is_definite(const SentMatrix& m, Eigen::Index r, double least) {
  const SparseMatrix whole = m.is_diagonal || m.is_sparse() ? unpack_matrix(m, r) : SparseMatrix();
  const VectorX diagonal = m.is_diagonal || m.is_sparse() ? VectorX(whole.diagonal()) : VectorX(full(m, r).diagonal());
  const double shift = -least * diagonal.cwiseAbs().maxCoeff();
  if (m.is_diagonal) return diagonal.minCoeff() + shift >= 0 && (least < 0 || diagonal.minCoeff() > 0);
  if (m.is_sparse()) {
    if (diagonal.minCoeff() + shift <= 0) return false;
    SparseMatrix identity(r, r);
    identity.setIdentity();
    const SparseMatrix shifted = whole + shift * identity;
    return Eigen::SimplicialLLT<SparseMatrix>(shifted).info() == Eigen::Success;
  }
  const MatrixX shifted = full(m, r) + shift * MatrixX::Identity(r, r);
  return Eigen::LLT<MatrixX>(shifted).info() == Eigen::Success;
}

SparseMatrix unpack_basis(const SentBasis& b) {
  const auto columns = static_cast<Eigen::Index>(b.scale.size());
  SparseMatrix out(b.rows, columns);
  out.reserve(static_cast<Eigen::Index>(b.value.size()));
  for (Eigen::Index c = 0; c < columns; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const double scale = b.scale[i];
    const int from = b.is_dense ? static_cast<int>(c) * b.rows : b.first[i];
    const int to = b.is_dense ? from + b.rows : b.first[i + 1];
    out.startVec(c);
    for (int k = from; k < to; ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (b.value[at] != 0) out.insertBack(b.is_dense ? k - from : b.row[at], c) = b.value[at] * scale;
    }
  }
  out.finalize();
  return out;
}

/// Columns of a sparse matrix: where each begins, and rows that ascend, from `low(c)` on.
bool are_columns(const std::vector<int>& first, const std::vector<int>& row, std::size_t values, std::size_t columns,
                 std::size_t rows, const auto& low) {
  if (first.size() != columns + 1 || first.front() != 0 || row.size() != values ||
      static_cast<std::size_t>(first.back()) != values || !std::ranges::is_sorted(first) ||
      !are_below(row, static_cast<int>(rows)))
    return false;
  for (std::size_t c = 0; c < columns; ++c) {
    const std::span own(row.begin() + first[c], row.begin() + first[c + 1]);
    if (!std::ranges::is_sorted(own, std::less_equal<>()) || (!own.empty() && own.front() < low(c))) return false;
  }
  return true;
}

std::string trouble_of(const SentMatrix& m, std::size_t r) {
  if (m.is_sparse() && !m.is_diagonal) {
    if (!are_columns(m.first, m.row, m.values.size(), r, r, [](std::size_t c) { return static_cast<int>(c); }))
      return "an index of a matrix is out of range";
  } else if (m.is_sparse() || m.values.size() != (m.is_diagonal ? r : r * (r + 1) / 2)) {
    return "a matrix has another size";
  }
  return is_within(m.values, kLargest) ? "" : "an entry of a matrix is no number";
}

std::string trouble_of(const SentBasis& b, std::size_t rows, std::size_t r) {
  if (static_cast<std::size_t>(b.rows) != rows || b.scale.size() != r) return "the basis has another size";
  if (!std::ranges::all_of(b.scale, [](float s) { return s >= 0 && s <= 1e9f; }))
    return "a scale of the basis is wrong";
  if (b.is_dense) return b.value.size() == rows * r ? "" : "the basis has another size";
  if (!are_columns(b.first, b.row, b.value.size(), r, rows, [](std::size_t) { return 0; }))
    return "an index of the basis is out of range";
  return "";
}

}  // namespace

void require_sendable(const TouchOptions& options) {
  const std::string& method = options.local.method;
  if (method != "multirate" || is_geometric(options.contact.law) || !options.local.catch_up)
    throw InputError(
        text("link.type network: needs local.method multirate, contact.law coulomb and local.catch_up true; "
             "local.method is \"",
             method, "\", contact.law \"", options.contact.law, "\", local.catch_up ",
             options.local.catch_up ? "true" : "false", ": their local models need maps that do not travel"));
}

ModelUnpacker::ModelUnpacker(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                             MakeLike make_like)
    : model_(model),
      surface_(surface),
      options_(options),
      metric_(contact_metric(options.contact.metric)),
      method_(make_method(options, {})),
      make_like_(std::move(make_like)) {
  require_sendable(options);
  if (may_refine(options.contact, options.local).refines) try {
      cells_.emplace(model_, surface_, options_.local.refine_nodes, options_.contact.surface);
    } catch (const InputError&) {  // the model tells no material: it is not refined on the body's computer either
    }
}

ModelUnpacker::ModelUnpacker(const Body& body, const TouchOptions& options)
    : ModelUnpacker(body.model(), body.surface(), options, [&body](const LiveMaterial& now) {
        SceneModel material = body.options().object.model;
        material.young = now.young;
        material.damping.mass = now.damping_mass;
        material.damping.stiffness = now.damping_stiffness;
        return body.model_like(material);
      }) {}

/// As on the body's computer, where a tool's radius may have changed.
Smoothing ModelUnpacker::smoothing_of(const SentModel& sent) const {
  if (options_.contact.surface == "flat") return {};
  TouchOptions now = options_;
  for (std::size_t k = 0; k < now.tools.size(); ++k)
    if (sent.tool_radius[k] >= 0) now.tools[k].shape.radius = sent.tool_radius[k];
  return contact_smoothing(model_, surface_, now, false);
}

std::string ModelUnpacker::trouble(const SentModel& m) const {
  const int nodes = model_.mesh().num_own_nodes(), triangles = static_cast<int>(surface_.triangles.size());
  const auto r = static_cast<std::size_t>(m.dof());
  if (r == 0 || r > kMostDof) return text("it has ", r, " coordinates, must be 1 .. ", kMostDof);
  if (m.triangles.empty() || !are_below(m.triangles, triangles) || !is_ascending(m.triangles))
    return "a triangle of the patch is out of range";
  std::vector<char> seen(static_cast<std::size_t>(nodes), 0);
  const Smoothing smoothing = smoothing_of(m);
  const std::vector<int> of_patch = patch_of(surface_, m.triangles, smoothing.levels > 0).global_node;
  for (const int i : of_patch) seen[static_cast<std::size_t>(i)] = 1;
  const std::size_t patch = of_patch.size(), recovered = patch + m.more_nodes.size();
  if (!are_below(m.more_nodes, nodes)) return "a node is out of range";
  for (const int i : m.more_nodes)
    if (std::exchange(seen[static_cast<std::size_t>(i)], 1)) return "a node is there twice";
  const std::size_t rows = 3 * recovered;
  if (static_cast<std::size_t>(m.x0.size()) != rows || m.v0.size() != rows) return "positions have another size";
  if (!is_within(m.x0, kFarthestSent) || !is_within(m.v0, kFarthestSent)) return "a position is no number";
  if (const std::string wrong = trouble_of(m.basis, rows, r); !wrong.empty()) return wrong;
  for (const SentMatrix* matrix : {&m.mass, &m.damping, &m.stiffness})
    if (const std::string wrong = trouble_of(*matrix, r); !wrong.empty()) return wrong;
  const auto dof = static_cast<Eigen::Index>(r);
  if (!is_definite(m.mass, dof, 0)) return "the mass is not positive";
  constexpr double kRoundoff = 1e-9;
  if (!is_definite(m.stiffness, dof, -kRoundoff)) return "the stiffness is negative";
  if (!is_definite(m.damping, dof, -kRoundoff)) return "the damping is negative";
  for (const VectorX* v : {&m.f0, &m.q_rate0, &m.q, &m.q_rate})
    if (static_cast<std::size_t>(v->size()) != r || !is_within(*v, kLargest)) return "the motion is no number";
  if (static_cast<std::size_t>(m.du.size()) != 3 * patch || !is_within(m.du, kLargest))
    return "the motion is no number";
  if (!m.unloaded.empty() && (m.unloaded.size() != 3 * patch || !is_within(m.unloaded, kFarthestSent)))
    return "the unloaded patch is no place";
  if (m.scheme == LocalScheme::exact && !(m.mass.is_diagonal && m.damping.is_diagonal && m.stiffness.is_diagonal))
    return "its coordinates are coupled, and it is to be stepped exactly";
  if (m.scheme != LocalScheme::exact && m.scheme != LocalScheme::implicit_euler &&
      m.scheme != LocalScheme::symplectic_euler)
    return "its scheme is unknown";
  const int tools = static_cast<int>(options_.tools.size());
  if (m.anchors.size() > static_cast<std::size_t>(kMaxContacts)) return "there are too many contacts";
  for (const SentAnchor& a : m.anchors) {
    const Contact& c = a.contact;
    const int facets = triangles << (2 * smoothing.levels);
    if (c.triangle < 0 || c.triangle >= facets || c.tool < 0 || c.tool >= tools || !is_weight(c.bary) ||
        !is_unit(c.normal) || !is_place(c.core) || !is_within(a.impulse, kFarthestSent) ||
        !(std::abs(c.gap) <= kFarthestSent) || !(c.toi >= 0 && c.toi <= 1))
      return "a contact is wrong";
  }
  std::vector<ContactSite> sites{m.site};
  sites.insert(sites.end(), m.site.others.begin(), m.site.others.end());
  if (sites.size() > kMostSites) return "there are too many sites";
  for (const ContactSite& site : sites)
    if (!is_place(site.centre) || !is_place(site.way) || site.triangle < 0 || site.triangle >= triangles ||
        !(site.reach >= 0 && site.reach <= kFarthestSent))
      return "a site is wrong";
  for (std::size_t k = 0; k < kMaxTools; ++k) {
    const Overlap& o = m.overlap[k];
    if (!is_place(m.places[k]) || m.way_out[k] < kNotLooked || m.way_out[k] >= triangles ||
        !(o.start >= 0 && o.start <= kFarthestSent && o.time >= 0 && o.time <= kFarthestSent && o.left >= 0 &&
          o.left <= o.time) ||
        !(std::abs(m.tool_radius[k]) <= kFarthestSent))
      return "a tool is wrong";
  }
  if (m.body.at.size() != static_cast<std::size_t>(3 * nodes) || !is_place(m.body.low) || !is_place(m.body.step) ||
      m.body.step.minCoeff() < 0)
    return "the body's positions are wrong";
  if (m.friction && !(m.friction->mu_kinetic >= 0 && m.friction->mu_static >= m.friction->mu_kinetic &&
                      m.friction->mu_static <= 100 && m.friction->stribeck >= 0 && m.friction->stribeck <= 100))
    return "the friction is wrong";
  if (m.material && !(make_like_ && is_setting("object.model.young", m.material->young) &&
                      is_setting("object.model.damping.mass", m.material->damping_mass) &&
                      is_setting("object.model.damping.stiffness", m.material->damping_stiffness)))
    return "the material is wrong";
  if (!m.fine) return "";
  return cells_ ? cells_->trouble(*m.fine) : "refined cells: the scene has none";
}

VectorX ModelUnpacker::positions_of(const SentModel& sent) const {
  VectorX out = model_.mesh().x;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(sent.body.at.size()); ++i)
    out[i] = sent.body.low[i % 3] + sent.body.step[i % 3] * sent.body.at[static_cast<std::size_t>(i)];
  if (surface_.embedded) surface_.embedded->follow(out);
  return out;
}

/// Null: it has none.
std::shared_ptr<const FinePatch> ModelUnpacker::refine(const SentModel& sent) {
  if (!sent.fine) return nullptr;
  if (sent.material != material_) {
    std::unique_ptr<DeformableModel> like = sent.material ? make_like_(*sent.material) : nullptr;
    cells_.emplace(like ? *like : model_, surface_, options_.local.refine_nodes, options_.contact.surface);
    like_ = std::move(like);
    material_ = sent.material;
  }
  return cells_->find(sent.fine);
}

std::unique_ptr<PreparedLocalModel> ModelUnpacker::unpack(const SentModel& sent) {
  const Smoothing smoothing = smoothing_of(sent);
  LocalModel local;
  local.frame = sent.frame;
  local.t = sent.t;
  local.patch = patch_of(surface_, sent.triangles, smoothing.levels > 0);
  local.recovered_node = local.patch.global_node;
  local.recovered_node.insert(local.recovered_node.end(), sent.more_nodes.begin(), sent.more_nodes.end());
  local.x0 = sent.x0;
  local.v0 =
      Eigen::Map<const Eigen::VectorXf>(sent.v0.data(), static_cast<Eigen::Index>(sent.v0.size())).cast<double>();
  local.basis = unpack_basis(sent.basis);
  const Eigen::Index r = sent.dof();
  local.mass = unpack_matrix(sent.mass, r);
  local.damping = unpack_matrix(sent.damping, r);
  local.stiffness = unpack_matrix(sent.stiffness, r);
  local.f0 = sent.f0;
  local.q_rate0 = sent.q_rate0;
  local.definite_tangent = sent.definite_tangent;
  local.reducer = sent.reducer;
  local.certified_error = sent.certified_error;
  local.fine = refine(sent);

  auto out = prepare(std::move(local), sent.scheme, metric_, tick_length(options_), options_.collision.backend,
                     model_.mesh().num_own_nodes(), static_cast<int>(surface_.triangles.size()), smoothing);
  out->scheme = sent.scheme;
  out->site = sent.site;
  out->places = sent.places;
  out->tool = sent.places[0];
  out->way_out = sent.way_out;
  out->linearized_tick = sent.linearized_tick;
  out->tool_radius = sent.tool_radius;
  out->body_x = positions_of(sent);
  out->unloaded =
      Eigen::Map<const Eigen::VectorXf>(sent.unloaded.data(), static_cast<Eigen::Index>(sent.unloaded.size()))
          .cast<double>();
  if (!surface_.embedded) {
    std::vector<double> radii;
    for (const TouchTool& tool : options_.tools) radii.push_back(tool.shape.radius);
    lay_apron(*out, surface_, model_.fixed_nodes(), radii, options_.collision.backend);
  }
  method_->prepare_method_data(*out, 1 / options_.global.rate_hz);

  LocalState& s = out->state;
  s.q = sent.q;
  s.q_rate = sent.q_rate;
  s.sliding = sent.sliding;
  s.overlap = sent.overlap;
  out->work.du.head(sent.du.size()) = sent.du;
  s.anchors.count = 0;
  for (const SentAnchor& a : sent.anchors) {
    Contact contact = a.contact;
    if (out->surface.fine)
      std::tie(contact.triangle, contact.bary) = out->facet_at({contact.triangle, contact.bary});
    else
      contact.triangle = out->local_facet(contact.triangle);
    if (contact.triangle < 0) continue;
    s.impulse[static_cast<std::size_t>(s.anchors.count)] = a.impulse;
    s.anchors.contacts[static_cast<std::size_t>(s.anchors.count++)] = contact;
  }
  if (sent.friction != friction_of_) {
    friction_of_ = sent.friction;
    friction_.reset();
    if (friction_of_) {
      ContactSettings contact = options_.contact;
      contact.mu_static = friction_of_->mu_static;
      contact.mu_kinetic = friction_of_->mu_kinetic;
      contact.stribeck = friction_of_->stribeck;
      std::vector<std::string> none;
      friction_ = std::make_shared<const SurfaceFriction>(scene_friction(contact, surface_, model_.mesh().x, none));
    }
  }
  out->friction = friction_;
  out->base_friction = friction_of_;
  out->material = sent.material;
  return out;
}

}  // namespace kt
