// What a tick tells: the force to the hand, the impulses to the slow side.
#include <algorithm>

#include "haptics/tick/tick_stages.hpp"

namespace kt {

Vec3 place_of(const TickState& tick, const Contact& contact, const VectorX& x) noexcept {
  const SurfacePatch& facets = tick.model->surface.facets;
  if (!facets.is_curved) return contact.core - (tick.tool_of(contact).shape().radius + contact.gap) * contact.normal;
  Vec3 out = Vec3::Zero();
  for (int c = 0; c < 3; ++c) out += contact.bary[c] * node(x, facets.triangles[contact.triangle][c]);
  return out;
}

void report_contacts(TickState& tick, int tool, LocalFrame& frame) noexcept {
  const ContactSurface& surface = tick.model->surface;
  const SurfacePatch& facets = surface.facets;
  Vec3 normal_sum = Vec3::Zero(), tangential_sum = Vec3::Zero();
  double largest = 0;
  frame.contacts = 0;
  frame.gap = std::numeric_limits<double>::infinity();
  for (int i = 0; i < tick.contacts.count; ++i) {
    const Contact& contact = tick.contacts.contacts[i];
    if (contact.tool != tool) continue;
    const Vec3 impulse = tick.model->state.impulse[i], force = -impulse / tick.h;
    const double f_n = force.dot(contact.normal);
    const Vec3 f_t = force - f_n * contact.normal;
    normal_sum += f_n * contact.normal;
    tangential_sum += f_t;
    ++frame.contacts;
    frame.gap = std::min(frame.gap, contact.gap);
    if (f_n > 0) frame.cone_ratio = std::max(frame.cone_ratio, f_t.norm() / f_n);
    const Vec3 point = place_of(tick, contact, tick.model->work.x_end);
    frame.torque += (point - frame.pose.x).cross(force);
    if (f_n > largest) {
      largest = f_n;
      frame.triangle = facets.global_triangle[contact.triangle];
      frame.facet = surface.global_facet(contact.triangle);
      frame.mode = tick.solution.mode[i];
      frame.normal = contact.normal;
      frame.point = point;
      if (facets.on_rim[contact.triangle]) tick.tools[tool].flags |= kLeftPatch;
      if (surface.is_apron(contact.triangle)) tick.tools[tool].flags |= kOnApron;
      if (surface.fine && !surface.is_refined(contact.triangle)) tick.tools[tool].flags |= kUnrefined;
    }
    const bool by_place = surface.fine || surface.goes_with_apron(contact.triangle);
    tick.samples[tick.num_samples++] = {
        .t = tick.t - tick.h,
        .triangle = facets.global_triangle[contact.triangle],
        .facet = by_place ? -1 : contact.triangle,
        .bary = surface.fine ? surface.weights_in_triangle(contact.triangle, contact.bary) : contact.bary,
        .impulse = impulse,
        .normal = contact.normal,
        .point = point,
        .sticks = tick.solution.mode[i] == ContactMode::stick,
        .tool = tool};
  }
  frame.f_n = normal_sum.norm();
  frame.f_t = tangential_sum.norm();
}

void shape_force(TickState& tick, int tool, LocalFrame& frame) noexcept {
  TouchingTool& t = tick.tools[tool];
  const bool touches = frame.mode != ContactMode::free;
  t.is_off_patch = !touches && (t.is_off_patch || t.was_on_rim);
  t.was_on_rim = touches && (t.flags & kLeftPatch);
  if (t.is_off_patch) t.flags |= kLeftPatch;
  double others = 0;
  for (int k = 0; k < tick.num_tools(); ++k)
    if (k != tool) others += tick.tools[k].blend.work();
  const ToolSweep& sweep = t.whole.sweep();
  frame.force = t.blend.apply(frame.force, touches, t.is_off_patch, sweep.x_t1 - sweep.x_t0, others);
  if (t.push.is_on() && touches) t.flags |= kPushedOut;
  frame.force = t.push.apply(frame.force, touches, tick.model->state.overlap[tool].left > 0);
}

}  // namespace kt
