#include "apps/page_options.hpp"

#include <algorithm>
#include <cctype>
#include <iostream>

#include "core/base/error.hpp"

namespace kt {

void add_page_options(CLI::App& command, PageArguments& page, const std::string& prefix) {
  command.add_option("--" + prefix + "port", page.port, "of the page; 0: any that is free")->capture_default_str();
  command
      .add_option(
          "--" + prefix + "listen", page.listen,
          text("address", prefix.empty() ? "" : " of the page", "; others than this computer's own need --token"))
      ->capture_default_str();
  command.add_option("--token", page.token, "that the page's address must have");
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
  if (page.open && std::system(("xdg-open '" + url + "' >/dev/null 2>&1 &").c_str()) != 0)
    std::cerr << "kilotouch: --open: no browser could be started\n";
}

}  // namespace kt
