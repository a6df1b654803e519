#include "haptics/predict/contact_width.hpp"
#include "haptics/session/session.hpp"

namespace kt {

/// A hand gets less deep than its target: its contact is measured after the run.
void predict_contact_width(const Session& session, std::vector<Prediction>& out) {
  if (session.path().empty() || session.scene().tool.path.hand) return;
  std::vector<Vec3> places;
  for (const TimedPoint& p : session.path())
    if (p.t <= session.scene().duration) places.push_back(p.x);
  const auto width = find_contact_width(session, places);
  if (width && is_off(*width)) out.push_back({"contact_width", coarse_mesh_warning(session, *width)});
}

}  // namespace kt
