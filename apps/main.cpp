// kilotouch: the command. One file a subcommand; see commands.hpp.

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <new>

#include "apps/console/commands.hpp"
#include "apps/console/output_streams.hpp"
#include "apps/console/stop_signals.hpp"
#include "apps/console/words.hpp"
#include "apps/mesh_command.hpp"
#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "haptics/touch/keep_memory.hpp"
#include "io/files/child_process.hpp"

namespace {

/// "kilotouch mesh info": the command as far as it was understood.
std::string chosen(const CLI::App*& app) {
  std::string name = app->get_name();
  for (auto next = app->get_subcommands(); !next.empty(); next = app->get_subcommands()) {
    app = next.front();
    name += ' ' + app->get_name();
  }
  return name;
}

/// One line for what the parser did not like; for an unknown word, with the known ones.
std::string explain(const CLI::App& root, const CLI::ParseError& error, const std::vector<std::string>& words) {
  const CLI::App* app = &root;
  const std::string name = chosen(app);
  const std::vector<std::string> extra = root.remaining(true);  // in no order
  const auto is_extra = [&](const std::string& word) { return std::ranges::find(extra, word) != extra.end(); };
  const auto first = std::ranges::find_if(words, is_extra);
  const auto option =
      std::ranges::find_if(words, [&](const auto& word) { return word.starts_with("--") && is_extra(word); });
  std::vector<std::string> known;
  try {
    if (option != words.end()) {
      for (const CLI::Option* o : app->get_options())
        for (const std::string& known_name : o->get_lnames()) known.push_back("--" + known_name);
      kt::throw_unknown("option", option->substr(0, option->find('=')), known);
    }
    const auto commands = app->get_subcommands([](const CLI::App*) { return true; });
    for (const CLI::App* command : commands) known.push_back(command->get_name());
    if (!commands.empty() && first != words.end()) kt::throw_unknown("command", *first, known);
  } catch (const kt::InputError& e) {
    return name + ": " + e.what();
  }
  return name + ": " + error.what() + " (see " + name + " --help)";
}

/// The parser's words come from the command line and may hold anything; a message is one line.
void complain(const std::string& message) { std::cerr << kt::visible(message) << '\n'; }

/// To the command, or to those of it.
void add_quiet_option(CLI::App& command) {
  const auto inner = command.get_subcommands([](CLI::App*) { return true; });
  for (CLI::App* one : inner) add_quiet_option(*one);
  if (inner.empty()) kt::add_quiet_option(command);
}

/// Runs what the words ask for.    @returns the exit code
int run(int argc, char** argv) {
  kt::keep_freed_memory();
  CLI::App app{"kilotouch: haptic-rate contact with deformable objects", "kilotouch"};
  app.set_version_flag("-V,--version", KT_VERSION "\nlicence of this build: " KT_LICENCE);
  app.require_subcommand(1);
  int exit_code = 0;
  kt::add_run_command(app, exit_code);
  kt::add_view_command(app, exit_code);
  kt::add_replay_command(app, exit_code);
  kt::add_compare_command(app, exit_code);
  kt::add_mesh_command(app, exit_code);
  kt::add_device_command(app, exit_code);
  kt::add_serve_command(app, exit_code);
  kt::add_touch_command(app, exit_code);
  kt::add_key_command(app, exit_code);
  kt::add_list_command(app, exit_code);
#if KT_WITH_LAB
  kt::add_laboratory(app, exit_code);
#endif
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) add_quiet_option(*command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help, --version
    complain(explain(app, e, {argv + 1, argv + argc}));
    return 2;
  } catch (const kt::InputError& e) {
    complain(kt::text("kilotouch: ", e.what()));
    return 2;
  } catch (const kt::RunError& e) {
    complain(kt::text("kilotouch: ", e.what()));
    return 1;
  } catch (const kt::ChildKilled& e) {
    complain(kt::text("kilotouch: ", e.what()));
    return 1;
  } catch (const std::bad_alloc&) {
    complain("kilotouch: more memory is needed than there is: take a coarser mesh, a smaller reach or a shorter run");
    return 1;
  } catch (const std::filesystem::filesystem_error& e) {
    complain(kt::text("kilotouch: ", e.path1().string(), ": ", e.code().message()));
    return 2;
  } catch (const std::exception& e) {
    complain(kt::text("kilotouch: an error of the program, please report it with the command: ", e.what()));
    return 1;
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  kt::OutputStreams streams;
  kt::watch_stop_signals();
  int exit_code = run(argc, argv);
  if (!streams.finish() && exit_code == 0) exit_code = 1;
  if (kt::stop_signal() == 0) return exit_code;
  std::cerr << "kilotouch: stopped by " << kt::stop_signal_name() << '\n';
  return 128 + kt::stop_signal();
}
