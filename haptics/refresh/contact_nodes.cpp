#include "haptics/refresh/contact_nodes.hpp"

#include <algorithm>
#include <utility>

#include "core/body/node_weights.hpp"

namespace kt {
std::vector<Vec3> offsets_of(const ContactSurface& s) {
  if (s.offset.size() == 0) return {};
  std::vector<Vec3> out(static_cast<std::size_t>(s.fine->num_vertices()), Vec3::Zero());
  for (std::size_t f = 0; f < s.fine->facets.size(); ++f)
    for (std::size_t c = 0; s.facet_of_fine[f] >= 0 && c < 3; ++c)
      out[static_cast<std::size_t>(s.fine->facets[f][c])] =
          node(s.offset, s.facets.triangles[static_cast<std::size_t>(s.facet_of_fine[f])][c]);
  return out;
}

void ContactNodes::keep(const PreparedLocalModel& model) {
  const ContactSurface& s = model.surface;
  if (s.fine) return static_cast<void>(kept_.push_back({model.model.frame, {}, {}, {}, 0, s.fine, offsets_of(s)}));
  const auto facets = static_cast<std::ptrdiff_t>(s.apron_facets < 0 ? s.facets.triangles.size() : s.apron_facets);
  Kept kept{model.model.frame, {s.first_moved.begin(), s.first_moved.begin() + facets + 1}, {}, {}, s.levels, {}, {}};
  for (int k = 0; k < kept.first.back(); ++k) kept.node.push_back(model.model.patch.global_node[s.moved_node[k]]);
  kept.weight.assign(s.moved_weight.begin(), s.moved_weight.begin() + kept.first.back());
  kept_.push_back(std::move(kept));
}

void ContactNodes::keep_fine(int frame, std::shared_ptr<const FinePatch> fine, std::vector<Vec3> offset) {
  kept_.push_back({frame, {}, {}, {}, 0, std::move(fine), std::move(offset)});
}

void ContactNodes::forget_before(int frame) {
  while (!kept_.empty() && kept_.front().frame < frame) kept_.pop_front();
}

NodeWeights ContactNodes::moved_by(int frame, const TickContact& contact) const {
  if (const OnFine at = on_fine(frame, contact); at.patch) return at.patch->moved_by(at.facet, at.bary);
  const auto kept = std::ranges::find(kept_, frame, &Kept::frame);
  if (contact.facet < 0 || kept == kept_.end() || contact.facet + 1 >= static_cast<int>(kept->first.size()))
    return kt::moved_by(surface_, {"flat", 0}, contact.triangle, on_triangle(frame, contact).bary);
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

Vec3 ContactNodes::offset(int frame, const TickContact& contact) const {
  const OnFine at = on_fine(frame, contact);
  const auto kept = std::ranges::find(kept_, frame, &Kept::frame);
  if (!at.patch || kept->offset.empty()) return Vec3::Zero();
  Vec3 out = Vec3::Zero();
  for (std::size_t c = 0; c < 3; ++c)
    out += at.bary[static_cast<Eigen::Index>(c)] *
           kept->offset[static_cast<std::size_t>(at.patch->facets[static_cast<std::size_t>(at.facet)][c])];
  return out;
}

TickContact ContactNodes::on_triangle(int frame, TickContact contact) const {
  const auto kept = std::ranges::find(kept_, frame, &Kept::frame);
  const int levels = kept == kept_.end() ? 0 : kept->levels;
  if (contact.facet >= 0) contact.bary = weights_in_triangle(contact.facet % (1 << (2 * levels)), levels, contact.bary);
  contact.facet = -1;
  return contact;
}

std::vector<TickContact> ContactNodes::on_triangles(const LocalReport& report) const {
  std::vector<TickContact> out;
  for (const TickContact& contact : report.contacts()) out.push_back(on_triangle(report.model_frame, contact));
  return out;
}

}  // namespace kt
