// The patch and k rings of nodes around the site of each tool; the springs to everything outside are tied to an
// immovable wall. Paper section III. Differs from the paper: the whole patch moves, not only the nodes nearest to the
// contact, so that the tool cannot run off the moving part within one refresh.
#include "core/local/reducer.hpp"

namespace kt {
namespace {

int nearest_patch_node(const TangentModel& tangent, const SurfacePatch& patch, const Vec3& p) {
  int best = patch.global_node.front();
  for (int i : patch.global_node)
    if ((node(tangent.state.x, i) - p).squaredNorm() < (node(tangent.state.x, best) - p).squaredNorm()) best = i;
  return best;
}

}  // namespace

LocalModel reduce_wall(const TangentModel& tangent, SurfacePatch patch, const ContactSite& site,
                       const ReduceOptions& options) {
  std::vector<int> nodes{nearest_patch_node(tangent, patch, site.centre)};
  for (const ContactSite& other : site.others)
    if (const int near = nearest_patch_node(tangent, patch, other.centre); near != nodes.front()) nodes.push_back(near);
  std::vector<char> seen(tangent.f0.size() / 3, 0);
  for (const int i : nodes) seen[i] = 1;
  std::size_t begin = 0;
  for (int ring = 0; ring < options.rings; ++ring) {
    const std::size_t end = nodes.size();
    for (; begin < end; ++begin)  // neighbours in the graph of the stiffness
      for (SparseMatrix::InnerIterator it(tangent.dfdx, 3 * nodes[begin]); it; ++it)
        if (const int other = static_cast<int>(it.row()) / 3; !seen[other]) {
          seen[other] = 1;
          nodes.push_back(other);
        }
  }
  nodes.insert(nodes.end(), patch.global_node.begin(), patch.global_node.end());
  LocalModel out = restrict_to_nodes(tangent, std::move(patch), std::move(nodes));
  out.reducer = "wall";
  return out;
}

}  // namespace kt
