#include "lab/commands/laboratory.hpp"

#include "apps/console/commands.hpp"

namespace kt {

void add_laboratory(CLI::App& app, int& exit_code) {
  const std::size_t others = app.get_subcommands([](const CLI::App*) { return true; }).size();
  add_check_command(app, exit_code);
  add_chart_command(app, exit_code);
  add_stability_command(app, exit_code);
  add_advise_command(app, exit_code);
  add_paper_command(app, exit_code);
  const auto all = app.get_subcommands([](CLI::App*) { return true; });
  for (std::size_t i = others; i < all.size(); ++i) all[i]->group("Laboratory");
}

}  // namespace kt
