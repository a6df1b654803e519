#pragma once
// How a touch goes: for gauges and logs.
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Energy that local models had in store when they were taken into use, beyond what the one before had left: what a
/// swap gave to whoever holds the tool, or took. Of swaps whose both models were in use and are definite; the last
/// model's own swap is not counted yet.
struct RefreshEnergy {
  int swaps = 0;
  double sum = 0, largest = 0;  ///< of all, and the one of largest size [J]; positive: the body gained
};

/// How a touch goes: of the refresh that was made last.
struct TouchStatus {
  int refreshes = 0;                ///< made so far
  int linearized_tick = 0;          ///< of the last one
  int dof = 0, patch_vertices = 0;  ///< of its local model
  double refresh_ms = 0;            ///< CPU time of the last one, with its global step
  double late_ticks = 0;            ///< from the linearization until the local model was in use, of the last adopted
  double expected_force_error = std::numeric_limits<double>::quiet_NaN();  ///< relative; NaN: not certified
  double certified_error =
      std::numeric_limits<double>::quiet_NaN();                ///< of the impedance, 0-500 Hz; NaN: not certified
  double fineness = std::numeric_limits<double>::quiet_NaN();  ///< refined cells over the contact radius; NaN: none
  /// Force over the continuum's to expect of the cells under the tools (haptics/cost/force_factor.hpp); where none are
  /// refined, of a ball pressed in by a sixteenth of its radius. NaN: not known of the tool or the model.
  double force_factor = std::numeric_limits<double>::quiet_NaN();
  RefreshEnergy energy{};  ///< of all swaps so far
  std::string reducer;
  std::string error;  ///< why the body's simulation ended; empty: it goes on
};

/// What the last refresh found: for pictures.
struct RefreshPicture {
  int refreshes = 0;             ///< as TouchStatus::refreshes
  std::vector<int> triangles;    ///< of the body's surface, in the patch of the new local model
  std::vector<int> nodes;        ///< of the body, that the local model before it moved
  std::vector<double> distance;  ///< of each, where that had it from where the body has it [m]: the local model's error
  std::vector<SurfacePlace> refined;              ///< vertices of the refined cells' surface
  std::vector<std::array<int, 2>> refined_edges;  ///< between them, each once
};

}  // namespace kt
