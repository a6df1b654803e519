#pragma once
// A body ready to be reduced: what the tests of reducers and local dynamics start from.
#include "core/local/reducer.hpp"
#include "models/model.hpp"
#include "tests/support/contact_site.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {

/// A damped block of cells^3 cubes on a clamped base, deformed and moving, linearized there; the site is in the middle
/// of its top.
struct LinearizedBlock {
  static constexpr double edge = 0.01;  ///< of a cube [m]
  /// @param noise  how far it is deformed, in edges
  explicit LinearizedBlock(int cells = 3, const std::string& type = "msd", double noise = 0.05)
      : mesh(kuhn_block(cells, cells, cells, edge)) {
    model = make_model(
        type, mesh,
        {.young = 5e3, .damping_mass = 1, .damping_stiffness = 2e-3, .fixed_nodes = nodes_below(mesh, 1e-6)});
    State state = rest_state(*model);
    state.t = 0.25;
    for (int i = 0; i < mesh.num_nodes(); ++i)
      if (mesh.x[3 * i + 2] > 1e-6) {
        node(state.x, i) += noise * edge * random_vector(3, static_cast<unsigned>(i));
        node(state.v, i) = 0.4 * noise * random_vector(3, static_cast<unsigned>(1000 + i));
      }
    tangent = linearize(*model, state, TangentKind::definite);
    surface = make_surface(mesh);
    const Vec3 top(0.5 * cells * edge, 0.5 * cells * edge, cells * edge);
    site = site_near(surface, mesh.x, top, 0.4 * edge);
  }
  SurfacePatch patch() const { return make_patch(surface, tangent.state.x, site); }
  LocalModel reduce(const std::string& name, const ReduceOptions& options = {}) const {
    return find_reducer(name)(tangent, make_patch(surface, tangent.state.x, site), site, options);
  }
  Mesh mesh;
  std::unique_ptr<DeformableModel> model;
  TangentModel tangent;
  Surface surface;
  ContactSite site;
};

}  // namespace kt
