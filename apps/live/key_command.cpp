// kilotouch key new DIR: the keys of a computer, for kilotouch serve and kilotouch touch.
#include <iostream>

#include "apps/console/commands.hpp"
#include "core/base/error.hpp"

#if KT_WITH_NETWORK
#include "network/control/curve_keys.hpp"
#endif

namespace kt {
namespace {

#if KT_WITH_NETWORK

void make_keys(const std::string& dir) {
  make_key(dir);
  std::cout << "public key   " << read_key(dir).public_key << "\n  " << dir << "/public.key may be given to others; "
            << dir << "/secret.key stays on this computer\n";
}

#else

void make_keys(const std::string&) {
  throw InputError("key: this program was built without it; configure with -DKT_WITH_NETWORK=ON");
}

#endif

}  // namespace

void add_key_command(CLI::App& app, int&) {
  auto* command = app.add_subcommand("key", "keys of this computer, for serve and touch beyond it");
  command->require_subcommand(1);
  auto* make = command->add_subcommand("new", "a new pair of keys, in files of their own");
  auto dir = std::make_shared<std::string>();
  make->add_option("DIR", *dir, "folder for public.key and secret.key")->required();
  make->footer("Example:\n  kilotouch key new keys/hand");
  make->callback([dir] { make_keys(*dir); });
}

}  // namespace kt
