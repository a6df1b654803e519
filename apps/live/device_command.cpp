// kilotouch device list | test NAME | identify NAME: haptic devices without a scene.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/console/words.hpp"
#include "apps/live/machine_report.hpp"
#include "apps/outputs/run_summary.hpp"
#include "core/base/error.hpp"
#include "haptics/device/device_backends.hpp"
#include "haptics/driver/find_devices.hpp"
#include "haptics/guard/device_identify.hpp"
#include "haptics/guard/device_test.hpp"
#include "haptics/guard/device_troubles.hpp"
#include "haptics/setup/scene_safety.hpp"
#include "io/files/json_file.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

struct DeviceArguments {
  DeviceSettings device;
  std::string json;
  bool of_machine = false, is_busy = false;
  double seconds = 10, rate_hz = 1000, wall = 200, max_force = 0;
};

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json percentiles_ms(const std::vector<double>& sorted) {
  return {{"p50", number(1e3 * sorted_percentile(sorted, 0.5))},
          {"p99", number(1e3 * sorted_percentile(sorted, 0.99))},
          {"max", number(1e3 * sorted_percentile(sorted, 1))}};
}

void print_row(const std::string& name, const std::string& content) {
  std::cout << "  " << name << std::string(name.size() < 18 ? 18 - name.size() : 1, ' ') << content << '\n';
}

std::unique_ptr<HapticDevice> open_device(const DeviceArguments& a) {
  require_backend("device", a.device.name, live_device_backends());
  if (a.device.name == "pushed")
    throw InputError("device pushed: has no device; it is for programs that embed the engine");
  DeviceOptions options;
  options.live = a.device;
  options.h = 1 / a.rate_hz;
  return make_device(a.device.name, options);
}

SafetyOptions safety_of(const DeviceArguments& a) {
  SafetyOptions out;
  if (a.max_force > 0) out.max_force = a.max_force;
  out.max_slew = a.device.max_slew;
  out.deadman = button_mask(a.device.deadman);
  return out;
}

void check(const DeviceArguments& a) {
  const auto range = [](const char* name, double value, double least, double most) {
    if (!(value >= least && value <= most))
      throw InputError(text(name, " is ", value, ", must be ", least, " .. ", most));
  };
  range("--seconds", a.seconds, 0.1, 3600);
  range("--rate", a.rate_hz, 100, 10000);
  range("--wall", a.wall, 1, 5000);
  if (a.max_force != 0) range("--max-force", a.max_force, 0.01, 40);
}

void list_devices(const DeviceArguments& a) {
  Json json = Json::array();
  for (const BackendInfo& backend : live_device_backends()) {
    if (backend.name == "pushed") continue;
    if (!backend.available) {
      print_row(backend.name, text("not in this build: configure with -D", backend.option, "=ON"));
      continue;
    }
    const std::vector<FoundDevice> found = find_devices(backend.name, a.device);
    if (found.empty()) print_row(backend.name, "none found");
    for (const FoundDevice& one : found) {
      print_row(one.backend, one.trouble.empty() ? text(one.name, "  id ", one.id) : one.trouble);
      json.push_back({{"backend", one.backend}, {"id", one.id}, {"name", one.name}, {"trouble", one.trouble}});
    }
  }
  write_json(a.json, json_text(Json{{"devices", json}}, 2) + "\n");
}

Json info_json(const DeviceInfo& info) {
  const auto known = [](double v) { return v > 0 && std::isfinite(v) ? Json(v) : Json(nullptr); };
  return {{"name", info.name},
          {"serial", info.serial},
          {"max_force_n", known(info.max_force)},
          {"continuous_force_n", known(info.continuous_force)},
          {"max_stiffness_n_per_m", known(info.max_stiffness)},
          {"max_damping_ns_per_m", known(info.max_damping)},
          {"gives_force", info.gives_force},
          {"gives_torque", info.gives_torque},
          {"senses_turn", info.senses_turn}};
}

Json test_json(const DeviceArguments& a, const DeviceInfo& info, const DeviceTest& t) {
  Json out{{"device", a.device.name}, {"info", info_json(info)}, {"ticks", t.ticks}, {"seconds", t.seconds}};
  out["readings_per_s"] = t.readings_per_s;
  out["pose_age_ms"] = percentiles_ms(t.pose_age);
  out["delay_ms"] = percentiles_ms(t.delay);
  out["lateness_ms"] = percentiles_ms(t.lateness);
  out["deepest_m"] = t.deepest;
  out["ripple"] = number(t.ripple);
  out["energy_given_j"] = t.given;
  out["most_force_n"] = t.safety.most_force;
  out["most_slew_n_per_s"] = t.safety.most_slew;
  out["most_echoed_n"] = t.safety.most_echoed ? Json(*t.safety.most_echoed) : Json(nullptr);
  out["ticks_without_echo"] = t.safety.unechoed;
  out["jumps"] = t.safety.jumps;
  out["gate"] = name_of(t.gate);
  out["ticks_stale"] = t.safety.stale;
  out["ticks_by_gate"] = Json::object();
  for (std::size_t i = 1; i < kGateReasons; ++i)
    if (const int ticks = t.safety.by_reason[i]; ticks > 0)
      out["ticks_by_gate"][name_of(static_cast<GateReason>(i))] = ticks;
  out["notes"] = t.notes;
  return out;
}

