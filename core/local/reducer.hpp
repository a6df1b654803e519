#pragma once
// Tangent model + contact site -> LocalModel. A reducer is a function; backends: reducers.def.
#include <functional>
#include <string>
#include <vector>

#include "core/base/backend.hpp"
#include "core/body/tangent_model.hpp"
#include "core/local/local_model.hpp"

namespace kt {

/// Where the tool is about to touch and how far it can get.
struct ContactSite {
  Vec3 centre = Vec3::Zero();         ///< a point on the surface [m]
  int triangle = 0;                   ///< the surface triangle that holds it
  double reach = 0;                   ///< radius around the centre and its way that the patch must cover [m]
  std::vector<ContactSite> others{};  ///< where further tools are: one patch covers them all, each with its own reach
  Vec3 way = Vec3::Zero();            ///< from the centre, straight, that the tool is expected to go [m]
};

class GradedBody;

struct ReduceOptions {
  int rings = 1;  ///< wall: graph rings of nodes around the node nearest to the site, besides the patch
  std::vector<double> shifts_hz = {0, 200};  ///< krylov: real rates that its motions answer
  bool slopes = true;                        ///< krylov: also how the answers to smooth loads change with the rate
  int echoes = 4;                            ///< krylov: for the slowest vibrations, three coordinates each
  double rank_tolerance = 3e-3;              ///< krylov: what nearly repeats other motions is dropped
  int modes = 60;                            ///< modal: lowest vibrations kept
  /// krylov: growth of the spacing of nodes that are followed with their distance from the patch (grading.hpp);
  /// 0: the whole body, exact and as costly.
  double grading = 0.6;
  /// krylov: kept by the caller for one body, so that a refresh goes on where the last one stopped; without it every
  /// reduction starts anew. Its own options hold, not `grading`.
  GradedBody* graded = nullptr;
};

/// The connected triangles around the site with a point within its reach, plus one ring (so that the normals of every
/// reachable vertex are complete); of several tools' sites all of them, each once. x: current node positions (3n).
/// @param smooth  contact on a triangle also moves its neighbours' vertices: they are in reach, too
SurfacePatch make_patch(const Surface& surface, const VectorX& x, const ContactSite& site, bool smooth = false);

/// The patch of these triangles of the surface, ascending.
SurfacePatch patch_of(const Surface& surface, std::vector<int> triangles, bool smooth = false);

/// Vertices that the patch of this site has, without those of others.
int count_patch_vertices(const Surface& surface, const VectorX& x, const ContactSite& site);

using ReduceFn = std::function<LocalModel(const TangentModel&, SurfacePatch, const ContactSite&, const ReduceOptions&)>;

std::vector<BackendInfo> reducer_backends();
ReduceFn find_reducer(const std::string& name);

/// LocalModel whose coordinates are the displacements of some free nodes, the rest held still: wall and full share it.
LocalModel restrict_to_nodes(const TangentModel& tangent, SurfacePatch patch, std::vector<int> dynamic_nodes);

}  // namespace kt
