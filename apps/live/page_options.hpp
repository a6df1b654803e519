#pragma once
// The options of commands that show a page.
#include <CLI/CLI.hpp>
#include <string>

namespace kt {

struct PageArguments {
  std::string listen = "127.0.0.1", token;
  int port = 8080;
  bool open = false;
};

/// --port, --listen, --token, --open, or with a prefix --page-port ...
void add_page_options(CLI::App& command, PageArguments& page, const std::string& prefix = "");

/// @throws InputError: a port or a token that cannot be
void check_page(const PageArguments& page);

/// Tells where the page is, and opens it when that was asked for.
void tell_of_page(const PageArguments& page, const std::string& url);

}  // namespace kt
