#include "haptics/refresh/refine_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/shape/tool_shape.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/fine/isotropic_cells.hpp"
#include "haptics/cost/expected_touch.hpp"
#include "haptics/cost/force_factor.hpp"
#include "haptics/refresh/touch_parts.hpp"

namespace kt {
namespace {

constexpr double kWideCell = 0.5;  // of the contact radius: finer ones give the continuum's force as they are

double mean_edge(const Surface& surface, const VectorX& x) {
  double sum = 0;
  for (const Triangle& t : surface.triangles)
    for (std::size_t c = 0; c < 3; ++c) sum += (node(x, t[(c + 1) % 3]) - node(x, t[c])).norm();
  return surface.triangles.empty() ? 0 : sum / static_cast<double>(3 * surface.triangles.size());
}

/// Empty: it can be refined.
std::string why_no_material(const DeformableModel& model) {
  if (told_by(model)) return {};
  try {
    isotropic_cells(model);
    return {};
  } catch (const InputError& error) {
    return error.what();
  }
}

}  // namespace

bool refines_always(const LocalSettings& local) { return local.refine == "follow" || local.refine == "set-up"; }

RefineChoice may_refine(const ContactSettings& contact, const LocalSettings& local) {
  if (local.refine == "off") return {false, "local.refine is off"};
  if (local.refine != "auto" && !refines_always(local))
    throw_unknown("local.refine", local.refine, {"auto", "follow", "set-up", "off"});
  const std::string& method = local.method;
  const bool goes_together = method == "multirate" && !is_geometric(contact.law);
  if (refines_always(local)) {
    if (!goes_together)
      throw InputError(text("local.refine \"", local.refine,
                            "\" needs local.method \"multirate\" and contact.law \"coulomb\"; ", "local.method is \"",
                            method, "\", contact.law \"", contact.law, "\": set local.refine off"));
    return {true, {}};
  }
  if (!goes_together) return {false, text("local.method is ", method, ", contact.law ", contact.law)};
  return {true, {}};
}

RefineChoice choose_refine(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                           bool touches_itself) {
  RefineChoice out = may_refine(options.contact, options.local);
  if (!out.refines) return out;
  if (touches_itself || options.global.self_contact) {  // what presses from behind does not hold the refined cells
    if (refines_always(options.local))
      throw InputError(
          text("local.refine \"", options.local.refine, "\": not with global.self_contact; set local.refine off"));
    return {false, "global.self_contact is on"};
  }
  const auto is_point = [](const TouchTool& tool) { return tool.shape.kind == ToolShape::Kind::point; };
  if (std::ranges::any_of(options.tools, is_point)) {
    if (refines_always(options.local))
      throw InputError(text("local.refine \"", options.local.refine,
                            "\": not with tool.shape point, which has no contact; set local.refine off"));
    return {false, "a tool is a point"};
  }
  if (refines_always(options.local)) return out;
  double least = std::numeric_limits<double>::infinity();
  for (const TouchTool& tool : options.tools) least = std::min(least, expected_contact_radius(tool.shape));
  const double cell = surface.embedded ? surface.embedded->spacing() : mean_edge(surface, model.mesh().x);
  if (cell <= kWideCell * least) return {false, "the cells are finer than half the contact"};
  if (model.info().type == "msd")
    return {false, "springs come out too soft in refined cells: local.refine follow does it"};
  if (std::string why = why_no_material(model); !why.empty()) return {false, std::move(why)};
  return out;
}

double refined_cells_error(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                           bool touches_itself) {
  if (!choose_refine(model, surface, options, touches_itself).refines) return 0;
  return std::abs(refined_force_factor(model.info(), options.local.fineness, surface.embedded != nullptr) - 1);
}

Smoothing contact_smoothing(const DeformableModel& model, const Surface& surface, const TouchOptions& options,
                            bool touches_itself) {
  const ContactSettings& contact = options.contact;
  if (contact.surface == "flat" || choose_refine(model, surface, options, touches_itself).refines) return {};
  return {contact.surface, contact.surface_levels};
}

double predict_refine_ms(int nodes) {
  constexpr double kUsual = 900, kUsualMs = 13, kGrowth = 1.2;
  return kUsualMs * std::pow(nodes / kUsual, kGrowth);
}

}  // namespace kt
