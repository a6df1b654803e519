#pragma once
// The tables of a run: one row a tick, or one an event. They are written as they are made: a long run's text is never
// in memory at once.
#include <span>
#include <string>

#include "haptics/session/contact_events.hpp"
#include "haptics/session/indentation.hpp"
#include "haptics/session/session.hpp"
#include "io/files/result_files.hpp"

namespace kt {

/// trace.csv of one tool. @throws InputError: the file cannot be written
/// @param step_us  of each tick: that of all tools
void write_trace(ResultFiles& files, const std::string& name, const ToolRun& run, std::span<const double> step_us,
                 const Indentation& indentation);
/// events.csv
void write_events(ResultFiles& files, const std::string& name, std::span<const ContactEvent> events);
/// recording.csv: the start, then one line a tick: what the recorded device plays.
void write_recording(ResultFiles& files, const std::string& name, const ToolRun& run);

}  // namespace kt
