#pragma once
// The check of one mesh, in a process of its own: `kilotouch check --one MESH --json FILE`.
#include "lab/check/mesh_work.hpp"

namespace kt {

/// The stages in their order, and what each needs of those before.
struct CheckStageEntry {
  const char* name;
  CheckStage run;
  bool needs_body;   ///< skipped without models
  bool needs_spots;  ///< skipped where the body can be touched nowhere
};
std::span<const CheckStageEntry> check_stages();

/// Writes the row to `json_file` after each stage, with the stage that is next as "running", so that a worker that is
/// killed has said where it was. The last time "running" is empty.
void check_one(const CheckOptions& options, const std::string& json_file);

}  // namespace kt
