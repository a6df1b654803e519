#include "apps/outputs/view_json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "io/mesh/format/base64.hpp"

namespace kt {

using Json = nlohmann::ordered_json;

/// Positions as 16 bits in the box of all of them: x = low + step * value, little-endian, base64.
static Json film_json(const BodyFilm& film, const std::vector<int>& nodes, const VectorX& rest) {
  std::vector<int> row(static_cast<std::size_t>(rest.size() / 3), -1);
  for (std::size_t i = 0; i < film.nodes().size(); ++i) row[film.nodes()[i]] = static_cast<int>(i);
  std::vector<std::vector<float>> frames(1);  // the first: at rest
  for (const int i : film.nodes())
    for (int c = 0; c < 3; ++c) frames[0].push_back(static_cast<float>(node(rest, i)[c]));
  frames.insert(frames.end(), film.frames().begin(), film.frames().end());
  std::array<float, 3> low, high;
  low.fill(std::numeric_limits<float>::infinity());
  high.fill(-std::numeric_limits<float>::infinity());
  for (const std::vector<float>& x : frames)
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (!std::isfinite(x[k])) continue;
      low[k % 3] = std::min(low[k % 3], x[k]);
      high[k % 3] = std::max(high[k % 3], x[k]);
    }
  double extent = 0;
  for (std::size_t c = 0; c < 3; ++c) extent = std::max(extent, double{high[c]} - low[c]);
  const double step = std::max(extent, 1e-12) / 65535;
  const auto packed = [&](const std::vector<float>& x) {
    std::string bytes;
    for (const int i : nodes)
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = (double{x[3 * static_cast<std::size_t>(row[i]) + c]} - low[c]) / step;
        const auto v = static_cast<unsigned>(std::isfinite(value) ? std::lround(value) : 0);
        bytes += static_cast<char>(v & 255);
        bytes += static_cast<char>(v >> 8);
      }
    return to_base64(bytes);
  };
  Json x = Json::array();
  for (std::size_t i = 1; i < frames.size(); ++i) x.push_back(packed(frames[i]));
  return {{"interval", film.interval()}, {"low", low},        {"step", step},
          {"rest", packed(frames[0])},   {"t", film.times()}, {"x", x}};
}

Json view_json(const Session& session, const SessionResult& result, const BodyFilm* film) {
  const Mesh& mesh = session.model().mesh();
  std::vector<int> local(mesh.num_nodes(), -1), nodes;
  Json triangles = Json::array();
  for (const Triangle& t : mesh.triangles) {
    for (int i : t)
      if (local[i] < 0) {
        local[i] = static_cast<int>(nodes.size());
        nodes.push_back(i);
      }
    triangles.push_back({local[t[0]], local[t[1]], local[t[2]]});
  }
  const auto point = [](const Vec3& p) { return Json{p.x(), p.y(), p.z()}; };
  const auto points = [&](const VectorX& x) {
    Json out = Json::array();
    for (int i : nodes) out.push_back(point(node(x, i)));
    return out;
  };
  Json fixed = Json::array(), frames = Json::array(), path = Json::array();
  for (int i : still_nodes(session.model()))
    if (local[i] >= 0) fixed.push_back(local[i]);
  for (const Snapshot& s : result.snapshots) {
    frames.push_back({{"t", s.t}, {"tool", point(s.tools[0])}, {"x", points(s.x)}});
    if (s.tools.size() > 1) frames.back()["second_tool"] = point(s.tools[1]);
  }
  const std::size_t stride = std::max<std::size_t>(1, result.tools[0].frames.size() / 500);
  for (std::size_t i = 0; i < result.tools[0].frames.size(); i += stride)
    path.push_back(point(result.tools[0].frames[i].pose.x));
  const auto tool_json = [&](const SceneTool& tool, const ToolShape& shape) {
    Json corners = Json::array();
    for (const Vec3& corner : shape.corners) corners.push_back(point(corner));
    return Json{{"shape", tool.shape},          {"radius", shape.radius},   {"corners", corners},
                {"triangles", shape.triangles}, {"turn", point(tool.turn)}, {"spin", point(tool.spin)}};
  };
  Json out{{"tool", tool_json(session.scene().tool, session.tool())},
           {"frames", frames},
           {"rest", points(mesh.x)},
           {"triangles", triangles},
           {"fixed", fixed},
           {"path", path}};
  if (film && !film->times().empty() && !nodes.empty()) out["film"] = film_json(*film, nodes, mesh.x);
  if (result.tools.size() < 2) return out;
  out["second_tool"] = tool_json(*session.scene().second_tool, session.tools()[1]);
  Json second_path = Json::array();
  const std::span<const LocalFrame> second = result.tools[1].frames;
  for (std::size_t i = 0; i < second.size(); i += stride) second_path.push_back(point(second[i].pose.x));
  out["second_path"] = second_path;
  return out;
}

}  // namespace kt
