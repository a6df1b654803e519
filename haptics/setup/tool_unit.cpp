#include "haptics/setup/tool_unit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"

namespace kt {

const char* likely_tool_unit(double longest_in_file, double body) {
  constexpr std::pair<const char*, double> kUnits[] = {{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}};
  return std::ranges::min(
             kUnits, {},
             [&](const auto& unit) { return std::abs(std::log(longest_in_file * unit.second / (body / 3))); })
      .first;
}

Vec3 sides_of(const ToolShape& tool) {
  Vec3 low = Vec3::Zero(), high = low;
  for (std::size_t i = 0; i < tool.corners.size(); ++i) {
    low = i == 0 ? tool.corners[i] : low.cwiseMin(tool.corners[i]);
    high = i == 0 ? tool.corners[i] : high.cwiseMax(tool.corners[i]);
  }
  Vec3 out = (high - low).array() + 2 * tool.radius;
  std::ranges::sort(out);
  return out;
}

void require_tool_unit(const SceneTool& tool, const std::string& name, const Vec3& sides, double body) {
  constexpr double kMost = 20;  // times the body
  if (tool.shape != "mesh" || tool.scale || tool.size || !(sides[1] > kMost * body)) return;
  throw InputError(text(name, ".mesh: ", tool.mesh, " is ", short_number(1e3 * sides[1]), " mm wide, ",
                        short_number(sides[1] / body), " times the body of ", short_number(1e3 * body),
                        " mm, must be at most ", kMost, " times: set ", name, ".scale to ",
                        likely_tool_unit(sides[2], body), " (one unit of the file is taken as 1 m; ", name,
                        ".scale=1 where that is so)"));
}

}  // namespace kt
