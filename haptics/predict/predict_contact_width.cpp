#include "haptics/predict/contact_width.hpp"
#include "haptics/predict/predict.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {

/// A hand gets less deep than its target: its contact is measured after the run.
void predict_contact_width(const BuiltScene& built, std::vector<Prediction>& out) {
  if (built.path().empty() || built.scene().tool.path.hand || built.scene().tool.path.device) return;
  std::vector<Vec3> places;
  for (const TimedPoint& p : built.path())
    if (p.t <= built.scene().duration) places.push_back(p.x);
  const auto width = find_contact_width(built, places);
  if (width && is_off(*width)) out.push_back({"contact_width", coarse_mesh_warning(built, *width)});
}

}  // namespace kt
