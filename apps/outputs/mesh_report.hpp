#pragma once
// A mesh report as text for people and as JSON for programs.
#include <nlohmann/json.hpp>
#include <string>

#include "io/surface/mesh_doctor.hpp"
#include "io/surface/mesh_repair.hpp"

namespace kt {

/// Aligned lines: size, counts, then each defect with its number and first `shown` places.
std::string report_text(const Mesh& mesh, const MeshReport& report, int shown);

/// Everything, all places. NaN coordinates become null.
nlohmann::json report_json(const Mesh& mesh, const MeshReport& report);

nlohmann::json wrap_json(const WrapResult& wrap);

}  // namespace kt
