// The engine's own method under its name in the table.
#include "haptics/tick/local_simulation.hpp"

namespace kt {

std::unique_ptr<HapticMethod> make_multirate_method(const HapticMethodOptions& options) {
  return std::make_unique<LocalSimulation>(
      options.tools, options.h, make_contact_solver(options.law, options.friction, options.friction_of_triangle),
      options.blend);
}

}  // namespace kt
