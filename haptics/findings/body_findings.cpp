// The body's own: its steps, its tangent, elements that turned over, a surface that passes through itself; its pace.
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "haptics/cells/mesh_cures.hpp"
#include "haptics/findings/kinds.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "haptics/refresh/refresh_cost.hpp"
#include "haptics/watch/tick_words.hpp"

namespace kt {
namespace {

using Weight = Finding::Weight;

/// The material that an exact tangent stays definite with comes first, where the scene has another.
std::vector<Cure> firmer(const SceneModel& m) {
  std::vector<Cure> out{advise("press less deep")};
  if (m.type != "fem" || m.material != "neo_hookean")
    out.insert(out.begin(), advise("set object.model.type to fem with object.model.material neo_hookean"));
  return out;
}

void find_in_steps(const Scene& scene, const SessionResult& result, std::vector<Finding>& out) {
  const StepStatistics& steps = result.global_steps;
  if (steps.projected + steps.not_converged > 0)
    out.push_back(
        Finding{told("global steps: ", steps.projected, " of ", steps.iterations,
                     " systems were not positive definite and were solved with the element stiffness projected, and ",
                     steps.not_converged, " of ", result.refresh.global_ms.size(), " steps did not converge")}
            .at("global.integrator", steps.projected + steps.not_converged, 0));
  if (result.refresh.definite_tangents == 0) return;
  out.push_back(
      indefinite_finding(result.refresh.definite_tangents, result.refreshes.size(), firmer(scene.object.model)));
}

void find_in_elements(const Session& session, const SessionResult& result, std::vector<Finding>& out) {
  if (auto found = inverted_finding(result.refresh.inverted, session.model().mesh().tetrahedra.size(),
                                    {advise("press less deep"), finer_cells(session.scene())}))
    out.push_back(*std::move(found));
}

void find_self_crossing(const SessionResult& result, std::vector<Finding>& out) {
  if (result.self_contact && result.self_contact->crossings > 0)
    out.push_back(crossed_finding(result.self_contact->crossings));
  if (result.self_contact && result.self_contact->pressed > 0)
    out.push_back(pressed_finding(result.self_contact->pressed, result.self_contact->stiffness));
  const SelfCrossing& own = result.self_crossing;
  if (own.pairs > 0)
    out.push_back(
        Finding{told("the body passes through itself: ", own.pairs, own.pairs == 1 ? " pair" : " pairs",
                     " of triangles cross at t = ", own.t, " s, one at (", own.at.x(), ", ", own.at.y(), ", ",
                     own.at.z(), ") m: there the force is too small"),
                {set_to("global.self_contact", "{}", "with global.integrator newton_euler, and slower global steps"),
                 advise("press less deep")}}
            .at("global.self_contact", own.pairs, 0));
}

Cure more_refined_nodes(const Scene& scene) {
  return set_to("local.refine_nodes",
                text(std::clamp(2 * scene.local.refine_nodes, LocalSettings().refine_nodes, 5000)));
}

/// A contact so large that no zone around it has few enough nodes, as under a long capsule that lies.
void find_missing_refinement(const Session& session, const SessionResult& result, std::vector<Finding>& out) {
  constexpr double kSome = 0.1;  // of the refreshes
  const std::size_t with = result.refresh.fineness.size(), all = result.refreshes.size();
  const bool has_to = choose_refine(session.model(), session.surface(), session.options(),
                                    session.scene().global.self_contact.has_value())
                          .refines;
  if (!has_to || !(static_cast<double>(all - with) > kSome * static_cast<double>(all))) return;
  out.push_back(Finding{told("no cells could be refined under the tool in ", all - with, " of ", all,
                             " refreshes, the contact is too large for local.refine_nodes, or has more places than a "
                             "tick holds: there the force is that of "
                             "the cells as they are, which is larger"),
                        {more_refined_nodes(session.scene()), advise("take a shorter or a smaller tool")}}
                    .at("local.refine_nodes", static_cast<double>(all - with), kSome * static_cast<double>(all)));
}

/// Between nodes that are so far apart a tool is not held: two thirds to 1.2 of the continuum's force under a tool on
/// a block, where all that yields is refined. Where the body gives way, less.
void find_coarse_refinement(const Session& session, const SessionResult& result, std::vector<Finding>& out) {
  const Scene& scene = session.scene();
  constexpr double kCoarse = 1.65;                       // contact radii
  constexpr double kSome = 0.1;                          // of the refreshes
  constexpr double kTooSoft = 1.0 / 3, kTooStiff = 0.2;  // of the cells' part of the yield
  const std::vector<double>& fineness = result.refresh.fineness;
  long coarse = 0;
  double largest = 0, share = 0;
  for (std::size_t i = 0; i < fineness.size(); ++i) {
    const double its = i < result.refresh.refined_share.size() ? result.refresh.refined_share[i] : 1;
    if (!(fineness[i] > kCoarse && kTooSoft * its > kNoticeableForce)) continue;
    ++coarse;
    largest = std::max(largest, fineness[i]);
    share = std::max(share, its);
  }
  if (!(static_cast<double>(coarse) > kSome * static_cast<double>(fineness.size()))) return;
  Finding found{told("refined cells under the tool were up to ", largest, " contact radii large, above ", kCoarse,
                     " in ", coarse, " of ", fineness.size(), " refreshes where they had up to ", in_percent(share),
                     " of the yield: there the force may be ", 1 - kTooSoft * share, " to ", 1 + kTooStiff * share,
                     " times that of the continuum")};
  // Late models have fewer nodes, and more of them would make models later still.
  const double rate = std::round(2.0 / 3 * scene.global.rate_hz);
  if (models_come_late(session.options()))
    found.cures = {
        {"global.rate_hz", text(rate), told("set global.rate_hz to ", rate, " and move the tool half as fast")}};
  else
    found.cures = {more_refined_nodes(scene)};
  out.push_back(std::move(found).at("local.refine_nodes", largest, kCoarse));
}

/// The wall clock does not wait for a body that takes longer than its interval.
void find_lag(const Scene& scene, const SessionResult& result, std::vector<Finding>& out) {
  constexpr double kEnough = 0.8;
  if (result.lateness_us.empty() || result.tools[0].frames.empty()) return;
  const double seconds = static_cast<double>(result.tools[0].frames.size()) / scene.local.rate_hz;
  const double reached = static_cast<double>(result.refresh.global_ms.size()) / seconds;
  if (reached >= kEnough * scene.global.rate_hz) return;
  out.push_back(Finding{
      told("the body was refreshed at ", reached, " Hz of global.rate_hz ", scene.global.rate_hz, " (see real time)"),
      {},
      Weight::note}
                    .at("global.rate_hz", reached, kEnough * scene.global.rate_hz));
}

}  // namespace

void find_in_body(const Session& session, const SessionResult& result, std::vector<Finding>& out) {
  find_in_steps(session.scene(), result, out);
  find_in_elements(session, result, out);
  find_self_crossing(result, out);
  find_missing_refinement(session, result, out);
  find_coarse_refinement(session, result, out);
  find_lag(session.scene(), result, out);
}

}  // namespace kt
