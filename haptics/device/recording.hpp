#pragma once
// A recorded tool path as loggers and spreadsheets write it: text with a time and a place a row.
#include <string>
#include <vector>

#include "haptics/device/haptic_device.hpp"

namespace kt {

struct Recording {
  std::vector<TimedPoint> path;    ///< t counts from the first row [s]
  std::vector<TimedPose> poses;    ///< as many, where the rows have the tool's orientation; else empty
  std::vector<std::string> notes;  ///< what a user should know: gaps between rows, columns that are not read
};

/// Columns t, x, y, z [s], [m], and where they are there qw, qx, qy, qz: the turn from the tool's frame to the world's
/// as a unit quaternion. By name or, without names, the first four by place (loggers differ in the order of
/// the others); separated by commas, semicolons, tabs or blanks.
/// Blank lines and what follows a `#` do not count. Times may be those of a clock: their digits are kept.
/// @param h  tick [s]: rows farther apart are told
/// Throws InputError "file:line: ..." for a value that is no number, and for a time that does not follow the one
/// before.
Recording read_recording(const std::string& file, double h);

}  // namespace kt