void test(const DeviceArguments& a, int& exit_code) {
  check(a);
  const auto device = open_device(a);
  const DeviceInfo info = device->info();
  print_row("device", text(a.device.name, ": ", info.name, info.serial.empty() ? "" : " " + info.serial));
  print_row("limits", text("force ", std::isfinite(info.max_force) ? short_number(info.max_force) + " N" : "not told",
                           info.continuous_force > 0 ? ", for long " + short_number(info.continuous_force) + " N" : "",
                           info.max_stiffness > 0 ? ", stiffness " + short_number(info.max_stiffness) + " N/m" : ""));
  if (info.gives_force)
    std::cout << "a wall of " << a.wall << " N/m lies 1 cm below: press on it, lightly; " << a.seconds << " s\n";
  DeviceTestOptions options;
  options.seconds = a.seconds;
  options.h = 1 / a.rate_hz;
  options.wall_stiffness = a.wall;
  options.safety = safety_of(a);
  options.stop = &stop_requested();
  if (!is_quiet())
    options.progress = [](double t, const Pose& at, const DeviceState& state, double force, double gate) {
      std::fprintf(stderr,
                   "  %4.1f s  at (%7.2f %7.2f %7.2f) mm  %s, pose %.2f ms old, buttons %x, force %.2f N, gate %.2f\n",
                   t, 1e3 * at.x.x(), 1e3 * at.x.y(), 1e3 * at.x.z(), name_of(state.health), 1e3 * state.age,
                   state.buttons, force, gate);
    };
  const DeviceTest t = test_device(*device, options);
  const auto ms = [](const std::vector<double>& sorted) {
    return text("median ", short_number(1e3 * sorted_percentile(sorted, 0.5)), " ms, p99 ",
                short_number(1e3 * sorted_percentile(sorted, 0.99)), " ms, most ",
                short_number(1e3 * sorted_percentile(sorted, 1)), " ms");
  };
  const Vec3 way = 1e3 * (t.high - t.low);
  print_row("fresh poses", text(short_number(t.readings_per_s), " a second"));
  print_row("pose age", ms(t.pose_age));
  print_row("delay of forces",
            t.delay.empty()
                ? "the device tells none"
                : ms(t.delay) + (info.delay_is_of_messages ? " (a message's way; the motors' is not told)" : ""));
  print_row("ticks late by", ms(t.lateness));
  print_row("moved through",
            text(short_number(way.x()), " x ", short_number(way.y()), " x ", short_number(way.z()), " mm"));
  print_row("force",
            text("up to ", short_number(t.safety.most_force), " N, changed by up to ", short_number(t.safety.most_slew),
                 " N/s; limited in ", t.safety.limited, " of ", t.ticks, " ticks"));
  if (t.safety.most_echoed)
    print_row("repeated", text("up to ", short_number(*t.safety.most_echoed), " N by the device's service; not in ",
                               t.safety.unechoed, " ticks"));
  if (t.deepest > 0)
    print_row("wall",
              text(short_number(1e3 * t.deepest), " mm deep",
                   std::isfinite(t.ripple) ? text(", force swings by ", short_number(100 * t.ripple), " %") : ""));
  print_row("energy", text("at most ", short_number(1e3 * t.given), " mJ given to the hand"));
  for (const std::string& note : t.notes) print_row("note", note);
  const std::vector<Finding> found = find_troubles(a.device.name, info, t, a.rate_hz);
  for (const std::string& trouble : lines(found)) print_row("trouble", trouble);
  if (found.empty()) print_row("verdict", "good");
  exit_code = found.empty() ? 0 : 1;
  Json json = test_json(a, info, t);
  json["troubles"] = lines(found);
  for (const Finding& f : found) json["findings"].push_back(finding_json(f));
  write_json(a.json, json_text(json, 2) + "\n");
}

