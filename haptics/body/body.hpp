#pragma once
// The touched body, a deformable model with its surface, hanging in its weight. Borrowed by every Touch of it.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/finding.hpp"
#include "core/body/deformable_model.hpp"
#include "io/scene/scene.hpp"

namespace kt {

class KeptSetUp;  // haptics/refresh/kept_set_up.hpp
class SelfContact;
struct Surface;  // core/body/surface.hpp

/// Options of a body besides its mesh.
struct BodyOptions {
  SceneObject object{};          ///< material, clamped part, weight. Its mesh file is read where no mesh is given
  GlobalSettings global{};       ///< self_contact, and the solver of the equilibrium that the body starts in
  double ridge_deg = 60;         ///< [deg] convex edges of a smooth surface that turn by more stay sharp
  std::string backend = "auto";  ///< collision.backend, for contact with itself
  std::function<std::string(const std::string& path)> read_file{};  ///< as in load_mesh(), the file system by default
};

/// Options of a scene's body.
/// @param read_file  gives a file's bytes, the file system by default
BodyOptions body_options(const Scene& scene, std::function<std::string(const std::string& path)> read_file = {});

class Body {
 public:
  /// Made from object.mesh. Throws InputError for faults of the file or a value.
  explicit Body(const BodyOptions& options);
  /// Made from a mesh in metres, whose tetrahedra may be turned either way. A surface is to be filled() before. Throws
  /// InputError for a mesh that is none, as check_and_orient().
  Body(Mesh mesh, const BodyOptions& options);
  /// Made from one's own model. Its surface is that of model->mesh(). Of `options` only the parts without weight count,
  /// self-contact and ridge_deg. It starts undeformed.
  explicit Body(std::unique_ptr<DeformableModel> model, const BodyOptions& options = {});
  Body(Body&&) noexcept;
  ~Body();

  const DeformableModel& model() const { return *model_; }
  const Surface& surface() const { return *surface_; }
  SelfContact* self_contact() const { return self_contact_.get(); }  ///< null where the body passes through itself
  const State& start() const { return start_; }                      ///< at rest, hanging in its weight
  double mesh_unit() const { return mesh_unit_; }  ///< unit of the mesh file [m], 1 for a mesh that is given in metres
  const std::vector<Finding>& findings() const { return findings_; }  ///< while it was loaded and settled
  const BodyOptions& options() const { return options_; }

  /// Results of the set-up of this body's refreshers, for the next one that begins in the same way.
  KeptSetUp* kept_set_up() const { return kept_set_up_.get(); }
  /// The same pointer for this body alone, as long as somebody holds it.
  std::shared_ptr<const void> identity() const { return kept_set_up_; }

  bool is_own() const { return is_own_; }  ///< the model is the caller's

  /// The same mesh with another material. Throws InputError where the model is the caller's own.
  std::unique_ptr<DeformableModel> model_like(const SceneModel& material) const;

 private:
  void build(Mesh mesh);
  void make_surface_and_contact();
  BodyOptions options_;
  std::unique_ptr<DeformableModel> model_;
  bool is_own_ = false;  // the caller's
  std::unique_ptr<SelfContact> self_contact_;
  std::unique_ptr<Surface> surface_;
  std::shared_ptr<KeptSetUp> kept_set_up_;
  State start_;
  std::vector<Finding> findings_;
  double mesh_unit_ = 1;
};

/// Loads, scales and, where the model needs it, repairs and tetrahedralizes the mesh. Changes of the mesh are appended
/// to `notes`.
/// @param unit  unit of the file [m]
Mesh load_body_mesh(const BodyOptions& options, std::vector<std::string>& notes, double* unit = nullptr);

/// The lattice that `object` asks for in the place of a surface in metres. A mesh that is to stay is returned as it is.
/// @param rate_hz  rate of refreshes, which bounds the number of nodes
Mesh in_lattice(Mesh mesh, const SceneObject& object, double rate_hz, std::vector<std::string>& notes);

constexpr const char* kGivenMesh = "-";  ///< SceneObject::mesh of a scene whose mesh does not come from a file

/// For messages about a mesh that does not come from a file.
std::string given_mesh_name(const SceneObject& object);

/// A surface in metres with the tetrahedra or inner layers that `object` asks for. A solid as it is, with all
/// tetrahedra turned to positive volume. Throws InputError for a mesh that is none, as check_and_orient().
Mesh filled(Mesh mesh, const SceneObject& object);

/// Nodes that the scene clamps, ascending. Throws InputError when a choice holds no node or all of them.
std::vector<int> find_fixed_nodes(const Mesh& mesh, const SceneFixed& fixed);

}  // namespace kt
