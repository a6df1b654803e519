// The body as springs and as finite elements: does it stand, how fast may it be stepped, how stiff is it against
// itself?
#include <cmath>

#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/body/node_weights.hpp"
#include "core/body/pieces.hpp"
#include "core/global/integrator.hpp"
#include "core/linear/sparse_solver.hpp"
#include "core/local/subspace.hpp"
#include "lab/check/mesh_work.hpp"
#include "lab/check/stages/models.hpp"
#include "models/embedded_model.hpp"

namespace kt {
namespace {

constexpr double kHeldShare = 0.2;  // of a piece's height, as `kilotouch drag`

std::vector<int> held_of_piece(const Mesh& body, const std::vector<int>& nodes, bool is_sheet) {
  Vec3 low = node(body.x, nodes[0]), high = low;
  for (const int i : nodes) {
    low = low.cwiseMin(Vec3(node(body.x, i)));
    high = high.cwiseMax(Vec3(node(body.x, i)));
  }
  const Vec3 size = high - low;
  int axis = 2, longest = 0;
  size.maxCoeff(&longest);
  if (is_sheet && size.z() < 0.25 * size[longest]) axis = longest;  // a lying sheet is held at one end
  std::vector<int> out;
  for (double share = kHeldShare; share < 0.7; share += 0.1) {
    out.clear();
    for (const int i : nodes)
      if (body.x[3 * i + axis] <= low[axis] + share * size[axis]) out.push_back(i);
    if (holds_still(body, out, size[longest])) break;
  }
  return out;
}

/// Largest over smallest stiffness of the free nodes' matrix, by the power method; infinity: it gives way somewhere.
double condition_of(const FreeBody& body) {
  constexpr int kTurns = 40;
  const auto solver = make_sparse_solver();
  if (!solver->factor(body.stiffness)) return std::numeric_limits<double>::infinity();
  MatrixX v(body.stiffness.rows(), 1), w;
  for (Eigen::Index i = 0; i < v.rows(); ++i) v(i, 0) = std::sin(1.0 + 2.3 * static_cast<double>(i));
  w = v.normalized();
  v = w;
  double stiffest = 0, softest = 0;
  for (int i = 0; i < kTurns; ++i) {
    v = body.stiffness.selfadjointView<Eigen::Lower>() * v;
    stiffest = v.norm();
    v /= stiffest;
    w = solver->solve(w);
    softest = 1 / w.norm();
    w *= softest;
  }
  return stiffest / softest;
}

// [1/s] an ear or a leg of soft material that hardly damps swings, and bounces off a tool that presses it: the truth,
// but not what the contact tests ask. This stops all that is slower than 3 Hz.
constexpr double kDamping = 40;

Scene body_scene(const std::string& model, double young, const std::vector<int>& held) {
  Scene out = default_scene();
  out.object.mesh = "body";
  out.object.fixed = {.below = {}, .box = {}, .nodes = held};
  out.object.model.type = model;
  out.object.model.young = young;
  out.object.model.damping.mass = kDamping;
  out.local.refine = std::string("off");  // it is the mesh's own surface that is checked
  out.tool.radius = 0.004;
  out.tool.path = {.press_drag = {}, .waypoints = std::vector<Waypoint>{{}}, .recording = {}, .hand = {}, .device = {}};
  return out;
}

void describe(const CheckBody& body, StageResult& out) {
  const DeformableModel& model = body.session->model().own();
  const FastestMode mode = fastest_mode(model, rest_state(model));
  const double step = make_integrator("symplectic_euler")->stable_step(mode);
  const double condition = condition_of(FreeBody(linearize(model, rest_state(model))));
  out.figures[body.model] = {{"nodes", model.mesh().num_nodes()},
                             {"held", model.fixed_nodes().size()},
                             {"stable_step", step},
                             {"condition", condition}};
  if (!std::isfinite(condition))
    out.lower(Verdict::degraded, body.model + ": nothing resists some motion of the body at rest");
  if (!(step > 0)) out.lower(Verdict::fail, body.model + ": no step is stable");
}

/// Vertices of an embedded surface that move no more than half with what is free.
std::vector<int> held_vertices(const Mesh& body, const std::vector<int>& held) {
  std::vector<char> is_held(static_cast<std::size_t>(body.num_own_nodes()), 0);
  for (const int i : held) is_held[static_cast<std::size_t>(i)] = 1;
  std::vector<int> out;
  for (int v = 0; v < body.embedded->num_vertices(); ++v) {
    const NodeWeights its = body.embedded->carried_by(v);
    double sum = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(its.count); ++k)
      if (is_held[static_cast<std::size_t>(its.node[k])] != 0) sum += its.weight[k];
    if (sum > 0.5) out.push_back(body.embedded->first + v);
  }
  return out;
}

}  // namespace

std::vector<int> held_nodes(const Mesh& body, bool is_sheet) {
  int count = 0;
  const std::vector<int> piece = pieces_of(body, count);
  std::vector<std::vector<int>> nodes(static_cast<std::size_t>(count));
  for (int i = 0; i < body.num_nodes(); ++i)
    if (piece[i] >= 0) nodes[piece[i]].push_back(i);
  std::vector<int> out;
  for (const auto& of_piece : nodes) {
    const auto held = held_of_piece(body, of_piece, is_sheet);
    out.insert(out.end(), held.begin(), held.end());
  }
  std::sort(out.begin(), out.end());
  return out;
}

void check_models(MeshWork& work, StageResult& out) {
  const bool is_lattice = work.solid.embedded != nullptr;
  work.held = held_nodes(is_lattice ? without_embedded(work.solid) : work.solid, work.shell > 0);
  work.still = is_lattice ? held_vertices(work.solid, work.held) : work.held;
  if (static_cast<int>(work.held.size()) >= work.solid.num_own_nodes())
    return out.lower(Verdict::fail, "so few nodes that holding the lowest holds all", work.origin);
  for (const char* model : {"msd", "fem"}) {
    if (is_lattice && std::string(model) == "msd") continue;  // a surface that is run is of finite elements
    if (work.solid.tetrahedra.empty() && std::string(model) == "fem") {
      out.figures["fem"] = nullptr;  // a sheet has no inside for finite elements
      continue;
    }
    CheckBody body{model, nullptr};
    try {
      body.session = std::make_unique<Session>(body_scene(model, work.options.young, work.held), work.solid);
      describe(body, out);
      work.bodies.push_back(std::move(body));
    } catch (const std::runtime_error& e) {
      out.lower(Verdict::fail, text(model, ": ", e.what()), work.origin);
    }
  }
  const bool quick = work.options.quick;
  work.spots = find_contact_spots(work.solid, work.still,
                                  {.count = quick ? 2 : 8, .tried = quick ? 800 : 3000, .shell = work.shell});
  out.figures["spots"] = work.spots.size();
  if (work.spots.empty())
    return out.lower(Verdict::degraded, "no place that is free to move can be reached by a sphere of 1 mm",
                     work.origin);
  const auto least = std::ranges::min_element(work.spots, {}, &ContactSpot::depth);
  out.figures["tool_radius"] = least->radius;
  out.figures["least_depth"] = least->depth;
}

}  // namespace kt
