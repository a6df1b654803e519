#pragma once
// A run whose body is on another computer, or is to be felt as if it were.
#include <memory>
#include <optional>
#include <string>

#include "apps/run/run_session.hpp"

namespace kt {

struct HandLinkReport;

/// The summary's `link`, and warnings of a link that was lost; filled in when the run is over.
void tell_of_link(RunSettings& settings, std::shared_ptr<HandLinkReport> report);
/// "12 %", or that it is not known.
std::string loss_text(const std::optional<double>& loss);
/// Its line on the first screen.
void print_link(const HandLinkReport& report);

/// link.type network in a scene that is run alone: the body's computer is in this process, with the scene's latency and
/// loss between the two. Other links are left as they are.
/// @throws InputError: the program was built without it
void put_body_beside(const Scene& scene, RunSettings& settings);

}  // namespace kt
