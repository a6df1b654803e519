#include "apps/outputs/run_summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <span>

#include "apps/outputs/cures_in_force.hpp"
#include "apps/outputs/device_summary.hpp"
#include "core/base/error.hpp"
#include "core/linear/dense/kernels.hpp"
#include "haptics/contact/contact_sweeps.hpp"
#include "haptics/findings/run_findings.hpp"
#include "haptics/session/contact_events.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

Json percentiles(std::span<const double> values, bool tail) {
  Json out{{"p50", percentile(values, 0.5)}, {"p99", percentile(values, 0.99)}};
  if (tail) out["p999"] = percentile(values, 0.999);
  out["max"] = values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
  return out;
}

/// CPU time of the ticks as a share of the time that there is for one.
Json period_shares_json(std::span<const double> step_us, double rate_hz) {
  const double per_us = 1e-6 * rate_hz;
  return {{"p50", per_us * percentile(step_us, 0.5)}, {"p99", per_us * percentile(step_us, 0.99)}};
}

/// What the processor has to do, whatever else runs on the machine. Without the refresh that sets the run up.
Json cpu_json(const SessionResult& result) {
  const std::vector<double> refreshes(result.refresh.cpu_ms.begin() + 1, result.refresh.cpu_ms.end());
  const double ticks_s = 1e-6 * std::accumulate(result.step_us.begin(), result.step_us.end(), 0.0);
  const double refreshes_s = 1e-3 * std::accumulate(refreshes.begin(), refreshes.end(), 0.0);
  const double simulated = result.tools[0].frames.empty() ? 0 : result.tools[0].frames.back().t;
  Json out = {{"refresh_ms", percentiles(refreshes, false)}, {"ticks_s", ticks_s}, {"refreshes_s", refreshes_s}};
  out["per_simulated_second"] = simulated > 0 ? Json((ticks_s + refreshes_s) / simulated) : Json(nullptr);
  return out;
}

Json model_json(const Session& session) {
  const ModelInfo info = session.model().info();
  const Mesh& mesh = session.model().mesh();
  const Vec3 size = bounds(mesh).size();
  const auto springs = info.parameters.find("springs");
  Json out{{"type", info.type},
           {"material", info.material},
           {"nodes", mesh.num_own_nodes()},
           {"tets", mesh.tetrahedra.size()},
           {"springs", springs == info.parameters.end() ? 0 : static_cast<int>(springs->second)},
           {"triangles", mesh.triangles.size()},
           {"size_m", {size.x(), size.y(), size.z()}},
           {"mesh_unit_m", session.mesh_unit()},
           {"fixed_nodes",
            std::ranges::count_if(session.model().fixed_nodes(), [&](int i) { return i < mesh.num_own_nodes(); })}};
  for (const auto& [name, value] : info.parameters)
    if (name != "springs") out["parameters"][name] = value;
  return out;
}

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json changes_json(const std::vector<ReducerChange>& changes) {
  Json out = Json::array();
  for (const ReducerChange& c : changes)
    out.push_back({{"tick", c.tick},
                   {"from", c.from},
                   {"to", c.to},
                   {"why", c.why},
                   {"certified_error", number_or_null(c.error)},
                   {"expected_force_error", number_or_null(c.force_error)}});
  return out;
}

Json candidates_json(const std::vector<ReducerCandidate>& candidates) {
  Json out = Json::array();
  for (const ReducerCandidate& c : candidates) {
    Json errors = Json::array();
    for (const double e : c.errors) errors.push_back(number_or_null(e));
    out.push_back({{"name", c.name},
                   {"dof", c.dof},
                   {"error", number_or_null(c.error)},
                   {"errors", errors},
                   {"expected_force_error", number_or_null(c.force_error)},
                   {"predicted_us", number_or_null(c.tick_us)},
                   {"predicted_refresh_ms", number_or_null(c.refresh_ms)}});
  }
  return out;
}

Json force_json(const ForceMetrics& force, const ContactSettings& contact) {
  return {{"mean_n", force.mean_n},
          {"max_n", force.max_n},
          {"mean_t", force.mean_t},
          {"max_t", force.max_t},
          {"max_t_over_mu_n", contact.mu_static > 0 ? force.max_t_over_n / contact.mu_static : 0.0},
          {"felt_t_over_mu_n", contact.mu_static > 0 ? force.felt_t_over_n / contact.mu_static : 0.0},
          {"buzz", force.buzz},
          {"crossing_jump", force.crossing_jump},
          {"refresh_jump", force.refresh_jump}};
}

