#pragma once
// State of a touch, for gauges and logs.
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Energy that local models had in store at their adoption, minus the rest of the one before. A swap gives it to the
/// hand or takes it. Counted are swaps whose both models were in use and are definite. The last model's own swap is not
/// counted yet.
struct RefreshEnergy {
  int swaps = 0;
  double sum = 0, largest = 0;  ///< sum of all, and the one of largest size [J]. Positive where the body gained
};

/// State of a touch after its last refresh.
struct TouchStatus {
  int refreshes = 0;                ///< refreshes so far
  int linearized_tick = 0;          ///< tick of the last one
  int dof = 0, patch_vertices = 0;  ///< size of its local model
  double refresh_ms = 0;            ///< CPU time of the last one, with its global step
  double late_ticks = 0;            ///< ticks from linearization to use, of the last adopted local model
  /// Of the local model, relative. NaN where it is not certified, or no motion and too little of the force is known.
  double expected_force_error = std::numeric_limits<double>::quiet_NaN();
  double certified_error =
      std::numeric_limits<double>::quiet_NaN();  ///< error of the impedance, 0-500 Hz, NaN where not certified
  double fineness = std::numeric_limits<double>::quiet_NaN();  ///< refined cells over the contact radius, NaN for none
  /// Force to expect of the cells under the tools, over the continuum's (haptics/cost/force_factor.hpp). Of cells as
  /// they are, that of a ball pressed in by a sixteenth of its radius. NaN where the tool or the model has no fit.
  double force_factor = std::numeric_limits<double>::quiet_NaN();
  RefreshEnergy energy{};  ///< energy of all swaps so far
  std::string reducer;
  std::string error;  ///< why the body's simulation ended, empty while it goes on
};

struct TouchMoment;  // haptics/halves/touch_moment.hpp

/// A touch at one moment, from which another episode can begin. Copies share the moment.
struct TouchState {
  VectorX x, v;  ///< of the body's nodes as the last refresh had them [m], [m/s], (3n)
  /// Tools, their contacts, how far the local model had moved since, and which one was chosen. Null: the body alone.
  std::shared_ptr<const TouchMoment> moment;
};

/// Results of the last refresh, for pictures.
struct RefreshPicture {
  int refreshes = 0;                  ///< as TouchStatus::refreshes
  std::vector<int> triangles;         ///< triangles of the body's surface in the patch of the new local model
  std::vector<int> nodes;             ///< nodes of the body that the local model before it moved
  std::vector<double> distance;       ///< distance of each between local model and body [m], the local model's error
  std::vector<SurfacePlace> refined;  ///< vertices of the refined cells' surface
  std::vector<std::array<int, 2>> refined_edges;  ///< edges between them, each once
};

}  // namespace kt
