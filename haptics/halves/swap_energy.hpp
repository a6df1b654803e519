#pragma once
// Energy across a swap of local models: what the new one has in store beyond what the old one had left.
#include <optional>

#include "haptics/halves/touch_status.hpp"
#include "haptics/tick/prepared_local_model.hpp"

namespace kt {

/// Energy [J] that a local model gives back from the displacement q on its way to where it would rest by itself:
/// 1/2 (q - r)' K (q - r), K r = f0. The same in two models of one linear body. NaN when K is not definite.
/// @param qs  displacements [m], (r) each; other sizes: NaN
std::vector<double> stored_energy(const LocalModel& model, std::span<const VectorX> qs);

/// Books swaps as models go out of use, outside the tick.
class SwapEnergy {
 public:
  /// @param old  that was in use until now, with the state that it had at first and has at last
  void add(const PreparedLocalModel& old);
  const RefreshEnergy& booked() const { return booked_; }

 private:
  RefreshEnergy booked_;
  std::optional<double> left_;  // in the model before the one that is added next, when that one took its place [J]
};

}  // namespace kt
