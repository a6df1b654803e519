// A Haply Inverse Service without a device, until it is ended:
//   fake_haply_service PORT [MASS DAMPING STIFFNESS DELAY_MS [DEPTH_MM RADIUS_MM PERIOD_S]]
// A hand holds the device: 3 s after the first force it goes DEPTH_MM down within a second and then round a circle of
// RADIUS_MM. At the end, and every 5 s, a line of what the device was told.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "tests/fakes/haply_service.hpp"

namespace {
volatile std::sig_atomic_t is_over = 0;
}

int main(int argc, char** argv) {
  const auto number = [&](int i, double usual) { return i < argc ? std::atof(argv[i]) : usual; };
  kt::FakeHaplyOptions options;
  options.port = static_cast<unsigned short>(number(1, 10001));
  options.mass = number(2, 0.1);
  options.damping = number(3, 3);
  options.stiffness = number(4, 300);
  options.delay = 1e-3 * number(5, 0.5);
  const double depth = 1e-3 * number(6, 10), radius = 1e-3 * number(7, 5), period = number(8, 4);
  options.target = [=](double t) {
    const double down = depth * std::clamp(t - 3, 0.0, 1.0), a = 2 * M_PI * std::max(0.0, t - 4) / period;
    return kt::Vec3(radius * std::sin(a), -0.12 + radius * (std::cos(a) - 1), 0.15 - down);
  };
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { is_over = 1; });
  kt::FakeHaply service(options);
  std::printf("listens on %s\n", service.address().c_str());
  std::fflush(stdout);
  for (int i = 1; !is_over; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (i % 50 != 0 && !is_over) continue;
    const kt::HeardSum heard = service.heard_sum();
    std::printf(
        "t %.0f s: %zu messages, connections %d, largest force %.4g N, largest step %.4g N, all finite: %s, last force "
        "%.4g N, "
        "most energy given to the hand %.4g mJ\n",
        service.now(), heard.messages, service.connections(), heard.most_force, heard.most_step,
        heard.is_finite ? "yes" : "no", heard.last, 1e3 * service.most_energy_given());
    std::fflush(stdout);
  }
}
