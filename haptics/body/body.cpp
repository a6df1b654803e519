#include "haptics/body/body.hpp"

#include <numbers>

#include "core/body/embedded_surface.hpp"
#include "core/local/reducer.hpp"
#include "haptics/body/bending.hpp"
#include "haptics/body/body_ranges.hpp"
#include "haptics/body/check_mesh.hpp"
#include "haptics/body/settle.hpp"
#include "haptics/refresh/kept_set_up.hpp"
#include "models/model.hpp"
#include "self_contact/crossings.hpp"
#include "self_contact/touching_model.hpp"

namespace kt {
namespace {

/// object.model.element, and what auto stands for: in a lattice cells that bend as their material says.
std::string element_of(const SceneModel& model, const Mesh& mesh) {
  if (model.element != "auto") return model.element;
  if (!mesh.embedded) return "tet4";
  return lattice_element(mesh, model.poisson);
}

ModelOptions model_options(const SceneObject& object, const SceneModel& m, const Mesh& mesh,
                           const std::vector<int>& fixed_nodes) {
  ModelOptions out;
  out.young = m.young;
  out.poisson = m.poisson;
  out.density = m.density;
  out.damping_mass = m.damping.mass;
  out.damping_stiffness = m.damping.stiffness;
  out.stiffness = m.stiffness;
  out.damper = m.damper;
  out.least_volume = m.least_volume;
  out.material = m.material;
  out.element = element_of(m, mesh);
  out.consistent_mass = m.consistent_mass;
  out.rayleigh = m.damping.law == "rayleigh";
  out.gravity = object.gravity;
  for (const SceneInclusion& i : m.inclusions) out.inclusions.push_back({i.center, i.radius, i.stiffer});
  out.fixed_nodes = fixed_nodes;
  return out;
}

}  // namespace

Body::Body(Body&&) noexcept = default;
Body::~Body() = default;

Body::Body(const BodyOptions& options) : options_(options) {
  check_ranges(options);
  std::vector<std::string> notes;
  Mesh mesh = load_body_mesh(options, notes, &mesh_unit_);
  for (std::string& note : notes) findings_.push_back({std::move(note), {}, Finding::Weight::note});
  build(std::move(mesh));
}

Body::Body(Mesh mesh, const BodyOptions& options) : options_(options) {
  check_ranges(options);
  options_.object.mesh = given_mesh_name(options.object);
  std::vector<std::string> notes;
  if (!options.object.layers) check_and_orient(mesh, options_.object.mesh, &notes);  // layers are as of a file
  mesh = in_lattice(std::move(mesh), options_.object, options_.global.rate_hz, notes);
  for (std::string& note : notes) findings_.push_back({std::move(note), {}, Finding::Weight::note});
  build(std::move(mesh));
}

Body::Body(std::unique_ptr<DeformableModel> model, const BodyOptions& options)
    : options_(options), model_(std::move(model)), is_own_(true) {
  if (!model_) throw InputError("body: there is no model");
  check_ranges(options);
  make_surface_and_contact();
  start_ = rest_state(*model_);
}

void Body::build(Mesh mesh) {
  const std::vector<int> fixed = find_fixed_nodes(mesh, options_.object.fixed);
  if (fixed.empty())
    findings_.push_back({"object.fixed: nothing is clamped, the body floats", {}, Finding::Weight::note});
  const SceneModel& material = options_.object.model;
  require_backend("object.model.type", material.type, model_backends());
  const ModelOptions options = model_options(options_.object, material, mesh, fixed);
  model_ = make_model(material.type, std::move(mesh), options);
  make_surface_and_contact();
  start_ = settle(options_, *model_, self_contact_.get(), findings_);
}

std::unique_ptr<DeformableModel> Body::model_like(const SceneModel& material) const {
  if (is_own_) throw InputError("object.model: the body's model is the caller's own; its material is not a setting");
  return make_model(material.type, Mesh(model_->mesh()),
                    model_options(options_.object, material, model_->mesh(), model_->fixed_nodes()));
}

void Body::make_surface_and_contact() {
  kept_set_up_ = std::make_unique<KeptSetUp>();
  surface_ = std::make_unique<Surface>(make_surface(model_->mesh(), options_.ridge_deg * std::numbers::pi / 180));
  if (!options_.global.self_contact) return;
  const SelfContactSettings& s = *options_.global.self_contact;
  self_contact_ = std::make_unique<SelfContact>(*model_, SelfContactOptions{.reach = s.reach.value_or(0),
                                                                            .stiffness = s.stiffness.value_or(0),
                                                                            .mu = s.mu,
                                                                            .creep = s.creep,
                                                                            .backend = options_.backend});
  const auto found = find_crossings(*self_contact_, surface_->triangles, model_->mesh().x);
  if (found.empty()) return;
  const Crossing& first = found.front();
  throw InputError(text("global.self_contact: ", options_.object.mesh,
                        ": the surface crosses or touches itself at the start in ", found.size(),
                        found.size() == 1 ? " pair" : " pairs", " of triangles: first at (", first.at.x(), ", ",
                        first.at.y(), ", ", first.at.z(), "), triangles ", first.triangles[0], " ", first.triangles[1],
                        "; move the pieces apart"));
}

}  // namespace kt
