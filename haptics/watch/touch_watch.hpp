#pragma once
// Looks after a loop of one's own as a session does after its run: whether contact is where it should be, and what the
// refreshes found of the body.
#include <mutex>
#include <optional>

#include "haptics/watch/contact_watch.hpp"
#include "haptics/watch/tick_words.hpp"

namespace kt {

class TouchWatch final : public ModelObserver {
 public:
  /// @param surface  of the whole body; borrowed
  /// @param tools    none: contact is not looked at
  /// @param next     is told everything, too; null: nobody
  TouchWatch(const Surface& surface, std::span<const ToolShape> tools, double h, ModelObserver* next);

  /// A tick is done: noted, to be looked at later. In the thread that ticks; no allocation, lock or clock.
  void ticked(const HapticSide& side, std::span<const LocalFrame> frames) noexcept;
  void adopted(const PreparedLocalModel& model) noexcept override;
  bool look_back(const PreparedLocalModel& model, int most) override;
  void refreshed(const RefreshRecord& record) override;
  /// The ticks that are left, all of which had this model. While nobody ticks.
  void finish(const PreparedLocalModel& model);

  /// What was found so far: of ticks whose local model is not in use any more. From any thread.
  /// @param ticks       all so far      @param tetrahedra  of the body
  /// @param stiffness   of the barrier of self-contact [N/m]
  void tell(long ticks, std::size_t tetrahedra, double stiffness, std::vector<Finding>& out) const;

 private:
  void tell_of_body(std::size_t tetrahedra, double stiffness, std::vector<Finding>& out) const;
  std::size_t tools_;
  double h_;
  ModelObserver* next_;
  std::optional<ContactWatch> contacts_;
  mutable std::mutex guard_;  // of what is found, not of the notes
  InvertedTetrahedra inverted_;
  std::size_t refreshes_ = 0;
  int indefinite_ = 0, crossings_ = 0, pressed_ = 0;
};

}  // namespace kt
