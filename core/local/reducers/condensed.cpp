// The patch, with everything else following it statically: K_pp - K_pe K_ee^-1 K_ep and the mass that goes with it
// (Guyan 1965). Exact at rest; too heavy above a few hertz. The same motions as krylov's at the one shift 0.
#include <algorithm>

#include "core/local/reducer.hpp"

namespace kt {
namespace {

/// Motions at rest are long where the body bends as a whole: what two tools squeeze between them is a thousandth of
/// that.
constexpr double kRankAtRest = 1e-4;  // [-]

}  // namespace

LocalModel reduce_condensed(const TangentModel& tangent, SurfacePatch patch, const ContactSite& site,
                            const ReduceOptions& options) {
  ReduceOptions at_rest = options;
  at_rest.shifts_hz = {0};
  at_rest.slopes = false;
  at_rest.echoes = 0;
  at_rest.rank_tolerance = std::min(options.rank_tolerance, kRankAtRest);
  LocalModel out = find_reducer("krylov")(tangent, std::move(patch), site, at_rest);
  out.reducer = "condensed";
  return out;
}

}  // namespace kt
