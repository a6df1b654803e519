#include "tests/support/haptics_body.hpp"

#include "collision/shape/closest_point.hpp"
#include "core/base/types.hpp"
#include "haptics/tick/contact_check.hpp"
#include "io/mesh/mesh_io.hpp"
#include "models/model.hpp"
#include "models/msd/springs.hpp"

namespace kt {
namespace {

std::unique_ptr<DeformableModel> make_body(const SoftBlockOptions& o) {
  Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/" + o.mesh);
  const Bounds box = bounds(mesh);
  if (mesh.tetrahedra.empty()) mesh = add_inner_layers(mesh, 1, o.layer);
  ModelOptions options;
  options.young = o.young;
  options.damping_mass = 5;
  options.damping_stiffness = 2e-3;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (mesh.x[3 * i + 2] <= box.min.z() + o.clamped * box.size().z()) options.fixed_nodes.push_back(i);
  return make_model("msd", std::move(mesh), options);
}

}  // namespace

SoftBlock::SoftBlock(const SoftBlockOptions& o)
    : options(o), model(make_body(o)), surface(make_surface(model->mesh())) {}

std::unique_ptr<PreparedLocalModel> SoftBlock::local_model(const State& state, const Vec3& p, int frame) const {
  ContactSite site{p, 0, options.reach};
  double nearest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const Triangle& v = surface.triangles[t];
    const auto at = closest_point_on_triangle(p, node(state.x, v[0]), node(state.x, v[1]), node(state.x, v[2]));
    if (at.distance_sq >= nearest) continue;
    nearest = at.distance_sq;
    site.centre = at.point;
    site.triangle = t;
  }
  LocalModel local = find_reducer(options.reducer)(linearize(*model, state), make_patch(surface, state.x, site), site,
                                                   ReduceOptions{options.rings});
  local.frame = frame;
  return prepare(std::move(local), options.scheme, options.metric, options.h, "brute_force", model->mesh().num_nodes(),
                 static_cast<int>(surface.triangles.size()));
}

std::unique_ptr<PreparedLocalModel> SoftBlock::local_model(const Vec3& p) const {
  return local_model(rest_state(*model), p);
}

Press::Press(const SoftBlock& body, const ToolShape& tool, const std::string& law, const Friction& friction,
             const Vec3& start)
    : local_(tool, body.options.h, make_contact_solver(law, friction), body.options.blend), tool_(start) {
  local_.adopt(body.local_model(start));
}

LocalFrame Press::go_to(const Vec3& place, const Vec3& turn) {
  const Quaternion next = rotation(turn);
  const LocalFrame frame = local_.step({tool_, place, turn_, next});
  tool_ = place;
  turn_ = next;
  return frame;
}

LocalFrame Press::move(const Vec3& place, int ticks) {
  LocalFrame last;
  move(place, ticks, [&](const LocalFrame& frame) { last = frame; });
  return last;
}

VectorX Press::patch_positions() const {
  const PreparedLocalModel& m = local_.model();
  return m.model.x0.head(m.patch_basis.rows()) + m.patch_basis * m.state.q;
}

double Press::penetration() const {
  return penetration_depth(local_.model().model.patch, patch_positions(), local_.tool(), tool_, turn_);
}

}  // namespace kt
