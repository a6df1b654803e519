#include "view/page_texts.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/contact_surface/contact_surface.hpp"
#include "haptics/halves/live_settings.hpp"
#include "haptics/refresh/reducer_candidates.hpp"
#include "io/files/json_file.hpp"
#include "models/fem/material.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

Json tool_json(const ToolShape& shape) {
  constexpr const char* kNames[] = {"point", "sphere", "capsule", "mesh"};
  Json out = {{"shape", kNames[static_cast<int>(shape.kind)]}, {"radius", shape.radius}};
  for (const Vec3& c : shape.corners) out["corners"].push_back({c.x(), c.y(), c.z()});
  for (const Triangle& t : shape.triangles) out["triangles"].push_back({t[0], t[1], t[2]});
  return out;
}

std::vector<std::string> available(const std::vector<BackendInfo>& backends) {
  std::vector<std::string> out;
  for (const BackendInfo& b : backends)
    if (b.available) out.push_back(b.name);
  return out;
}

/// What is not known is null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

}  // namespace

std::string hello_text(const Session& session, double duration, const std::vector<std::string>& scenes,
                       bool by_pointer) {
  const Scene& scene = session.scene();
  Json out = {{"type", "hello"},
              {"mode", duration > 0 ? "session" : "live"},
              {"by_pointer", by_pointer},
              {"title", scene.title},
              {"duration", duration},
              {"h", 1 / scene.local.rate_hz},
              {"smooth", scene.contact.surface != "flat"},
              {"mu", {scene.contact.mu_static, scene.contact.mu_kinetic}},
              {"scene", Json::parse(to_json(scene))},
              {"schema", Json::parse(scene_schema())},
              {"scenes", scenes}};
  out["words"] = {{"local.reducer", available(reducer_names())},
                  {"object.model.type", available(model_backends())},
                  {"object.model.material", available(material_backends())},
                  {"contact.surface", available(contact_surface_backends())}};
  for (const ToolShape& shape : session.tools()) out["tools"].push_back(tool_json(shape));
  for (const LiveSetting& setting : live_settings()) out["live"].push_back(setting.key);
  return json_text(out);
}

std::string status_text(const LiveStatus& s, bool has_tool, int pages,
                        const std::vector<std::pair<std::string, std::string>>& settings) {
  Json out = {{"type", "status"},
              {"has_tool", has_tool},
              {"pages", pages},
              {"refreshes", s.touch.refreshes},
              {"refresh_hz", s.refresh_hz},
              {"wanted_hz", s.wanted_hz},
              {"refresh_ms", s.touch.refresh_ms},
              {"late_ticks", s.touch.late_ticks},
              {"dof", s.touch.dof},
              {"patch_vertices", s.touch.patch_vertices},
              {"fineness", number(s.touch.fineness)},
              {"force_factor", number(s.touch.force_factor)},
              {"reducer", s.touch.reducer},
              {"expected_force_error", number(s.touch.expected_force_error)},
              {"certified_error", number(s.touch.certified_error)},
              {"tick_p50_us", s.tick_p50_us},
              {"tick_p99_us", s.tick_p99_us},
              {"ticks", s.ticks},
              {"misses", s.misses},
              {"allocations", s.allocations},
              {"gate", s.gate},
              {"frame_us", s.frame_us},
              {"real_time", name_of(s.real_time.keeps)},
              {"real_time_told", s.told.empty() ? s.real_time.told() : s.told},
              {"paused", s.is_paused},
              {"recording", s.is_recording},
              {"recorded_s", number(s.recorded_s)},
              {"error", s.error}};
  out["settings"] = Json::object();
  for (const auto& [key, value] : settings) out["settings"][key] = value;
  return json_text(out);
}

std::string answer_text(const std::string& to, const std::string& what, const std::string& error) {
  return json_text(Json{{"type", "answer"}, {"to", to}, {"what", what}, {"error", error}});
}

}  // namespace kt
