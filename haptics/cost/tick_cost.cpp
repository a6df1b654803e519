#include "haptics/cost/tick_cost.hpp"

namespace kt {
namespace {

/// The motion without contact: the basis is read once, and what steps the coordinates.
double free_us(const LocalModel& model) {
  constexpr double kRest = 4, kPerNumber = 6.5e-5;  // of a full matrix; us
  constexpr double kPerEntry = 1.6e-3;              // of a sparse stiffness
  constexpr double kPerSolved = 4e-3;               // of it, where each step takes two sparse triangular solves
  constexpr double kPerFilled = 1e-3;               // of a full matrix in such solves
  constexpr double kDenseLimit = 450;               // coordinates, as in LocalDynamics
  const double r = model.dof(), rows = 3.0 * model.patch.num_vertices();
  const bool dense = 2.0 * static_cast<double>(model.basis.nonZeros()) > static_cast<double>(model.basis.size());
  const double basis = dense ? 2 * rows * r : 2 * rows, entries = static_cast<double>(model.stiffness.nonZeros());
  // Vibrations step each by itself, but the damping of a body that bends couples them: counted as if it did.
  const bool vibrations = model.stiffness.nonZeros() <= model.dof();
  double step = kPerNumber * r * r + kPerEntry * entries;
  if (r > kDenseLimit) step = vibrations ? kPerFilled * r * r : kPerSolved * entries;
  return kRest + kPerNumber * basis + step;
}

}  // namespace

/// Places are looked for and their impulses solved two or three times on refined cells, which stay where they are, and
/// more often where they move with triangles. Each place knows all the others, so that of many the square counts.
double predict_contact_us(const ExpectedTouch& touch) {
  if (!(touch.places > 0)) return 0;
  constexpr double kProjected = 4.5;
  if (touch.is_projected) return kProjected;
  constexpr double kRefined = 26, kPerPair = 0.185, kLongPair = 1.6, kFacet = 0.014;
  constexpr double kPlain = 9, kPerPlace = 5.2, kLongPlace = 1.8, kPlainFacet = 0.035;
  if (touch.is_refined)
    return kRefined + kPerPair * (touch.is_long ? kLongPair : 1) * touch.places * touch.places + kFacet * touch.facets;
  return kPlain + kPerPlace * (touch.is_long ? kLongPlace : 1) * touch.places + kPlainFacet * touch.facets;
}

double predict_tick_us(const LocalModel& model, const ExpectedTouch& touch) {
  return free_us(model) + predict_contact_us(touch);
}

}  // namespace kt
