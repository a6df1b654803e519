#include "haptics/refresh/contact_nodes.hpp"

#include <algorithm>
#include <utility>

namespace kt {

void ContactNodes::keep(const PreparedLocalModel& model) {
  const ContactSurface& s = model.surface;
  const auto facets = static_cast<std::ptrdiff_t>(s.apron_facets < 0 ? s.facets.triangles.size() : s.apron_facets);
  Kept kept{model.model.frame, {s.first_moved.begin(), s.first_moved.begin() + facets + 1}, {}, {}};
  for (int k = 0; k < kept.first.back(); ++k) kept.node.push_back(model.model.patch.global_node[s.moved_node[k]]);
  kept.weight.assign(s.moved_weight.begin(), s.moved_weight.begin() + kept.first.back());
  kept_.push_back(std::move(kept));
}

void ContactNodes::forget_before(int frame) {
  while (!kept_.empty() && kept_.front().frame < frame) kept_.pop_front();
}

NodeWeights ContactNodes::moved_by(int frame, const TickContact& contact) const {
  const auto kept = std::ranges::find(kept_, frame, &Kept::frame);
  if (contact.facet < 0 || kept == kept_.end() || contact.facet + 1 >= static_cast<int>(kept->first.size()))
    return {surface_.triangles[contact.triangle], on_triangle(contact).bary};
  NodeWeights out;
  for (int k = kept->first[contact.facet]; k < kept->first[contact.facet + 1]; ++k)
    out.add(kept->node[k], contact.bary.dot(kept->weight[k]));
  return out;
}

TickContact ContactNodes::on_triangle(TickContact contact) const {
  if (contact.facet >= 0)
    contact.bary = weights_in_triangle(contact.facet % (1 << (2 * levels_)), levels_, contact.bary);
  contact.facet = -1;
  return contact;
}

}  // namespace kt
