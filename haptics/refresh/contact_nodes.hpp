#pragma once
// Ticks report where on a facet of their local model they touched; here is which nodes of the body that moved.
#include <deque>
#include <vector>

#include "core/body/node_weights.hpp"
#include "core/body/surface.hpp"
#include "haptics/tick/local_report.hpp"
#include "haptics/tick/prepared_local_model.hpp"
#include "haptics/tick/tick_contact.hpp"

namespace kt {

/// How far the vertices of a surface's fine patch lie from where its triangles are [m]; empty: all on them.
std::vector<Vec3> offsets_of(const ContactSurface& surface);

class ContactNodes {
 public:
  /// Borrows the body's surface.
  explicit ContactNodes(const Surface& surface) : surface_(surface) {}

  /// A new local model, whose ticks will report. Their frames ascend.
  void keep(const PreparedLocalModel& model);
  /// Of the local model before the first one: how its refined cells yield, and their vertices' offsets_of().
  void keep_fine(int frame, std::shared_ptr<const FinePatch> fine, std::vector<Vec3> offset);
  /// Local models before that frame report nothing more.
  void forget_before(int frame);
  /// The same body goes on from another one's.
  void go_on_from(ContactNodes& before) { kept_ = std::move(before.kept_); }

  /// @param frame  of the local model that reported: one that is kept, else the triangle alone moves
  NodeWeights moved_by(int frame, const TickContact& contact) const;
  /// The fine patch that a contact was on, its facet there and the weights in it; null: none.
  struct OnFine {
    const FinePatch* patch = nullptr;
    int facet = -1;
    Vec3 bary = Vec3::Zero();
  };
  OnFine on_fine(int frame, const TickContact& contact) const;
  /// How far that point lay from where its nodes and cells moved it: ContactSurface::offset [m].
  Vec3 offset(int frame, const TickContact& contact) const;
  /// Of that local model; null: none.
  const FinePatch* fine_of(int frame) const;
  /// The same contact with its place on the triangle instead of a facet.
  TickContact on_triangle(int frame, TickContact contact) const;
  std::vector<TickContact> on_triangles(const LocalReport& report) const;

 private:
  struct Kept {
    int frame = 0;
    std::vector<int> first, node;  // of the body; see ContactSurface::first_moved
    std::vector<Vec3> weight;
    int levels = 0;                         // of smoothing
    std::shared_ptr<const FinePatch> fine;  // with one, contacts are told by their places on triangles
    std::vector<Vec3> offset;               // of the fine patch's vertices [m]; empty: none
  };
  const Surface& surface_;
  std::deque<Kept> kept_;
};

}  // namespace kt
