#pragma once
// What a stage of the check says about a mesh.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/base/types.hpp"

namespace kt {

/// pass: as it should be. degraded: usable, but not as it came, or not as well as a clean mesh. fail: not usable, or
/// the engine erred. skipped: not tried, because an earlier stage left nothing to try it on.
enum class Verdict { pass, degraded, fail, skipped };

std::string name_of(Verdict verdict);
/// Throws InputError for a word that is none.
Verdict verdict_named(const std::string& name);

/// The worse of two; skipped is no worse than pass.
Verdict worse(Verdict a, Verdict b);

/// The reason of a stage whose memory did not suffice.
constexpr const char* kNoMemory = "memory: more is needed than is allowed";

struct StageResult {
  std::string name;
  Verdict verdict = Verdict::pass;
  std::string why;            ///< one line; of a pass: what is worth knowing, or empty
  std::optional<Vec3> where;  ///< in the file's own coordinates
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();  ///< equal for equal meshes and programs
  nlohmann::ordered_json times = nlohmann::ordered_json::object();    ///< what the machine's load changes

  /// Lowers the verdict; reasons add up.
  void lower(Verdict to, const std::string& reason, const std::optional<Vec3>& at = {});
};

nlohmann::ordered_json to_json(const StageResult& stage);

}  // namespace kt
