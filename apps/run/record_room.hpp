#pragma once
// What a run writes down: whether there is room for it is asked before it begins.
#include <string>

#include "io/scene/scene.hpp"

namespace kt {

/// Bytes of each kind; of what is free: infinite where nothing says.
struct Room {
  double memory = 0;   ///< for the figures that are made of the ticks at the end
  double records = 0;  ///< on the disk of RecordBytes::folder(): one row a tick
  double results = 0;  ///< on the disk of the results: tables
};

/// What this process may still take: memory of the machine, its control group and its own limit, the least of them.
/// @param results  folder of the results; empty: none
Room free_room(const std::string& results);

/// What the run takes; nothing where it has no end.
/// @param keeps_results  a folder of results is written
Room needed_room(const Scene& scene, bool keeps_results);

/// Throws InputError when the run takes more than there is, and warns on stderr when it takes over half of it.
void require_room(const Scene& scene, const Room& needed, const Room& free);

}  // namespace kt