Json ticks_json(const ForceMetrics& force, std::size_t total) {
  return {{"free", force.ticks_free},
          {"stick", force.ticks_stick},
          {"slide", force.ticks_slide},
          {"frictional_slide", force.ticks_frictional_slide},
          {"total", total}};
}

Json events_json(std::span<const LocalFrame> frames) {
  constexpr ContactEventKind kKinds[] = {ContactEventKind::touch, ContactEventKind::release,
                                         ContactEventKind::stick_to_slip, ContactEventKind::slip_to_stick,
                                         ContactEventKind::edge};
  const std::vector<ContactEvent> events = find_contact_events(frames);
  Json out;
  for (const ContactEventKind kind : kKinds) out[name_of(kind)] = std::ranges::count(events, kind, &ContactEvent::kind);
  return out;
}

Json contact_solver_json(std::span<const LocalFrame> frames) {
  double largest = 0;
  for (const LocalFrame& f : frames) largest = std::max(largest, f.residual);
  const auto unsolved =
      std::ranges::count_if(frames, [](const LocalFrame& f) { return f.residual > SweepLimits{}.residual; });
  return {{"unsolved_ticks", unsolved}, {"residual_max", largest}};
}

Json real_time_json(const RealTime& r) {
  return {{"holds", r.keeps != Keeps::no},
          {"keeps", name_of(r.keeps)},
          {"slow_part", r.slow_part},
          {"slow_part_ms", r.part_ms},
          {"refresh_budget_ms", r.budget_ms},
          {"refresh_ms_p50", r.refresh_ms},
          {"refresh_hz", r.refresh_hz},
          {"refresh_share", r.refresh_share},
          {"tick_share", r.tick_share},
          {"cure", r.cures.empty() ? Json(nullptr) : Json(r.cure())},
          {"why", r.why()},
          {"told", r.told()}};
}

/// Of the thread that ticks against the wall clock.
Json thread_json(const RealTimeGrant& g) {
  return {{"scheduler", g.scheduler()},   {"priority", g.priority},
          {"locked", g.locked},           {"core", g.core < 0 ? Json(nullptr) : Json(g.core)},
          {"page_faults", g.page_faults}, {"major_page_faults", g.major_page_faults},
          {"why_not", g.why_not},         {"thread", g.told()}};
}

/// Of the force to expect: of cells and local model together. Both are independent.
Json expected_error_json(const std::optional<ContactWidth>& width, double local_model) {
  const double cells = width ? std::abs(width->factor - 1) : std::numeric_limits<double>::quiet_NaN();
  return {{"cells", number_or_null(cells)},
          {"local_model", number_or_null(local_model)},
          {"together", number_or_null(std::hypot(cells, local_model))}};
}

/// The mesh's cells against the width of the contact, along the way that the first tool took.
Json mesh_at_contact_json(const std::optional<ContactWidth>& w) {
  if (!w) return nullptr;
  return {{"cell_m", w->cell},
          {"contact_radius_m", w->contact_radius},
          {"cell_over_contact_radius", {{"min", w->least}, {"mean", w->mean}, {"max", w->most}}},
          {"refined", w->is_refined},
          {"why_not_refined", w->why_not.empty() ? Json(nullptr) : Json(w->why_not)},
          {"refined_over_contact_radius", number_or_null(w->fineness)},
          {"along_a_line", w->is_line},
          {"force_factor", number_or_null(w->factor)},
          {"fine_edge_m", number_or_null(w->fine_edge)}};
}

}  // namespace

static Json cure_json(const Cure& cure) {
  const auto known = [](const std::string& word) { return word.empty() ? Json(nullptr) : Json(word); };
  return {{"key", known(cure.key)}, {"value", known(cure.value)}, {"told", cure.told}};
}

Json finding_json(const Finding& found) {
  constexpr const char* kWeights[] = {"note", "doubt", "failure"};
  Json cures = Json::array();
  for (const Cure& cure : found.cures) cures.push_back(cure_json(cure));
  return {{"what", found.what},
          {"where", found.where.empty() ? Json(nullptr) : Json(found.where)},
          {"value", found.value ? number_or_null(*found.value) : Json(nullptr)},
          {"limit", found.limit ? number_or_null(*found.limit) : Json(nullptr)},
          {"weight", kWeights[static_cast<int>(found.weight)]},
          {"cures", cures}};
}

