// What hands were given of the forces: a local model that is old, a gate that is shut, a limit.
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "haptics/findings/kinds.hpp"
#include "haptics/guard/device_words.hpp"

namespace kt {
namespace {

using Weight = Finding::Weight;

constexpr double kNoticeableShare = 0.01;  // of the ticks in contact
constexpr double kMostly = 0.5;            // of the ticks in contact: their force is not that of the scene
constexpr double kNearlyAll = 0.9;         // the same of a force that was withheld
constexpr double kLeastTime = 0.02;        // [s] of contact: less is no share of anything

/// A tool's ticks in contact, by what became of their force.
struct ContactTicks {
  int all = 0, gated = 0, slewed = 0, stale_pose = 0;
  double given = 0, wanted = 0;  ///< sums of the sizes of forces: to the hand, and of the local model [N]
};

ContactTicks count(const ToolRun& tool) {
  ContactTicks out;
  for (std::size_t i = 0; i < tool.frames.size(); ++i) {
    const LocalFrame& f = tool.frames[i];
    if (!touches(f)) continue;
    ++out.all;
    out.gated += (f.flags & kGated) != 0;
    out.slewed += (f.flags & kSlewed) != 0;
    out.stale_pose += (f.flags & kStalePose) != 0;
    out.given += f.force.norm();
    out.wanted += i < tool.model_force.size() ? tool.model_force[i].norm() : f.force.norm();
  }
  return out;
}

Cure look_at(const DeviceRun& device) {
  return advise(told("kilotouch device test ", device.name, " says what stands in the way"));
}

void find_shut_gate(const ToolRun& tool, const ContactTicks& c, std::size_t k, std::vector<Finding>& out) {
  if (!tool.device) return;
  const DeviceRun& device = *tool.device;
  const SafetyCounts& s = device.safety;
  const bool in_contact = c.gated > kNoticeableShare * c.all;
  if (!never_opened(s) && !in_contact && s.shut <= 1 && device.gate == GateReason::put_down)
    return;  // once, at the end
  Finding found{
      which(k) + gate_words(s, in_contact ? told(", ", c.gated, " of ", c.all, " in contact") : std::string()),
      {look_at(device)}};
  if (c.all > 0 && c.gated >= kNearlyAll * c.all) found.weight = Weight::failure;
  out.push_back(std::move(found));
}

/// Cut, held back or not there in some ticks: with how many.
void find_held_back(const ToolRun& tool, const ContactTicks& c, std::size_t k, std::vector<Finding>& out) {
  if (tool.limited_forces > 0)
    out.push_back(
        {which(k) + limited_words(tool.limited_forces), {advise("press less deep"), advise("take a softer body")}});
  if (c.slewed > kNoticeableShare * c.all)
    out.push_back({which(k) + slewed_words(told(c.slewed, " of ", c.all, " ticks in contact")),
                   {advise("raise path.device.max_slew, if the device bears it"), advise("move more slowly")},
                   c.slewed > kNoticeableForce * c.all ? Weight::doubt : Weight::note});
  if (c.stale_pose > kNoticeableShare * c.all)
    out.push_back({which(k) + stale_pose_words(told(c.stale_pose, " of ", c.all, " ticks in contact")),
                   tool.device ? std::vector{look_at(*tool.device)} : std::vector<Cure>{}});
}

/// Leaps of the pose, forces that a device which repeats what it is sent did not repeat, what its driver noted.
void find_in_driver(const ToolRun& tool, std::size_t k, std::vector<Finding>& out) {
  if (!tool.device) return;
  const SafetyCounts& s = tool.device->safety;
  if (s.jumps > 0) out.push_back({which(k) + leap_words(s.jumps), {look_at(*tool.device)}});
  if (s.unechoed > 0) {
    Finding found{
        told(which(k), "the device did not repeat its force in ", s.unechoed, " of ", s.ticks, " ticks: it gave up to ",
             s.most_echoed.value_or(0), " N of ", s.most_force, " N that it was sent"),
        {look_at(*tool.device)}};
    if (s.most_echoed.value_or(0) <= kNoticeableForce * s.most_force) found.weight = Weight::failure;
    out.push_back(std::move(found));
  }
  for (const std::string& note : tool.device->notes)
    out.push_back({told(which(k), tool.device->name, ": ", note), {}, Weight::note});
}

/// The sum of all that was withheld or added, whatever did it.
void find_difference(const ToolRun& tool, const ContactTicks& c, std::size_t k, std::vector<Finding>& out) {
  if (c.all == 0 || !(c.wanted > 0) || std::abs(c.given - c.wanted) <= kNoticeableForce * c.wanted) return;
  const double given = c.given / c.all, wanted = c.wanted / c.all;
  Finding found{told(which(k), "the hand was given ", given, " N on average in contact, where the local model has ",
                     wanted, " N")};
  found.value = given;
  found.limit = wanted;
  if (c.given <= kNoticeableForce * c.wanted) found.weight = Weight::failure;
  if (tool.device) found.cures.push_back(look_at(*tool.device));
  out.push_back(std::move(found));
}

/// Since the local model in use was taken, at each tick in contact [s]; how many came after the first.
struct ModelAges {
  int contact = 0, old = 0, after_first = 0;
  double oldest = 0;  ///< [s]
};

ModelAges model_ages(const ToolRun& tool, double h, double limit) {
  ModelAges out;
  double taken = 0;
  int frame = tool.frames.empty() ? -1 : tool.frames[0].model_frame;
  for (const LocalFrame& f : tool.frames) {
    if (f.model_frame != frame) {
      frame = f.model_frame;
      taken = f.t - h;
      ++out.after_first;
    }
    if (!touches(f)) continue;
    ++out.contact;
    const double age = f.t - taken;
    if (age <= limit && (f.flags & kStaleModel) == 0) continue;
    ++out.old;
    out.oldest = std::max(out.oldest, age);
  }
  return out;
}

}  // namespace

void find_withheld_forces(const Scene& scene, const SessionResult& result, std::vector<Finding>& out) {
  for (std::size_t k = 0; k < result.tools.size(); ++k) {
    const ToolRun& tool = result.tools[k];
    const ContactTicks c = count(tool);
    const std::size_t before = out.size();
    find_shut_gate(tool, c, k, out);
    find_held_back(tool, c, k, out);
    find_in_driver(tool, k, out);
    // A simulated hand is held by passivity control, which is meant to change the force.
    if (tool.device || scene.link.type == "network") find_difference(tool, c, k, out);
    for (std::size_t i = before; i < out.size(); ++i) out[i].where = text(tool_key(k), ".path.device");
  }
}

void find_old_models(const Scene& scene, const SessionResult& result, const RealTime& pace, std::vector<Finding>& out) {
  constexpr double kUsual = 0.25, kIntervals = 4;  // as the ticks' own flag: TouchOptions::stale_s
  const double h = 1 / scene.local.rate_hz;
  const double limit = std::max(kUsual, kIntervals / scene.global.rate_hz) + 1e-3 * scene.link.latency_ms;
  ModelAges most;
  for (const ToolRun& tool : result.tools)
    if (const ModelAges ages = model_ages(tool, h, limit); ages.old >= most.old) most = ages;
  if (most.old <= kNoticeableShare * most.contact || most.old * h < kLeastTime) return;
  Finding found{told(most.after_first == 0 ? "no local model came after the first" : "local models came late", ": in ",
                     most.old, " of ", most.contact, " ticks in contact the one in use was more than ", limit,
                     " s old, ", most.oldest, " s at most, and the force is that of a body that has not followed")};
  found = std::move(found).at("global.rate_hz", most.oldest, limit);
  found.cures = pace.cures;
  if (found.cures.empty() && scene.link.type == "thread")
    found.cures.push_back(advise("leave the processor to this program"));
  if (found.cures.empty() && scene.link.loss > 0) found.cures.push_back(set_to("link.loss", "0"));
  if (most.old >= kMostly * most.contact) found.weight = Weight::failure;
  out.push_back(std::move(found));
}

}  // namespace kt
