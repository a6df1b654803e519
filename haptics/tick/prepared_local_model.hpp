#pragma once
// A LocalModel with everything the haptic tick needs already allocated: made on the slow side, adopted by a pointer.
#include <memory>
#include <optional>

#include "collision/broad/triangle_index.hpp"
#include "collision/held/tool_contacts.hpp"
#include "collision/held/vertex_contacts.hpp"
#include "core/contact_surface/contact_surface.hpp"
#include "core/local/local_dynamics.hpp"
#include "core/local/reducer.hpp"
#include "haptics/contact/contact_solver.hpp"
#include "haptics/contact/friction.hpp"
#include "haptics/tick/apron_window.hpp"

namespace kt {

/// Of a tool that was found inside the body, and is pushed out over some ticks.
struct Overlap {
  double start = 0;  ///< that it was found to have [m]
  double time = 0;   ///< in which it is ended [s]
  double left = 0;   ///< of that, what is left [s]

  /// In this tick [m]. Starts and ends with no speed, so that the push is felt and its ends are not.
  double allowed() const noexcept;
};

/// What is known of a tool that is not in contact when the body is linearized.
constexpr int kNotLooked = -2, kOutside = -1;

/// Everything that changes at 1 kHz. A copy is a rollback point.
struct LocalState {
  VectorX q, q_rate;                         ///< reduced displacement [m] and velocity [m/s], (r)
  VectorX yielded;                           ///< how far the points of a fine patch have yielded [m], (3y)
  ContactSet anchors;                        ///< contacts held at the end of the last tick
  std::array<Vec3, kMaxContacts> impulse{};  ///< that they gave to the body then [N s]
  std::array<bool, kMaxTools> sliding{};     ///< of each tool: its contact that carried most slid in the last tick
  std::array<Overlap, kMaxTools> overlap{};  ///< of each tool
};

/// Room for one tick's intermediate values, under the stage that writes them; (p) patch vertices, (m) these and the
/// yielding points of a fine patch, (f) vertices of the contact surface, (r) reduced coordinates.
struct LocalWorkspace {
  // find_free_motion()
  VectorX patch_motion, motion_of;  ///< the patch's displacement [m], (3p), and of which coordinates it is, (r)
  VectorX x;                        ///< surface at the start of the tick [m], (3f)
  VectorX v_free, v_free_end;       ///< without contact: mean velocity over the tick, and at its end [m/s], (r)
  VectorX u_free;                   ///< the same of the patch [m/s], (3m)

  // Events within the tick: rewind_to(), find_impact().
  VectorX x_event, x_end;                                     ///< surface at the last event, and at the end [m], (3f)
  std::array<std::vector<unsigned char>, kMaxTools> ignored;  ///< of each tool: facets that it is held at, (facets)
  std::vector<int> candidates;                                ///< (facets)

  // resolve_contacts()
  VectorX x_guess;                      ///< surface at the end of the tick, guessed [m], (3f)
  VectorX motion, u;                    ///< velocity of the patch, (3m), and of the surface, (3f) [m/s]
  VectorX du;                           ///< change of the patch's velocity by contact [m/s], (3m)
  VectorX du_guess, step, step_before;  ///< iterates of du
  VectorX impulse, impulse_weighted;  ///< patch impulses now, and weighted by how long they moved the body [N s], (3m)
  CouplingRoom coupling;
  ContactMatrix contact_coupling;
  /// Of each tool, while it is held: facets that it may touch, ascending, how many (-1: not looked for), and features.
  std::array<std::vector<int>, kMaxTools> near_facets;  ///< (facets)
  std::array<int, kMaxTools> num_near{};
  VectorX x_near;                             ///< surface at the end of the tick that they were looked for at [m], (3f)
  std::array<double, kMaxTools> near_within;  ///< from the tool [m]
  std::array<bool, kMaxTools> near_is_ignored{};
  std::array<NearFeatures, kMaxTools> near;
  /// Of refined cells: vertices that stand for others beside them, since there are more than there is room for.
  std::array<ChosenVertices, kMaxTools> chosen;

  // step_paper()
  VectorX q_pushed, force;  ///< coordinates with the triangle on the tool [m], and the body's force there [N], (r)

