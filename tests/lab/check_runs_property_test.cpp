// Bodies of public libraries on which contact once failed: the runs of a check, along the ways that it takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/base/parallel.hpp"
#include "lab/check/hand_paths.hpp"
#include "lab/check/mesh_work.hpp"
#include "lab/check/runs.hpp"
#include "tests/support/test_data.hpp"

namespace kt {
namespace {

/// Elements pressed at a place, counted from 1 as reports do.
SessionResult pressed(const std::string& mesh, std::size_t place) {
  MeshWork work;
  work.options.mesh = test_data() + "/meshes/" + mesh;
  work.options.body = "mesh";
  SessionResult out;
  with_threads(1, [&] {
    for (const CheckStage stage : {check_load, check_doctor, check_repair, check_solid, check_models}) {
      StageResult result;
      stage(work, result);
    }
    CheckBody& fem = *std::ranges::find(work.bodies, "fem", &CheckBody::model);
    out = run_along(fem, press_path(work.spots.at(place - 1)).path, nullptr);
  });
  return out;
}

class CheckPress : public testing::TestWithParam<std::pair<const char*, std::size_t>> {};

/// The sheet: what a new local model took over of the last one's motion threw it apart. The femur: in a hollow the
/// search for contacts went to and fro between places of a small triangle.
TEST_P(CheckPress, KeepsTheBodyTogetherAndTheToolOutside) {
  const auto& [mesh, place] = GetParam();
  if (!std::filesystem::exists(test_data() + "/meshes")) GTEST_SKIP() << "no meshes";
  if (!KT_WITH_CGAL || !KT_WITH_TETGEN) GTEST_SKIP() << "needs cgal and tetgen";
  const SessionResult run = pressed(mesh, place);
  double force = 0;
  for (const LocalFrame& f : run.tools[0].frames) force = std::max(force, f.force.norm());
  EXPECT_GT(force, 1e-3);
  EXPECT_LT(force, 10);
  EXPECT_EQ(run.tools[0].missed_impacts, 0);
  EXPECT_LT(*std::ranges::max_element(run.tools[0].penetration), 1e-7);
}

INSTANTIATE_TEST_SUITE_P(Meshes, CheckPress,
                         testing::Values(std::pair{"malformed_polygonfaces.obj", 5}, std::pair{"organ_femur.off", 4}),
                         [](const auto& test) {
                           const std::string mesh = test.param.first;
                           return mesh.substr(0, mesh.find('.'));
                         });

}  // namespace
}  // namespace kt
