// The measures of a run's forces, where a hand would notice.
#include <cmath>

#include "core/base/error.hpp"
#include "haptics/cells/mesh_cures.hpp"
#include "haptics/findings/kinds.hpp"
#include "haptics/refresh/reducer_choice.hpp"

namespace kt {
namespace {

bool is_ours(const Scene& scene) { return scene.contact.law == "coulomb" && scene.local.method == "multirate"; }

Cure to_ours(const Scene& scene) {
  if (scene.local.method == "multirate") return set_to("contact.law", "coulomb");
  if (scene.contact.law == "coulomb") return set_to("local.method", "multirate");
  return advise("set contact.law to coulomb and local.method to multirate");
}

std::vector<Cure> smoother(const Scene& scene) {
  std::vector<Cure> out;
  if (scene.contact.surface == "flat" && is_ours(scene) && scene.object.body != "lattice")
    out.push_back(set_to("contact.surface", "loop", "stiffer by a quarter where no cells are refined"));
  out.push_back(finer_cells(scene));
  return out;
}

Finding never_touched() {
  return Finding{"the tool never touched the body",
                 {advise("look at tool.path (press_drag.at, waypoints), object.size and object.scale")}}
      .at("tool.path", 0);
}

}  // namespace

std::vector<Finding> find_in_force(const ForceMetrics& f, const Scene& scene, const RealTime& pace) {
  const int touching = f.ticks_stick + f.ticks_slide + f.ticks_frictional_slide;
  if (touching == 0) return {never_touched()};
  std::vector<Finding> out;
  if (f.lost_contacts > 0)
    out.push_back(Finding{told("contact ended ", f.lost_contacts, f.lost_contacts == 1 ? " time" : " times",
                               " while the tool did not move away"),
                          is_ours(scene) ? sooner(scene, pace) : std::vector{to_ours(scene)}}
                      .at("", f.lost_contacts, 0));
  if (f.crossing_jump > kNoticeableForce)
    out.push_back(Finding{told("the force jumps by up to ", in_percent(f.crossing_jump),
                               " of its mean in one tick at an edge of the mesh"),
                          smoother(scene)}
                      .at("", f.crossing_jump, kNoticeableForce));
  if (f.refresh_jump > kNoticeableForce)
    out.push_back(Finding{told("the force jumps by up to ", in_percent(f.refresh_jump),
                               " of its mean in one tick when a local model comes in"),
                          scene.local.blend_ms > 0 ? sooner(scene, pace) : std::vector{set_to("local.blend_ms", "12")}}
                      .at("", f.refresh_jump, kNoticeableForce));
  if (f.buzz > kNoticeableForce)
    out.push_back(Finding{told("the force buzzes above 100 Hz by ", in_percent(f.buzz), " of its mean"),
                          is_ours(scene)
                              ? std::vector{advise(scene.object.model.type == "msd" && scene.object.model.damper
                                                       ? "raise object.model.damper"
                                                       : "raise object.model.damping.stiffness"),
                                            finer_cells(scene)}
                              : std::vector{to_ours(scene)}}
                      .at("", f.buzz, kNoticeableForce));
  return out;
}

void find_in_forces(const Scene& scene, const SessionResult& result, const MeasuredRun& measured,
                    std::vector<Finding>& out) {
  if (result.tools[0].missed_impacts > 0 && !keeps_outside(scene))
    out.push_back(
        Finding{told("in ", result.tools[0].missed_impacts, " ticks without contact the tool ended inside the body"),
                is_ours(scene) ? sooner(scene, measured.pace) : std::vector{to_ours(scene)}}
            .at("tool", result.tools[0].missed_impacts, 0));
  for (std::size_t k = 0; k < measured.forces.size(); ++k)
    for (Finding& found : find_in_force(measured.forces[k], scene, measured.pace)) {
      found.what = which(k) + found.what;
      if (found.where.empty()) found.where = tool_key(k);
      out.push_back(std::move(found));
    }
  if (is_ours(scene))
    if (auto wrong = find_wrong_local_model(result.expected_force_error, result.reducer, scene.local.reducer))
      out.push_back(*std::move(wrong));
  const double bent = percentile(result.refresh.linearization_error, 0.5);
  if (!(bent > kNoticeableForce)) return;
  Finding found{told("outside the linear range: at the end of an interval the local model's force is off by ",
                     in_percent(bent), " (median)")};
  found = std::move(found).at("global.rate_hz", bent, kNoticeableForce);
  found.cures =
      scene.global.early_refresh ? sooner(scene, measured.pace) : std::vector{set_to("global.early_refresh", "true")};
  out.push_back(std::move(found));
}

}  // namespace kt