void identify(const DeviceArguments& a, int& exit_code) {
  check(a);
  const auto device = open_device(a);
  const DeviceInfo info = device->info();
  print_row("device", text(a.device.name, ": ", info.name, info.serial.empty() ? "" : " " + info.serial));
  std::cout << "let go of the device: a spring of " << kReleaseStiffness << " N/m moves it by 15 mm\n";
  IdentifyOptions options;
  options.h = 1 / a.rate_hz;
  options.safety = safety_of(a);
  options.stop = &stop_requested();
  const DeviceFit fit = identify_device(*device, options);
  const auto with_error = [](double value, double error) {
    return text(short_number(value), " +- ", short_number(error, 2));
  };
  const bool is_measured = fit.swing > 0;  // what was not is no zero
  const auto measured = [&](double value) { return is_measured ? number(value) : Json(nullptr); };
  if (is_measured) {
    print_row("damping", with_error(fit.damping, fit.damping_error) + " N.s/m");
    print_row("mass", with_error(fit.mass, fit.mass_error) + " kg");
    print_row("delay", with_error(1e3 * fit.delay, 1e3 * fit.delay_error) + " ms");
  }
  if (fit.is_good())
    print_row("to the scene", text("\"damping\": ", short_number(fit.damping),
                                   ", \"delay_ms\": ", short_number(1e3 * fit.delay), " in tool.path.device"));
  else
    print_row("not to be used", fit.refusal);
  exit_code = fit.is_good() ? 0 : 1;
  const Json json{{"device", a.device.name},
                  {"info", info_json(info)},
                  {"damping_ns_per_m", measured(fit.damping)},
                  {"damping_error", measured(fit.damping_error)},
                  {"mass_kg", measured(fit.mass)},
                  {"mass_error", measured(fit.mass_error)},
                  {"delay_ms", measured(1e3 * fit.delay)},
                  {"delay_error", measured(1e3 * fit.delay_error)},
                  {"residual_m", measured(fit.residual)},
                  {"refusal", fit.is_good() ? Json(nullptr) : Json(fit.refusal)}};
  write_json(a.json, json_text(json, 2) + "\n");
}

void test_computer(const DeviceArguments& a, int& exit_code) {
  MachineTestOptions options;
  options.seconds = std::min(a.seconds, 3.0);
  options.busy = a.is_busy;
  options.stop = &stop_requested();
  const MachineReport report = test_machine(options);
  std::cout << machine_text(report);
  write_json(a.json, json_text(machine_json(report), 2) + "\n");
  exit_code = report.fastest_kept_hz() >= 1000 ? 0 : 1;
}

void add_device_options(CLI::App& command, DeviceArguments& a) {
  command.add_option("--address", a.device.address, "address of Haply's service (ws://HOST:PORT) or spnav's socket");
  command.add_option("--id", a.device.id, "serial number or id, where there are several");
  command.add_option("--library", a.device.library, "the vendor's library, a file");
}

}  // namespace

void add_device_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("device", "list, test and identify haptic devices");
  command->require_subcommand(1);
  auto a = std::make_shared<DeviceArguments>();

  auto* list = command->add_subcommand("list", "devices found, and the obstacles of the others");
  add_device_options(*list, *a);
  add_json_option(*list, a->json, "the devices");
  list->footer("Example:\n  kilotouch device list");
  list->callback([a] { list_devices(*a); });

  auto* test_command = command->add_subcommand("test", "press a device on a soft wall, and measure");
  test_command->add_option("NAME", a->device.name, "haply openhaptics forcedimension spnav");
  test_command->add_flag("--machine", a->of_machine,
                         "without a device, test whether this computer keeps 1, 4 and 8 kHz");
  test_command->add_flag("--busy", a->is_busy, "with --machine, while every core has other work");
  add_device_options(*test_command, *a);
  test_command->add_option("--seconds", a->seconds, "how long")->capture_default_str();
  test_command->add_option("--rate", a->rate_hz, "of the ticks, Hz")->capture_default_str();
  test_command->add_option("--wall", a->wall, "stiffness, N/m")->capture_default_str();
  test_command->add_option("--max-force", a->max_force, "largest force [N], 0 for 3 N or the device's limit if less");
  add_json_option(*test_command, a->json, "the figures");
  test_command->footer("Example:\n  kilotouch device test haply --wall 300");
  test_command->callback([a, test_command, &exit_code] {
    if (a->of_machine == !a->device.name.empty()) throw InputError("device test: name a device, or give --machine");
    for (const char* of_device : {"--seconds", "--rate", "--wall", "--max-force"})
      if (a->of_machine && test_command->count(of_device) > 0)
        throw InputError(text("device test --machine: ", of_device, " is of a device; three rates are measured here"));
    a->of_machine ? test_computer(*a, exit_code) : test(*a, exit_code);
  });

  auto* identify_command = command->add_subcommand("identify", "damping, mass and delay of a device, hands off");
  identify_command->add_option("NAME", a->device.name, "haply openhaptics forcedimension")->required();
  add_device_options(*identify_command, *a);
  identify_command->add_option("--rate", a->rate_hz, "of the ticks, Hz")->capture_default_str();
  identify_command->add_option("--max-force", a->max_force,
                               "largest force [N], 0 for 3 N or the device's limit if less");
  add_json_option(*identify_command, a->json, "the figures");
  identify_command->footer("Example:\n  kilotouch device identify haply");
  identify_command->callback([a, &exit_code] { identify(*a, exit_code); });
}

}  // namespace kt
