// What the body does under forces on the patch that grow as e^(s t), for a few rates s: nearly exact there, and close
// between and on the frequencies near them where the body is damped (rational Krylov; Grimme 1997, Antoulas 2005,
// chapter 11).
#include "core/base/stages.hpp"
#include "core/local/graded_body.hpp"

namespace kt {

LocalModel reduce_krylov(const TangentModel& tangent, SurfacePatch patch, const ContactSite&,
                         const ReduceOptions& options) {
  GradedBody anew({.slope = options.grading});
  GradedBody& graded = options.graded ? *options.graded : anew;
  const bool whole = !options.graded && options.grading == 0;
  const FreeBody& body = whole ? graded.update_whole(tangent) : graded.update(tangent, patch);
  // Slow vibrations are felt far beyond their length: hardly any of them is dropped.
  const int firm = 3 * options.echoes;
  if (is_one_pass(options.rank_tolerance, firm)) {
    ConfinedMotions motions =
        confined_responses(body, patch, options.shifts_hz, graded.solver(), options.echoes, options.slopes);
    MatrixX combination;
    const Stage stage("confine");
    if (auto out = confine(tangent, body, patch, motions, options.rank_tolerance, firm, combination)) {
      graded.set_motions({std::move(motions.X), std::move(combination)});
      out->reducer = "krylov";
      return std::move(*out);
    }
  }
  RowMatrix V = orthonormal_motions(
      body.mass, responses(body, patch, options.shifts_hz, graded.solver(), options.echoes, options.slopes),
      options.rank_tolerance, firm);
  // Where all is clamped and at rest nothing moves; a local model of one still motion is one all the same.
  if (V.cols() == 0) V = orthonormal_motions(body.mass, MatrixX::Ones(body.force.size(), 1), 0.5);
  MatrixX combination;
  LocalModel out = confine(tangent, body, std::move(patch), V, &combination);
  graded.set_motions({std::move(V), std::move(combination)});
  out.reducer = "krylov";
  return out;
}

}  // namespace kt
