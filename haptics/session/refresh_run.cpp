#include "haptics/session/refresh_run.hpp"

#include <algorithm>
#include <limits>

namespace kt {

void RefreshRun::add(const RefreshRecord& r) {
  refresh_ms.push_back(r.refresh_ms);
  cpu_ms.push_back(r.cpu_ms);
  const double parts[] = {r.linearize_ms, r.reduce_ms, r.refine_ms, r.certify_ms, r.prepare_ms};
  for (std::size_t i = 0; i < parts_ms.size(); ++i) parts_ms[i].second.push_back(parts[i]);
  if (r.linearization_error) linearization_error.push_back(*r.linearization_error);
  if (r.fineness) {
    fineness.push_back(*r.fineness);
    refined_share.push_back(r.refined_share);
  }
  damping_coupling = r.coupling;
  exact_steps += r.is_exact;
  definite_tangents += r.definite_tangent;
  looked_ahead += r.looked_ahead;
  if (!r.global_ms) return;
  global_ms.push_back(*r.global_ms);
  inverted.add(r.inverted, r.t);
  if (!r.self_contact) return;
  SelfContactReport& e = sums_.extremes;
  if (self_contacts_++ == 0) e.nearest = std::numeric_limits<double>::infinity();
  e.contacts = std::max(e.contacts, r.self_contact->contacts);
  e.nearest = std::min(e.nearest, r.self_contact->nearest);
  e.normal = std::max(e.normal, r.self_contact->normal);
  e.energy = std::max(e.energy, r.self_contact->energy);
  sums_.mean_normal += r.self_contact->normal;
  sums_.touching_share += r.self_contact->contacts > 0;
  sums_.crossings = std::max(sums_.crossings, r.crossings);
  sums_.pressed = std::max(sums_.pressed, r.pressed);
}

SelfContactRun RefreshRun::self_contact() const {
  SelfContactRun out = sums_;
  if (self_contacts_ == 0) out.extremes.nearest = std::numeric_limits<double>::infinity();
  out.mean_normal /= std::max(1, self_contacts_);
  out.touching_share /= std::max(1, self_contacts_);
  return out;
}

}  // namespace kt
