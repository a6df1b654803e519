#pragma once
// What the points of refined cells had yielded by when the hand told its motion. It stays on the hand's computer: a
// local model that was made from that motion goes on from there.
#include <deque>
#include <map>
#include <memory>

#include "core/local/fine_patch.hpp"
#include "haptics/tick/local_motion.hpp"

namespace kt {

class YieldMemory {
 public:
  /// A local model has come: motions name its frame from now on.
  void add(const PreparedLocalModel& model);
  /// A motion goes to the body.
  void note(const LocalMotion& motion);
  /// Gives the state of a model what had yielded at that tick; zero where that is not known.
  void start(PreparedLocalModel& model, int tick) const;
  void clear();

 private:
  struct Kept {
    int tick;
    std::shared_ptr<const FinePatch> patch;
    VectorX yielded;  // [m], (3y)
  };
  std::map<int, std::shared_ptr<const FinePatch>> patches_;  // by frame
  std::deque<Kept> kept_;
};

}  // namespace kt
