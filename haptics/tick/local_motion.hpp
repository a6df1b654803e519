#pragma once
// Where the nodes of a local model are and how they move, apart from the model: what the next one goes on from.
#include <span>

#include "core/global/global_simulation.hpp"
#include "haptics/tick/prepared_local_model.hpp"
#include "haptics/tick/tick_contact.hpp"

namespace kt {

struct LocalMotion {
  int tick = 0;     ///< ticks done before
  int frame = -1;   ///< of the model
  VectorX x, v;     ///< of the recovered nodes [m], [m/s], (3 recovered); storage may be longer
  VectorX du;       ///< of the patch vertices: motion that contact causes [m/s], (3p)
  VectorX yielded;  ///< of the points of a fine patch [m], (3y); storage may be longer; empty: not told
  std::array<Overlap, kMaxTools> overlap{};  ///< of each tool
  std::vector<int> row;                      ///< (n) global node -> its place in x and v, -1
  int num_patch = 0;                         ///< patch vertices come first
};

/// Room for the motion of any local model of a body. @param num_nodes  of the whole body
LocalMotion make_local_motion(int num_nodes);

/// The model's motion now. No allocation.
void record_motion(const PreparedLocalModel& model, int tick, LocalMotion& out) noexcept;

/// Gives `model` that motion, by node: q = fit (x - x0). Nodes that the motion does not have stay where the
/// linearization has them. No allocation.
/// @param fine  of the model that the motion is of; null: none
void carry_motion(const LocalMotion& motion, PreparedLocalModel& model, const FinePatch* fine = nullptr) noexcept;

/// Puts contacts of the body's surface into the state of a model that is not in use yet; those outside its patch are
/// left out.
/// @param contacts  on triangles, not on another model's facets
/// @param sliding  of each tool
void place_contacts(PreparedLocalModel& model, std::span<const TickContact> contacts,
                    const std::array<bool, kMaxTools>& sliding) noexcept;

}  // namespace kt
