#include "haptics/refresh/contact_nodes.hpp"

#include <algorithm>
#include <utility>

#include "core/body/node_weights.hpp"

namespace kt {

void ContactNodes::keep(const PreparedLocalModel& model) {
  const ContactSurface& s = model.surface;
  if (s.fine) return static_cast<void>(kept_.push_back({model.model.frame, {}, {}, {}, s.fine}));
  const auto facets = static_cast<std::ptrdiff_t>(s.apron_facets < 0 ? s.facets.triangles.size() : s.apron_facets);
  Kept kept{model.model.frame, {s.first_moved.begin(), s.first_moved.begin() + facets + 1}, {}, {}, {}};
  for (int k = 0; k < kept.first.back(); ++k) kept.node.push_back(model.model.patch.global_node[s.moved_node[k]]);
  kept.weight.assign(s.moved_weight.begin(), s.moved_weight.begin() + kept.first.back());
  kept_.push_back(std::move(kept));
}

void ContactNodes::forget_before(int frame) {
  while (!kept_.empty() && kept_.front().frame < frame) kept_.pop_front();
}

NodeWeights ContactNodes::moved_by(int frame, const TickContact& contact) const {
  if (const OnFine at = on_fine(frame, contact); at.patch) return at.patch->moved_by(at.facet, at.bary);
  const auto kept = std::ranges::find(kept_, frame, &Kept::frame);
  if (contact.facet < 0 || kept == kept_.end() || contact.facet + 1 >= static_cast<int>(kept->first.size()))
    return kt::moved_by(surface_, {"flat", 0}, contact.triangle, on_triangle(contact).bary);
  NodeWeights out;
  for (int k = kept->first[contact.facet]; k < kept->first[contact.facet + 1]; ++k)
    out.add(kept->node[k], contact.bary.dot(kept->weight[k]));
  return out;
}

const FinePatch* ContactNodes::fine_of(int frame) const {
  const auto kept = std::ranges::find(kept_, frame, &Kept::frame);
  return kept == kept_.end() ? nullptr : kept->fine.get();
}

ContactNodes::OnFine ContactNodes::on_fine(int frame, const TickContact& contact) const {
  const FinePatch* fine = fine_of(frame);
  if (!fine || contact.facet >= 0) return {};
  const auto [facet, bary] = fine->find({contact.triangle, contact.bary});
  return facet < 0 ? OnFine{} : OnFine{fine, facet, bary};
}

TickContact ContactNodes::on_triangle(TickContact contact) const {
  if (contact.facet >= 0)
    contact.bary = weights_in_triangle(contact.facet % (1 << (2 * levels_)), levels_, contact.bary);
  contact.facet = -1;
  return contact;
}

}  // namespace kt
