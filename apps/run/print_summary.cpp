#include "apps/run/print_summary.hpp"

#include <iostream>

#include "apps/outputs/device_summary.hpp"
#include "core/base/error.hpp"
#include "core/base/numbers.hpp"

namespace kt {

namespace {

using Json = nlohmann::ordered_json;

void line(const std::string& name, const std::string& content) {
  std::cout << "  " << name << std::string(name.size() < 14 ? 14 - name.size() : 1, ' ') << content << '\n';
}

std::string force_line(const Json& force) {
  // A friction of zero is one within rounding.
  const double least = 1e-9 * force["max_n"].get<double>();
  const auto newtons = [&](const char* key) {
    const double value = force[key].get<double>();
    return short_number(value < least ? 0 : value);
  };
  return text("normal mean ", newtons("mean_n"), " N, largest ", newtons("max_n"), " N; friction mean ",
              newtons("mean_t"), " N, largest ", newtons("max_t"), " N");
}

/// The processor's time of a tick, of the time that there is for one.
std::string tick_line(const Json& s) {
  const auto value = [&](const char* group, const char* key) { return s[group][key].get<double>(); };
  return text("median ", in_unit(1e-6 * value("step_us", "p50"), "s"), ", ",
              in_percent(value("tick_period_share", "p50")), " of its period; 99 of 100 within ",
              in_percent(value("tick_period_share", "p99")), "; ", s["deadline_misses"], " of ", s["ticks"]["total"],
              " over it");
}

std::string body_line(const Json& model) {
  const auto mm = [&](int i) { return short_number(1e3 * model["size_m"][i].get<double>()); };
  return text(mm(0), " x ", mm(1), " x ", mm(2), " mm, one unit of the mesh file is ",
              short_number(model["mesh_unit_m"].get<double>()), " m; ", model["type"].get<std::string>(), ", ",
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
void print_cells(const Json& width, const Json& error) {
  if (width.is_null() || width["force_factor"].is_null()) return;
  const auto percent = [&](const char* key) { return in_percent(error[key].get<double>(), 2); };
  const auto mm = [&](const char* key, double times) {
    return short_number(1e3 * times * width[key].get<double>(), 2);
  };
  line("cells",
       text(mm("cell_m", 1), " mm under a contact of ", mm("contact_radius_m", 2), " mm",
            width["refined"] ? ", refined under the tool" : ", as they are", ": expect about ",
            short_number(width["force_factor"].get<double>()), " times the force of the continuum",
            error["together"].is_null() ? std::string() : " (" + percent("together") + " off with the local model)"));
}

void print_reference(const Json& s) {
  const auto value = [&](const char* group, const char* key) { return s[group][key].get<double>(); };
  if (s.contains("reference"))
    line("reference", text("force error ", in_percent(value("reference", "force_error")), ", noticeable in ",
                           in_percent(value("reference", "jnd_fraction")), " of the time, against ",
                           short_number(1e-3 * value("reference", "rate_hz")), " kHz (",
                           short_number(value("reference", "seconds")), " s)"));
  if (s.contains("reference") && s["reference"].contains("second_tool")) {
    const auto& second = s["reference"]["second_tool"];
    line("", text("second tool: force error ", in_percent(second["force_error"].get<double>()), ", noticeable in ",
                  in_percent(second["jnd_fraction"].get<double>()), " of the time"));
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
  print_cells(s["mesh_at_contact"], s["expected_error"]);
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
  line("local model",
       text(s["local"]["name"].get<std::string>(), ", ", s["local"]["dof"], " dof, ", s["local"]["patch_vertices"],
            " patch vertices",
            s["local"]["certified_error"].is_null()
                ? std::string()
                : ", its impedance off by " + in_percent(value("local", "certified_error"), 2) +
                      " at the worst of 0 to 500 Hz",
            s["local"]["expected_force_error"].is_null()
                ? std::string()
                : ", force error of the local model alone " + in_percent(value("local", "expected_force_error"), 2)));
  if (s["settings"]["local"]["reducer"] == "auto") line("", s["local"]["reason"].get<std::string>());
  for (const Json& c : s["local"]["reducer_changes"])
    line("", text("tick ", c["tick"], ": ", c["from"].get<std::string>(), " -> ", c["to"].get<std::string>(), ": ",
                  c["why"].get<std::string>()));
  if (s.contains("second_tool")) {
    const auto& second = s["second_tool"];
    line("second tool", text(second["lost_contacts"], " contacts lost",
                             second["penetration_max_m"].is_null()
                                 ? std::string()
                                 : text(", ", second["missed_impacts"], " missed impacts, deepest penetration ",
                                        in_unit(second["penetration_max_m"].get<double>(), "m"))));
  }
  line("steadiness", text("buzz ", in_percent(value("force", "buzz")), ", jump at edges ",
                          in_percent(value("force", "crossing_jump")), ", at refreshes ",
                          in_percent(value("force", "refresh_jump")), " of the mean force"));
  line("ticks", text(s["ticks"]["total"], ": ", s["ticks"]["free"], " free, ", s["ticks"]["stick"], " stick, ",
                     s["ticks"]["slide"], " slide, ", s["ticks"]["frictional_slide"], " slide with friction; ",
                     s["crossings"], " edges crossed, ", s["lost_contacts"], " contacts lost"));
  if (!s["penetration_max_m"].is_null())
    line("checked",
         text(s["missed_impacts"], " missed impacts, ", s["free_ticks_inside"],
              " ticks inside the body without contact, deepest penetration ",
              in_unit(s["penetration_max_m"].get<double>(), "m"), "; ", s["edge_ticks"], " ticks at the patch's edge"));
  line("haptic step",
       text("median ", in_unit(1e-6 * value("step_us", "p50"), "s"), ", p99.9 ",
            in_unit(1e-6 * value("step_us", "p999"), "s"), " (CPU), ", in_percent(value("tick_period_share", "p50")),
            " of the period, p99 ", in_percent(value("tick_period_share", "p99")), "; ", s["deadline_misses"],
            " over the period; ",
            s["allocations_per_tick"].is_null() ? std::string("allocations not counted")
                                                : text(s["allocations_per_tick"], " allocations a tick")));
  if (s.contains("self_contact")) {
    const auto& touch = s["self_contact"];
    line("self-contact",
         touch["nearest_m"].is_null()
             ? std::string("none: the body did not touch itself")
             : text("up to ", touch["contacts"], " pairs, nearest ", in_unit(touch["nearest_m"].get<double>(), "m"),
                    "; normal mean ", short_number(value("self_contact", "mean_normal_n")), " N, max ",
                    short_number(value("self_contact", "normal_n")), " N",
                    touch["intersections"].is_null() ? std::string()
                                                     : text("; ", touch["intersections"], " intersections")));
  }
  if (s.contains("lateness_us"))
    line("lateness", text("median ", in_unit(1e-6 * value("lateness_us", "p50"), "s"), ", p99.9 ",
                          in_unit(1e-6 * value("lateness_us", "p999"), "s"), "; ", s["platform_gaps"],
                          " platform gaps over a period"));
  line("refresh", text("global step ", short_number(value("global_ms", "p50")), " ms, linearize and reduce ",
                       short_number(value("refresh_ms", "p50")), " ms (medians)"));
  line("hash", s["hash"].get<std::string>());
}

}  // namespace kt
