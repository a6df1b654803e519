#pragma once
// The JSON texts that a page is sent.
#include <string>

#include "view/live_run.hpp"

namespace kt {

/// What a page has to be told first: the scene with its schema, the tools, which settings are live.
/// @param duration  of a session that is played [s]; 0: it runs
std::string hello_text(const Session& session, double duration, const std::vector<std::string>& scenes,
                       bool by_pointer);

/// @param has_tool  the page that is told may draw the tool
/// @param settings  live ones with their values
std::string status_text(const LiveStatus& status, bool has_tool, int pages,
                        const std::vector<std::pair<std::string, std::string>>& settings);

/// To a request of the page; `error` empty: it was done.
std::string answer_text(const std::string& to, const std::string& what, const std::string& error);

}  // namespace kt
