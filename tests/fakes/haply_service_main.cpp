// A Haply Inverse Service without a device, until it is ended:
//   fake_haply_service PORT [MASS DAMPING STIFFNESS DELAY_MS [DEPTH_MM RADIUS_MM PERIOD_S]] [NAME=VALUE]...
// What is set otherwise than documented, by name: vector=0 values=0 repeats=0 old=1 kept=mount scale=0.5 http=0
// in_use=1 type=minverse grips=0 ids=A1,A2 fault=silent|deaf|uncalibrated|unpowered|not_ready|no_device A hand holds
// the device: 3 s after the first force it goes DEPTH_MM down within a second and then round a circle of RADIUS_MM. At
// the end, and every 5 s, a line of what the device was told.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "tests/fakes/haply_service.hpp"

namespace {
volatile std::sig_atomic_t is_over = 0;

kt::HaplyFault fault_of(const std::string& name) {
  using kt::HaplyFault;
  const std::map<std::string, HaplyFault> all{
      {"silent", HaplyFault::silent},       {"deaf", HaplyFault::deaf},
      {"unpowered", HaplyFault::unpowered}, {"not_ready", HaplyFault::not_ready},
      {"no_device", HaplyFault::no_device}, {"uncalibrated", HaplyFault::uncalibrated}};
  const auto found = all.find(name);
  return found == all.end() ? HaplyFault::none : found->second;
}

std::vector<std::string> list(const std::string& all) {
  std::vector<std::string> out(1);
  for (const char c : all)
    if (c == ',')
      out.emplace_back();
    else
      out.back().push_back(c);
  return out;
}

/// Takes NAME=VALUE out of the arguments.
std::map<std::string, std::string> named(int& argc, char** argv) {
  std::map<std::string, std::string> out;
  for (int i = argc - 1; i > 0 && std::string(argv[i]).find('=') != std::string::npos; --i, --argc) {
    const std::string all = argv[i];
    out[all.substr(0, all.find('='))] = all.substr(all.find('=') + 1);
  }
  return out;
}
}  // namespace

int main(int argc, char** argv) {
  const std::map<std::string, std::string> names = named(argc, argv);
  const auto number = [&](int i, double usual) { return i < argc ? std::atof(argv[i]) : usual; };
  kt::FakeHaplyOptions options;
  options.port = static_cast<unsigned short>(number(1, 10001));
  options.mass = number(2, 0.1);
  options.damping = number(3, 3);
  options.stiffness = number(4, 300);
  options.delay = 1e-3 * number(5, 0.5);
  for (const auto& [name, value] : names) {
    const bool is_on = value != "0";
    if (name == "vector") options.knows_vector = is_on;
    if (name == "values") options.knows_values = is_on;
    if (name == "repeats") options.repeats = is_on;
    if (name == "old") options.is_old = is_on;
    if (name == "http") options.has_http = is_on;
    if (name == "in_use") options.is_in_use = is_on;
    if (name == "kept") options.kept = value;
    if (name == "type") options.type = value;
    if (name == "scale") options.force_scale = std::atof(value.c_str());
    if (name == "grips" && !is_on) options.grips.clear();
    if (name == "ids") options.ids = list(value);
  }
  const double depth = 1e-3 * number(6, 10), radius = 1e-3 * number(7, 5), period = number(8, 4);
  options.target = [=](double t) {
    const double down = depth * std::clamp(t - 3, 0.0, 1.0), a = 2 * M_PI * std::max(0.0, t - 4) / period;
    return kt::Vec3(radius * std::sin(a), -0.12 + radius * (std::cos(a) - 1), 0.15 - down);
  };
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { is_over = 1; });
  kt::FakeHaply service(options);
  if (names.contains("fault")) service.set_fault(fault_of(names.at("fault")));
  std::printf("listens on %s\n", service.address().c_str());
  std::fflush(stdout);
  for (int i = 1; !is_over; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (i % 50 != 0 && !is_over) continue;
    const kt::HeardSum heard = service.heard_sum();
    std::printf(
        "t %.0f s: %zu messages with a force, %zu without, %zu of an unknown name, connections %d, largest force %.4g "
        "N, largest step %.4g N, all finite: %s, last force "
        "%.4g N, "
        "most energy given to the hand %.4g mJ\n",
        service.now(), heard.messages, heard.questions, heard.unknown, service.connections(), heard.most_force,
        heard.most_step, heard.is_finite ? "yes" : "no", heard.last, 1e3 * service.most_energy_given());
    std::fflush(stdout);
  }
}
