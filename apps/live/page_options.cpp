#include "apps/live/page_options.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <iostream>
#include <thread>

#include "core/base/error.hpp"

namespace kt {
namespace {

/// Without a shell: of an address nothing is a command. In a session of its own: Ctrl-C is not the browser's.
void open_browser(const std::string& url) {
  std::string program = "xdg-open", address = url;
  char* const arguments[] = {program.data(), address.data(), nullptr};
  posix_spawn_file_actions_t quiet;
  posix_spawnattr_t apart;
  posix_spawn_file_actions_init(&quiet);
  posix_spawnattr_init(&apart);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&quiet, stream, "/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
  posix_spawnattr_setflags(&apart, POSIX_SPAWN_SETSID);
  pid_t child = 0;
  const bool is_started = posix_spawnp(&child, program.c_str(), &quiet, &apart, arguments, environ) == 0;
  posix_spawn_file_actions_destroy(&quiet);
  posix_spawnattr_destroy(&apart);
  const auto tell = [] { std::cerr << "kilotouch: --open: no browser could be started" << std::endl; };
  if (!is_started) return tell();
  std::thread([child, tell] {
    int status = 0;
    if (waitpid(child, &status, 0) == child && status != 0) tell();
  }).detach();
}

}  // namespace

void add_page_options(CLI::App& command, PageArguments& page, const std::string& prefix) {
  command.add_option("--" + prefix + "port", page.port, "port of the page, 0 for any free one")->capture_default_str();
  command
      .add_option("--" + prefix + "listen", page.listen,
                  text("address", prefix.empty() ? "" : " of the page", ", beyond this computer with --token"))
      ->capture_default_str();
  command.add_option("--token", page.token, "secret word in the page's address");
  command.add_flag("--open", page.open, "open the page in this computer's browser");
}

void check_page(const PageArguments& page) {
  if (page.port < 0 || page.port > 65535) throw InputError(text("--port is ", page.port, ", must be 0 .. 65535"));
  const auto is_plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_'; };
  if (!std::ranges::all_of(page.token, is_plain))
    throw InputError("--token: only letters, digits, - and _, as it is part of an address");
}

void tell_of_page(const PageArguments& page, const std::string& url) {
  std::cout << "open " << url << " in a browser; Ctrl-C ends it" << std::endl;
  if (page.open) open_browser(url);
}

}  // namespace kt
