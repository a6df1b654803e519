// What the body does under forces on the patch that grow as e^(s t), for a few rates s: exact there, and close between and
// on the frequencies near them where the body is damped (rational Krylov; Grimme 1997, Antoulas 2005, chapter 11).
#include "core/subspace.hpp"

namespace kt {

LocalModel reduce_krylov(const TangentModel& tangent, SurfacePatch patch, const ContactSite&,
                         const ReduceOptions& options) {
  const FreeBody body(tangent);
  const MatrixX V = orthonormal_motions(body.mass, responses(body, patch, options.shifts_hz), options.rank_tolerance);
  LocalModel out = confine(tangent, body, std::move(patch), V);
  out.reducer = "krylov";
  return out;
}

}  // namespace kt
