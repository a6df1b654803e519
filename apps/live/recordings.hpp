#pragma once
// A page that records: DIR/001, DIR/002, ...
#include "apps/live/page_options.hpp"
#include "view/view.hpp"

namespace kt {

/// What `kilotouch view` and `touch --page` have in common. Throws InputError: a port or a token that cannot be.
/// @param device   of the option --device
/// @param folder   of the recordings, in which each has a new one
/// @param command  for their summaries
ViewOptions recorded_page(const PageArguments& page, const std::string& device, const std::string& folder,
                          const std::string& command);

}  // namespace kt
