#pragma once
// The tables of a run: one row a tick, or one an event. They are written as they are made: a long run's text is never
// in memory at once.
#include <span>
#include <string>

#include "haptics/session/session.hpp"
#include "haptics/study/contact_events.hpp"
#include "haptics/study/indentation.hpp"

namespace kt {

/// trace.csv of one tool. @throws InputError: the file cannot be written
/// @param step_us  of each tick: that of all tools
void write_trace(const std::string& path, const ToolRun& run, std::span<const double> step_us,
                 const Indentation& indentation);
/// events.csv
void write_events(const std::string& path, std::span<const ContactEvent> events);
/// recording.csv: the start, then one line a tick: what the recorded device plays.
void write_recording(const std::string& path, const ToolRun& run);

}  // namespace kt
