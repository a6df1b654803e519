#include "haptics/study/run_doubts.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace kt {
namespace {

// People notice forces that differ by 7 to 10 %; a step within a tick more than a slow change.
constexpr double kNoticeable = 0.10;

std::string percent(double share) {
  char out[32];
  std::snprintf(out, sizeof out, "%.2g %%", 100 * share);
  return 100 * share < 100 ? out : text(std::lround(100 * share), " %");
}

std::string smoother(const Scene& scene) {
  return scene.contact.surface == "flat" && scene.local.method == "multirate" && scene.contact.law == "coulomb"
             ? "set contact.surface to loop (stiffer by a quarter), or take finer cells "
               "(object.tetrahedralize.max_edge)"
             : "take finer cells (object.tetrahedralize.max_edge)";
}

std::string sooner(const Scene& scene) {
  return text("set global.rate_hz to ", 2 * scene.global.rate_hz, ", or move the tool more slowly");
}

}  // namespace

Doubt doubt_of(const std::string& warning) {
  const std::size_t at = warning.rfind("; ");
  if (at == std::string::npos) return {warning, ""};
  return {warning.substr(0, at), warning.substr(at + 2)};
}

std::vector<Doubt> find_doubts(const ForceMetrics& f, const Scene& scene) {
  std::vector<Doubt> out;
  const bool is_ours = scene.contact.law == "coulomb" && scene.local.method == "multirate";
  const int touching = f.ticks_stick + f.ticks_slide + f.ticks_frictional_slide;
  if (touching == 0) {
    out.push_back({"the tool never touched the body",
                   "look at tool.path (press_drag.at, waypoints), object.size and object.scale"});
    return out;
  }
  if (f.lost_contacts > 0)
    out.push_back({text("contact ended ", f.lost_contacts, f.lost_contacts == 1 ? " time" : " times",
                        " while the tool did not move away"),
                   is_ours ? sooner(scene) : "set contact.law to coulomb and local.method to multirate"});
  if (f.crossing_jump > kNoticeable)
    out.push_back({text("the force jumps by up to ", percent(f.crossing_jump),
                        " of its mean in one tick at an edge of "
                        "the mesh"),
                   smoother(scene)});
  if (f.refresh_jump > kNoticeable)
    out.push_back({text("the force jumps by up to ", percent(f.refresh_jump),
                        " of its mean in one tick when a local "
                        "model comes in"),
                   scene.local.blend_ms > 0 ? sooner(scene) : "set local.blend_ms to 12"});
  if (f.buzz > kNoticeable)
    out.push_back({text("the force buzzes above 100 Hz by ", percent(f.buzz), " of its mean"),
                   is_ours ? "raise object.model.damping.stiffness, or take finer cells"
                           : "set contact.law to coulomb and local.method to multirate"});
  return out;
}

std::vector<Doubt> find_doubts(const Scene& scene, const SessionResult& result,
                               const std::vector<std::string>& warnings, const std::vector<ForceMetrics>& forces) {
  std::vector<Doubt> out;
  for (const std::string& warning : warnings)
    if (std::ranges::find(result.notes, warning) == result.notes.end()) out.push_back(doubt_of(warning));
  if (result.tools[0].missed_impacts > 0)
    out.push_back({text("in ", result.tools[0].missed_impacts, " ticks without contact the tool ended inside the body"),
                   sooner(scene)});
  for (std::size_t k = 0; k < forces.size(); ++k)
    for (Doubt& d : find_doubts(forces[k], scene)) {
      if (k > 0) d.what = "second tool: " + d.what;
      out.push_back(std::move(d));
    }
  const double bent = percentile(result.refresh.linearization_error, 0.5);
  if (bent > kNoticeable)
    out.push_back({text("outside the linear range: at the end of an interval the local model's force is off by ",
                        percent(bent), " (median)"),
                   scene.global.early_refresh ? sooner(scene) : "set global.early_refresh to true"});
  return out;
}

}  // namespace kt
