#pragma once
// Whether the cells under the tools are refined: local.refine off, follow, set-up, or auto.
#include <string>

#include "core/body/deformable_model.hpp"
#include "core/body/surface.hpp"
#include "core/contact_surface/contact_surface.hpp"
#include "haptics/options/touch_options.hpp"

namespace kt {

struct RefineChoice {
  bool refines = false;
  std::string why_not;  ///< the reason, where auto leaves the cells as they are
};

/// Whatever the cells' width: follow and set-up.
bool refines_always(const LocalSettings& local);

/// What settings alone decide. Throws InputError for an unknown name, and where follow or set-up asks for what does not
/// go together.
RefineChoice may_refine(const ContactSettings& contact, const LocalSettings& local);

/// auto refines where the cells of the surface are wider than half the expected contact, the material has a name, no
/// tool is a point, and the body is not in contact with itself. Throws as may_refine().
RefineChoice choose_refine(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                           bool touches_itself = false);

/// Of the surface that tools touch where no cells are refined; flat where they are, whose surface is their own
/// (core/contact_surface/rest_surface.hpp). Throws as choose_refine().
Smoothing contact_smoothing(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                            bool touches_itself);

/// CPU time of the refined cells of a refresh in which a tool drags, at most `nodes` of them [ms]: fitted to
/// scenes/organ_drag.json at 450 and 900.
double predict_refine_ms(int nodes);

/// Relative error of the force by refined cells (refined_force_factor()); 0: no cells are refined. Throws as
/// choose_refine().
double refined_cells_error(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                           bool touches_itself);

}  // namespace kt
