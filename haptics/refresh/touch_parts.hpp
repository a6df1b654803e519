#pragma once
// What options stand for: the names in them, looked up.
#include "haptics/options/touch_options.hpp"
#include "haptics/tick/haptic_method.hpp"

namespace kt {

/// Throws InputError for names and combinations that no library knows, and for tools that are too many.
void check_options(const TouchOptions& options);

std::vector<ToolShape> shapes_of(const TouchOptions& options);
double tick_length(const TouchOptions& options);  ///< [s]
int ticks_per_refresh(const TouchOptions& options);

/// The method that local.method and contact.law ask for. Throws InputError.
std::unique_ptr<HapticMethod> make_method(const TouchOptions& options, const SurfaceFriction& friction);

/// New local models are brought to the present before they are adopted; baselines know nothing of that.
bool catches_up(const TouchOptions& options);
/// For CatchUp; none when nothing catches up.
std::unique_ptr<ContactSolver> catch_up_solver(const TouchOptions& options, const SurfaceFriction& friction);

/// Whether settings of the surface that tools touch go together. Throws InputError.
void check_contact_surface(const ContactSettings& contact, const LocalSettings& local);

/// None: "auto".
std::optional<LocalScheme> local_scheme(const std::string& integrator);
Metric contact_metric(const std::string& name);
bool is_geometric(const std::string& contact_law);  ///< the paper's laws, which work in positions

}  // namespace kt