  // carry_motion()
  VectorX x_recovered, v_recovered;  ///< (3 recovered)
  VectorX fitted, followed;          ///< a carried motion: in coordinates, (r), and of the nodes, (3 recovered)
};

/// What of a body's material can change while it is touched.
struct LiveMaterial {
  double young = 0;              ///< [Pa]
  double damping_mass = 0;       ///< [1/s]
  double damping_stiffness = 0;  ///< [s]
  bool operator==(const LiveMaterial&) const = default;
};

/// What one haptic method adds to a local model; it alone knows the type.
struct MethodData {
  virtual ~MethodData() = default;
};

struct PreparedLocalModel {
  LocalModel model;
  ContactSurface surface;  ///< what tools touch; contacts name its facets
  std::unique_ptr<LocalDynamics> dynamics;
  double yield_rate = 0;                   ///< of a fine patch: 1 / (retardation + tick) [1/s]
  std::unique_ptr<TriangleIndex> index;    ///< of the surface
  SparseMatrix patch_basis;                ///< first 3p rows of the basis
  PanelMatrix dense_patch_basis;           ///< the same when most entries are not zero: several times faster
  std::vector<std::array<bool, 3>> moves;  ///< per patch triangle: which of its vertices can move
  std::vector<int> recovered_row;          ///< (n) global node -> recovered row, -1
  std::vector<int> local_triangle;         ///< (surface triangles) global -> patch triangle, -1
  Vec3 tool = Vec3::Zero();                ///< where the first tool was when the body was linearized [m]
  VectorX body_x;                          ///< of the whole body then [m], (3n)
  /// Of the apron's surface too, for ticks in which a tool is so near to it; none: there is no apron.
  std::unique_ptr<TriangleIndex> wide_index;
  std::vector<int> apron_facet;  ///< (surface triangles) global -> facet of the apron, -1
  std::unique_ptr<ApronWindow> apron;
  const Surface* apron_surface = nullptr;  ///< the body's
  ApronRoom apron_room;
  VectorX unloaded;  ///< what the patch moves by when what touched it lets go [m], (3p); empty: not known
  /// How far each tool's place was from the patch's rim and the apron when the body was linearized [m], and where.
  std::array<double, kMaxTools> clear{};
  std::array<Vec3, kMaxTools> clear_from{};
  LocalScheme scheme = LocalScheme::implicit_euler;
  ContactSite site;                                            ///< that the patch was made for
  std::array<Vec3, kMaxTools> places{};                        ///< of the tools when the body was linearized [m]
  std::optional<Friction> base_friction;                       ///< that `friction` was made with, outside of regions
  std::array<int, kMaxTools> way_out{kNotLooked, kNotLooked};  ///< global triangle that a tool inside goes out through
  std::shared_ptr<const SurfaceFriction> friction;             ///< in use with this model; none: that of the method
  std::optional<LiveMaterial> material;                        ///< that it was made of; none: as at the start
  std::array<double, kMaxTools> tool_radius{-1, -1};           ///< [m] in use with this model; below 0: as it was
  double mobility = 0;  ///< of the patch vertex that gives way most: velocity per impulse in the metric [1/kg]
  std::unique_ptr<MethodData> data;  ///< by HapticMethod::prepare_method_data
  LocalState state;
  int linearized_tick = 0;  ///< at whose start the body was linearized
  VectorX adopted_q;        ///< of the state when it was taken into use [m], (r): for the energy of a swap
  bool caught_up = false;   ///< the state has been stepped to the present
  std::array<std::optional<Vec3>, kMaxTools> replayed_force{};  ///< of the last of these steps, on each tool in contact
  LocalWorkspace work;

  /// Motion of the patch vertices, (3p), for reduced coordinates or velocities, (r). No allocation.
  /// @param out  (3p); of a model with a fine patch (3m), of which the rest stays
  void recover_patch(const VectorX& reduced, VectorX& out) const noexcept;

  /// How fast the points of a fine patch yield on average over the tick [m/s], (3y): `out` is what follows the patch's.
  void yield_freely(VectorX& out) const noexcept;
  /// Adds what an impulse on each moving vertex makes these yield by: `impulse` and `out` (3m).
  void add_yield(const VectorX& impulse, VectorX& out) const noexcept;
  /// A place of the surface in this model's patch; facet -1: neither patch nor apron reaches.
  std::pair<int, Vec3> facet_at(const SurfacePlace& place) const noexcept;

  /// The facet with this number in the body, -1 where neither patch nor apron reaches.
  int local_facet(int global_facet) const noexcept {
    const int pieces = surface.facets_per_triangle(), global = global_facet / pieces;
    if (!apron_facet.empty() && apron_facet[global] >= 0) return apron_facet[global];
    const int triangle = local_triangle[global];
    return triangle < 0 ? -1 : triangle * pieces + global_facet % pieces;
  }
};

/// Mobility [1/kg] that is added where a contact's own is smaller, as on a clamped part: there the law has no answer.
/// That of 1 kg (1e6 N/m at 1 kHz), or where the body as a whole is stiffer, a thousandth of the patch's.
double softest_contact(const PreparedLocalModel& model) noexcept;

/// @param num_nodes, num_triangles  of the whole body
std::unique_ptr<PreparedLocalModel> prepare(LocalModel model, LocalScheme scheme, Metric metric, double h,
                                            const std::string& collision_backend, int num_nodes, int num_triangles,
                                            const Smoothing& smoothing = {});

/// Adds the surface around the patch to what tools touch: with `site`, `places`, `unloaded` and `body_x` of the model
/// as they are.
/// @param surface  borrowed      @param fixed_nodes  of the body
void lay_apron(PreparedLocalModel& model, const Surface& surface, std::span<const int> fixed_nodes,
               std::span<const double> tool_radii, const std::string& collision_backend);

/// The apron's triangles nearest to these places of the tools; contacts that are held stay on theirs. No allocation.
void move_apron(PreparedLocalModel& model, std::span<const Vec3> places) noexcept;

/// PreparedLocalModel::unloaded for the forces [N] that act on the patch, (3p); empty where the local model has no
/// rest.
VectorX find_unloaded(const PreparedLocalModel& model, const VectorX& patch_force);

}  // namespace kt
