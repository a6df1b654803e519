// Mesh tools as a drawing program exports them: each refresh and each tick looks at all of their triangles.
#include "core/base/error.hpp"
#include "haptics/cells/mesh_cures.hpp"
#include "haptics/predict/predict.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {

void predict_tool_mesh(const BuiltScene& built, std::vector<Prediction>& out) {
  for (std::size_t k = 0; k < built.tools().size(); ++k) {
    const ToolShape& shape = built.tools()[k];
    const SceneTool& tool = k == 0 ? built.scene().tool : *built.scene().second_tool;
    if (shape.kind != ToolShape::Kind::mesh || shape.triangles.size() < kManyToolTriangles) continue;
    const std::string name = k == 0 ? "tool" : "second_tool";
    out.push_back(
        {"tool_mesh", Finding{told(name, ".mesh: ", tool.mesh, " has ", shape.triangles.size(),
                                   " triangles, all of which each refresh looks at: expect refreshes of seconds"),
                              {fewer_tool_triangles(name, shape.triangles.size())},
                              Finding::Weight::note}
                          .at(name + ".mesh", static_cast<double>(shape.triangles.size()))});
  }
}

}  // namespace kt
