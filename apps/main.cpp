// kilotouch: the command. One file a subcommand; see commands.hpp.
#include <csignal>
#include <iostream>

#include "apps/commands.hpp"
#include "apps/mesh_command.hpp"
#include "core/error.hpp"

namespace {

std::atomic<bool> stop{false};

void on_interrupt(int) {
  if (stop.exchange(true)) std::_Exit(130);  // the second Ctrl-C does not wait
}

}  // namespace

const std::atomic<bool>& kt::stop_requested() { return stop; }

int main(int argc, char** argv) {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  CLI::App app{"kilotouch: haptic-rate contact with deformable objects", "kilotouch"};
  app.set_version_flag("--version", KT_VERSION);
  app.require_subcommand(1);
  int exit_code = 0;
  kt::add_run_command(app, exit_code);
  kt::add_drag_command(app, exit_code);
  kt::add_paper_command(app, exit_code);
  kt::add_replay_command(app, exit_code);
  kt::add_mesh_command(app, exit_code);
  kt::add_list_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help, --version
    std::cerr << "kilotouch: " << e.what() << " (see kilotouch --help)\n";
    return 2;
  } catch (const kt::InputError& e) {
    std::cerr << "kilotouch: " << e.what() << '\n';
    return 2;
  } catch (const std::exception& e) {
    std::cerr << "kilotouch: " << e.what() << '\n';
    return 1;
  }
  return exit_code;
}
