#include "apps/print_summary.hpp"

#include <cstdio>
#include <iostream>

#include "apps/outputs/device_summary.hpp"
#include "core/base/error.hpp"

namespace kt {

namespace {

using Json = nlohmann::ordered_json;

void line(const std::string& name, const std::string& content) {
  std::cout << "  " << name << std::string(name.size() < 14 ? 14 - name.size() : 1, ' ') << content << '\n';
}

std::string number(double v, const char* format) {
  char out[48];
  std::snprintf(out, sizeof out, format, v);
  return out;
}

std::string force_line(const Json& force) {
  const auto newtons = [&](const char* key) { return number(force[key].get<double>(), "%.3g"); };
  return text("normal mean ", newtons("mean_n"), " N, largest ", newtons("max_n"), " N; friction mean ",
              newtons("mean_t"), " N, largest ", newtons("max_t"), " N");
}

/// The processor's time of a tick, of the time that there is for one.
std::string tick_line(const Json& s) {
  const auto value = [&](const char* group, const char* key) { return s[group][key].get<double>(); };
  return text("median ", number(value("step_us", "p50"), "%.3g"), " us, ",
              number(100 * value("tick_period_share", "p50"), "%.3g"), " % of its period; 99 of 100 within ",
              number(100 * value("tick_period_share", "p99"), "%.3g"), " %; ", s["deadline_misses"], " of ",
              s["ticks"]["total"], " over it");
}

std::string body_line(const Json& model) {
  const auto mm = [&](int i) { return number(1e3 * model["size_m"][i].get<double>(), "%.3g"); };
  return text(mm(0), " x ", mm(1), " x ", mm(2), " mm, one unit of the mesh file is ",
              number(model["mesh_unit_m"].get<double>(), "%.3g"), " m; ", model["type"].get<std::string>(), ", ",
              model["nodes"], " nodes");
}

void print_trust(const Json& trust) {
  const Json& reasons = trust["reasons"];
  if (reasons.empty()) return line("trustworthy", "yes");
  line("trustworthy", "no");
  for (const Json& reason : reasons) {
    std::cout << "    - " << reason["what"].get<std::string>() << '\n';
    if (!reason["cure"].is_null()) std::cout << "      cure: " << reason["cure"].get<std::string>() << '\n';
  }
}

/// The mesh's share of the force: what no --reference on the same cells tells.
void print_cells(const Json& width) {
  if (width.is_null() || width["force_factor"].is_null()) return;
  const auto mm = [&](const char* key, double times) { return number(1e3 * times * width[key].get<double>(), "%.2g"); };
  line("cells", text(mm("cell_m", 1), " mm under a contact of ", mm("contact_radius_m", 2), " mm",
                     width["refined"] ? ", refined under the tool" : ", as they are", ": expect about ",
                     number(width["force_factor"].get<double>(), "%.3g"), " times the force of the continuum"));
}

void print_reference(const Json& s) {
  const auto value = [&](const char* group, const char* key) { return s[group][key].get<double>(); };
  if (s.contains("reference"))
    line("reference", text("force error ", number(100 * value("reference", "force_error"), "%.3g"),
                           " %, noticeable in ", number(100 * value("reference", "jnd_fraction"), "%.3g"),
                           " % of the time, against ", number(1e-3 * value("reference", "rate_hz"), "%.3g"), " kHz (",
                           number(value("reference", "seconds"), "%.3g"), " s)"));
  if (s.contains("reference") && s["reference"].contains("second_tool")) {
    const auto& second = s["reference"]["second_tool"];
    line("", text("second tool: force error ", number(100 * second["force_error"].get<double>(), "%.3g"),
                  " %, noticeable in ", number(100 * second["jnd_fraction"].get<double>(), "%.3g"), " % of the time"));
  }
}

}  // namespace

void print_summary(const Json& s) {
  std::cout << s["scene"].get<std::string>() << '\n';
  line("force", force_line(s["force"]));
  if (s.contains("second_tool")) line("second tool", force_line(s["second_tool"]["force"]));
  if (s.contains("device")) line("device", device_line(s["device"]));
  if (s.contains("second_tool") && s["second_tool"].contains("device"))
    line("second device", device_line(s["second_tool"]["device"]));
  line("real time", s["real_time"]["told"].get<std::string>());
  print_trust(s["trust"]);
  print_cells(s["mesh_at_contact"]);
  line("haptic tick", tick_line(s));
  if (s["real_time"].contains("thread")) line("its thread", s["real_time"]["thread"].get<std::string>());
  line("body", body_line(s["model"]));
  print_reference(s);
  for (const Json& note : s["notes"]) std::cout << "  warning: " << note.get<std::string>() << '\n';
}

void print_details(const nlohmann::ordered_json& s) {
  const auto value = [&](const char* group, const char* key) { return s[group][key].get<double>(); };
  line("body", text(s["model"]["type"].get<std::string>(), ", ", s["model"]["nodes"], " nodes, ", s["model"]["tets"],
                    " tetrahedra, ", s["model"]["triangles"], " surface triangles"));
  line("local model", text(s["local"]["name"].get<std::string>(), ", ", s["local"]["dof"], " dof, ",
                           s["local"]["patch_vertices"], " patch vertices",
                           s["local"]["certified_error"].is_null()
                               ? std::string()
                               : ", its impedance off by " + number(100 * value("local", "certified_error"), "%.2g") +
                                     " % at the worst of 0 to 500 Hz",
                           s["local"]["expected_force_error"].is_null()
                               ? std::string()
                               : ", force error of the local model alone " +
                                     number(100 * value("local", "expected_force_error"), "%.2g") + " %"));
  if (s["settings"]["local"]["reducer"] == "auto") line("", s["local"]["reason"].get<std::string>());
  for (const Json& c : s["local"]["reducer_changes"])
    line("", text("tick ", c["tick"], ": ", c["from"].get<std::string>(), " -> ", c["to"].get<std::string>(), ": ",
                  c["why"].get<std::string>()));
  line("force",
       text("normal mean ", number(value("force", "mean_n"), "%.4g"), " N, max ",
            number(value("force", "max_n"), "%.4g"), " N; tangential mean ", number(value("force", "mean_t"), "%.4g"),
            " N, max ", number(value("force", "max_t"), "%.4g"), " N"));
  if (s.contains("second_tool")) {
    const auto& second = s["second_tool"];
    const auto of_force = [&](const char* key) { return number(second["force"][key].get<double>(), "%.4g"); };
    line("second tool",
         text("normal mean ", of_force("mean_n"), " N, max ", of_force("max_n"), " N; tangential mean ",
              of_force("mean_t"), " N, max ", of_force("max_t"), " N; ", second["lost_contacts"], " contacts lost",
              second["penetration_max_m"].is_null()
                  ? std::string()
                  : text(", ", second["missed_impacts"], " missed impacts, deepest penetration ",
                         number(1e6 * second["penetration_max_m"].get<double>(), "%.3g"), " um")));
  }
  line("steadiness", text("buzz ", number(100 * value("force", "buzz"), "%.3g"), " %, jump at edges ",
                          number(100 * value("force", "crossing_jump"), "%.3g"), " %, at refreshes ",
                          number(100 * value("force", "refresh_jump"), "%.3g"), " % of the mean force"));
  line("ticks", text(s["ticks"]["total"], ": ", s["ticks"]["free"], " free, ", s["ticks"]["stick"], " stick, ",
                     s["ticks"]["slide"], " slide, ", s["ticks"]["frictional_slide"], " slide with friction; ",
                     s["crossings"], " edges crossed, ", s["lost_contacts"], " contacts lost"));
  if (!s["penetration_max_m"].is_null())
    line("checked", text(s["missed_impacts"], " missed impacts, ", s["free_ticks_inside"],
                         " ticks inside the body without contact, deepest penetration ",
                         number(1e6 * s["penetration_max_m"].get<double>(), "%.3g"), " um; ", s["edge_ticks"],
                         " ticks at the patch's edge"));
  line("haptic step",
       text("median ", number(value("step_us", "p50"), "%.3g"), " us, p99.9 ", number(value("step_us", "p999"), "%.3g"),
            " us (CPU), ", number(100 * value("tick_period_share", "p50"), "%.3g"), " % of the period, p99 ",
            number(100 * value("tick_period_share", "p99"), "%.3g"), " %; ", s["deadline_misses"], " over the period; ",
            s["allocations_per_tick"].is_null() ? std::string("allocations not counted")
                                                : text(s["allocations_per_tick"], " allocations a tick")));
  if (s.contains("self_contact")) {
    const auto& touch = s["self_contact"];
    line("self-contact",
         touch["nearest_m"].is_null()
             ? std::string("none: the body did not touch itself")
             : text("up to ", touch["contacts"], " pairs, nearest ",
                    number(1e6 * touch["nearest_m"].get<double>(), "%.3g"), " um; normal mean ",
                    number(value("self_contact", "mean_normal_n"), "%.3g"), " N, max ",
                    number(value("self_contact", "normal_n"), "%.3g"), " N",
                    touch["intersections"].is_null() ? std::string()
                                                     : text("; ", touch["intersections"], " intersections")));
  }
  if (s.contains("lateness_us"))
    line("lateness", text("median ", number(value("lateness_us", "p50"), "%.3g"), " us, p99.9 ",
                          number(value("lateness_us", "p999"), "%.3g"), " us; ", s["platform_gaps"],
                          " platform gaps over a period"));
  line("refresh", text("global step ", number(value("global_ms", "p50"), "%.3g"), " ms, linearize and reduce ",
                       number(value("refresh_ms", "p50"), "%.3g"), " ms (medians)"));
  line("hash", s["hash"].get<std::string>());
}

}  // namespace kt