namespace {

/// What speaks against the forces; "cure" in words, as on the first screen.
Json trust_json(const std::vector<Finding>& findings) {
  Json reasons = Json::array();
  for (const Finding& f : findings)
    if (f.weight != Finding::Weight::note)
      reasons.push_back({{"what", f.what}, {"cure", f.cures.empty() ? Json(nullptr) : Json(alternatives(f.cures))}});
  return {{"trustworthy", is_trustworthy(findings)}, {"failed", has_failed(findings)}, {"reasons", reasons}};
}

void add_findings(const std::vector<Finding>& findings, Json& out) {
  std::vector<Finding> notes = findings;
  std::erase_if(notes, [](const Finding& f) { return f.weight != Finding::Weight::note; });
  out["trust"] = trust_json(findings);
  out["notes"] = lines(notes);
  out["warnings"] = lines(findings);
  out["findings"] = Json::array();
  for (const Finding& f : findings) out["findings"].push_back(finding_json(f));
}

/// Least work that all hands together have done on the body so far, over the run [J]; below 0: energy came out.
double least_work_of_both(const SessionResult& result) {
  double work = 0, least = 0;
  for (std::size_t i = 1; i < result.tools[0].frames.size(); ++i) {
    for (const ToolRun& tool : result.tools)
      work -= tool.frames[i].force.dot(tool.frames[i].pose.x - tool.frames[i - 1].pose.x);
    least = std::min(least, work);
  }
  return least;
}

/// What the check against the whole body found of one tool; null where it was not made.
Json lost_json(std::span<const LocalFrame> frames, std::span<const double> penetration, int missed,
               const LostContact& lost) {
  const auto at_edge = std::ranges::count_if(frames, [](const LocalFrame& f) { return (f.flags & kLeftPatch) != 0; });
  Json out{{"missed_impacts", nullptr}, {"free_ticks_inside", nullptr}, {"went_through", nullptr}};
  out["edge_ticks"] = at_edge;
  out["penetration_max_m"] = nullptr;
  if (penetration.empty()) return out;
  out["missed_impacts"] = missed;
  out["free_ticks_inside"] = lost.free_ticks_inside;
  out["went_through"] = Json::array();
  for (const auto& [tick, distance] : lost.went_through)
    out["went_through"].push_back({{"tick", tick}, {"t", frames[static_cast<std::size_t>(tick)].t}, {"m", distance}});
  out["penetration_max_m"] = *std::max_element(penetration.begin(), penetration.end());
  return out;
}

/// In which the tool was inside and the body was pushed off it.
auto pushed_out_ticks(std::span<const LocalFrame> frames) {
  return std::ranges::count_if(frames, [](const LocalFrame& f) { return (f.flags & kPushedOut) != 0; });
}

Json second_tool_json(const Scene& scene, const SessionResult& result, const ForceMetrics& force) {
  const ToolRun& run = result.tools[1];
  const Json lost = lost_json(run.frames, run.penetration, run.missed_impacts, run.lost);
  return {{"force", force_json(force, scene.contact)},
          {"ticks", ticks_json(force, run.frames.size())},
          {"events", events_json(run.frames)},
          {"crossings", force.crossings},
          {"lost_contacts", force.lost_contacts},
          {"pushed_out_ticks", pushed_out_ticks(run.frames)},
          {"missed_impacts", lost["missed_impacts"]},
          {"free_ticks_inside", lost["free_ticks_inside"]},
          {"edge_ticks", lost["edge_ticks"]},
          {"went_through", lost["went_through"]},
          {"penetration_max_m", lost["penetration_max_m"]},
          {"energy_min_j", force.energy_min},
          {"energy_min_of_both_j", least_work_of_both(result)}};
}

}  // namespace

std::string hash_text(std::uint64_t hash) {
  char out[17];
  std::snprintf(out, sizeof out, "%016llx", static_cast<unsigned long long>(hash));
  return out;
}

