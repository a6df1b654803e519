// Every free node of the body.
#include <numeric>

#include "core/local/reducer.hpp"

namespace kt {

LocalModel reduce_full(const TangentModel& tangent, SurfacePatch patch, const ContactSite&, const ReduceOptions&) {
  std::vector<int> nodes(tangent.f0.size() / 3);
  std::iota(nodes.begin(), nodes.end(), 0);
  LocalModel out = restrict_to_nodes(tangent, std::move(patch), std::move(nodes));
  out.reducer = "full";
  return out;
}

}  // namespace kt
