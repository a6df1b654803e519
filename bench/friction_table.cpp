// Textbook problems of friction solved by the tick, against their closed forms, at several steps.
//   build/release/bench/friction_table [--seconds N]      N: how long creep is watched (default 60)
#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/friction_rig.hpp"

int main(int argc, char** argv) {
  using namespace kt;
  double seconds = 60;
  CLI::App app;
  app.add_option("--seconds", seconds, "how long creep is watched")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);

  std::printf("Stick-slip of a block under a belt\n%8s %-15s | %9s %8s | %9s %8s | %9s %8s | %9s\n", "step", "scheme",
              "period", "error", "lowest", "error", "highest", "error", "apart");
  const StickSlip rig;
  const StickSlipMotion exact = closed_form(rig);
  for (const LocalScheme scheme : {LocalScheme::exact, LocalScheme::implicit_euler})
    for (const double h : {1e-4, 5e-4, 1e-3, 2e-3}) {
      StickSlip s = rig;
      s.block.scheme = scheme;
      const StickSlipMotion m = measure(s, h, 10);
      const double swing = exact.highest - exact.lowest;
      std::printf("%5.1f ms %-15s | %7.4f s %7.3f%% | %6.3f mm %7.3f%% | %6.3f mm %7.3f%% | %7.0e m\n", 1e3 * h,
                  scheme == LocalScheme::exact ? "exact" : "implicit_euler", m.period,
                  100 * (m.period / exact.period - 1), 1e3 * m.lowest, 100 * (m.lowest - exact.lowest) / swing,
                  1e3 * m.highest, 100 * (m.highest - exact.highest) / swing, m.stick_slip_apart);
      std::fflush(stdout);
    }
  std::printf("closed form: %.4f s, %.3f mm, %.3f mm; errors of places by the swing\n\n", exact.period,
              1e3 * exact.lowest, 1e3 * exact.highest);

  std::printf("Pushed along the surface with a share of mu F_N for %g s: way\n%8s | %9s %9s %9s\n", seconds, "step",
              "0.5", "0.99", "1.01");
  for (const double h : {5e-4, 1e-3, 2e-3}) {
    std::printf("%5.1f ms | %7.1e m %7.1e m %7.1e m\n", 1e3 * h, creep(0.5, h, seconds), creep(0.99, h, seconds),
                creep(1.01, h, seconds));
    std::fflush(stdout);
  }

  std::printf("\n%8s | %15s | %15s %15s | %13s\n%8s | %15s | %15s %15s | %13s\n", "step", "critical slope",
              "way to rest", "friction work", "rolling ball", "", "tan / mu - 1", "/ v^2/2 mu g - 1",
              "/ energy lost - 1", "way - 1");
  for (const double h : {5e-4, 1e-3, 2e-3}) {
    const Stop stop = slide_to_rest(1, 0.3, h);
    std::printf("%5.1f ms | %14.4f%% | %14.3f%% %14.3f%% | %12.3f%%\n", 1e3 * h, 100 * critical_slope_error(0.5, h),
                100 * (stop.distance / stop.closed_form - 1), 100 * (stop.friction_work / stop.lost - 1),
                100 * rolling_error(0.3, 0.5, h));
    std::fflush(stdout);
  }
}