Json make_summary(const Session& session, const SessionResult& result) {
  const Scene& scene = session.scene();
  const MeasuredRun measured = measure_run(session, result);
  const ForceMetrics& force = measured.forces[0];
  Json out;
  out["scene"] = scene.title.empty() ? scene.object.mesh : scene.title;
  out["seed"] = scene.seed;
  out["hash"] = hash_text(result.hash);
  out["model"] = model_json(session);
  out["global"] = {{"integrator", scene.global.integrator},
                   {"solver", scene.global.solver},
                   {"definite", scene.global.definite},
                   {"newton_iterations", result.global_steps.iterations},
                   {"linear_iterations", result.global_steps.linear_iterations},
                   {"projected", result.global_steps.projected},
                   {"not_converged", result.global_steps.not_converged},
                   {"looked_ahead", result.refresh.looked_ahead},
                   {"linearization_error", percentiles(result.refresh.linearization_error, false)}};
  if (result.self_contact) {
    const SelfContactRun& s = *result.self_contact;
    const bool touched = s.extremes.contacts > 0;
    out["self_contact"] = {{"contacts", s.extremes.contacts},
                           {"nearest_m", touched ? Json(s.extremes.nearest) : Json(nullptr)},
                           {"normal_n", s.extremes.normal},
                           {"mean_normal_n", s.mean_normal},
                           {"energy_j", s.extremes.energy},
                           {"touching_share", s.touching_share},
                           {"intersections", s.crossings < 0 ? Json(nullptr) : Json(s.crossings)},
                           {"reach_m", s.reach},
                           {"stiffness_n_per_m", s.stiffness}};
  }
  out["local"] = {
      {"method", scene.local.method},
      {"reducer", result.reducer},
      {"name", result.reducer_name},
      {"rings", scene.local.rings},
      {"dof", result.last_dof},
      {"patch_vertices", result.last_patch_vertices},
      {"certified_error", number_or_null(result.certified_error)},
      {"expected_force_error", number_or_null(result.expected_force_error)},
      {"refresh_budget_ms", number_or_null(result.refresh_budget_ms)},
      {"reason", result.reducer_reason},
      {"reducer_changes", changes_json(result.reducer_changes)},
      {"damping_coupling",
       std::isfinite(result.refresh.damping_coupling) ? Json(result.refresh.damping_coupling) : Json(nullptr)},
      {"exact_steps", text(result.refresh.exact_steps, " of ", result.refreshes.size(), " local models")}};
  out["local"]["candidates"] = candidates_json(result.reducer_candidates);
  out["force"] = force_json(force, scene.contact);
  out["ticks"] = ticks_json(force, result.tools[0].frames.size());
  out["events"] = events_json(result.tools[0].frames);
  out["crossings"] = force.crossings;
  out["lost_contacts"] = force.lost_contacts;
  out["pushed_out_ticks"] = pushed_out_ticks(result.tools[0].frames);
  out.update(lost_json(result.tools[0].frames, result.tools[0].penetration, result.tools[0].missed_impacts,
                       result.tools[0].lost));
  out["contact_lost"] = contact_was_lost(scene, result);
  out["contact_solver"] = contact_solver_json(result.tools[0].frames);
  out["energy_min_j"] = force.energy_min;
  if (result.tools[0].device) out["device"] = device_json(result.tools[0]);
  if (result.tools.size() > 1) out["second_tool"] = second_tool_json(scene, result, measured.forces[1]);
  if (result.tools.size() > 1 && result.tools[1].device) out["second_tool"]["device"] = device_json(result.tools[1]);
  out["step_us"] = percentiles(result.step_us, true);
  out["tick_period_share"] = period_shares_json(result.step_us, scene.local.rate_hz);
  if (!result.lateness_us.empty()) {
    out["lateness_us"] = percentiles(result.lateness_us, true);
    out["platform_gaps"] = std::count_if(result.lateness_us.begin(), result.lateness_us.end(),
                                         [&](double late) { return late * scene.local.rate_hz > 1e6; });
    out["real_time_scheduling"] = result.real_time.priority > 0;
  }
  out["global_ms"] = percentiles(result.refresh.global_ms, false);
  out["refresh_ms"] = percentiles(result.refresh.refresh_ms, false);
  for (const auto& [part, ms] : result.refresh.parts_ms) out["refresh_parts_ms"][part] = percentile(ms, 0.5);
  const RefreshEnergy& energy = result.refresh.energy;
  out["refresh_energy_j"] = {{"sum", energy.sum}, {"largest", energy.largest}, {"swaps", energy.swaps}};
  if (!result.refresh.cpu_ms.empty()) out["cpu"] = cpu_json(result);
  out["kernels"] = {{"vectors", vector_width_name()}, {"blas", blas_kernels_name()}};
  out["refreshes"] = result.refreshes.size();
  out["deadline_misses"] = result.deadline_misses;
  out["allocations_per_tick"] =
      result.allocations < 0 || result.tools[0].frames.empty()
          ? Json(nullptr)
          : Json(static_cast<double>(result.allocations) / static_cast<double>(result.tools[0].frames.size()));
  out["mesh_at_contact"] = mesh_at_contact_json(measured.width);
  out["expected_error"] = expected_error_json(measured.width, result.expected_force_error);
  out["real_time"] = real_time_json(measured.pace);
  if (!result.lateness_us.empty()) out["real_time"].update(thread_json(result.real_time));
  add_findings(with_true_cures(scene, all_findings(session, result, measured)), out);
  out["settings"] = Json::parse(to_json(scene));
  return out;
}

}  // namespace kt
