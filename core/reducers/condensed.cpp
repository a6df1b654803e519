// The patch, with everything else following it statically: K_pp - K_pe K_ee^-1 K_ep and the mass that goes with it
// (Guyan 1965). Exact at rest; too heavy above a few hertz.
#include "core/subspace.hpp"

namespace kt {

LocalModel reduce_condensed(const TangentModel& tangent, SurfacePatch patch, const ContactSite&, const ReduceOptions&) {
  const FreeBody body(tangent);
  const MatrixX V = orthonormal_motions(body.mass, responses(body, patch, {0}), 0);
  LocalModel out = confine(tangent, body, std::move(patch), V);
  out.reducer = "condensed";
  return out;
}

}  // namespace kt
