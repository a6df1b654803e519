// The nodes that a reported contact moves, against the contact surface of the local model that reported it.
#include "core/body/node_weights.hpp"
#include "haptics/refresh/contact_nodes.hpp"

#include <gtest/gtest.h>

#include "haptics/tick/local_report.hpp"
#include "tests/support/haptics_body.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

const std::vector<Smoothing> kSurfaces{{"flat", 0}, {"loop", 2}};

struct Reported : testing::TestWithParam<Smoothing> {
  SoftBlock body{{.reach = 0.006}};
  std::unique_ptr<PreparedLocalModel> model_at(const Vec3& p, int frame) const {
    LocalModel local = std::move(body.local_model(rest_state(*body.model), p, frame)->model);
    return prepare(std::move(local), body.options.scheme, body.options.metric, body.options.h, "brute_force",
                   body.model->mesh().num_nodes(), static_cast<int>(body.surface.triangles.size()), GetParam());
  }
};

TEST_P(Reported, ContactsMoveTheNodesOfTheModelThatReportedThem) {
  const VectorX& rest = body.model->mesh().x;
  const Bounds box = bounds(body.model->mesh());
  ContactNodes nodes(body.surface);
  std::vector<std::unique_ptr<PreparedLocalModel>> models;
  for (int frame = 3; frame < 6; ++frame) {
    models.push_back(model_at(box.min + 0.2 * frame * (box.max - box.min), frame));
    nodes.keep(*models.back());
  }
  ASSERT_NE(models[0]->model.patch.global_node, models[2]->model.patch.global_node);
  Sample random;
  VectorX moved = rest;  // any motion of the body
  for (int i = 0; i < body.model->mesh().num_nodes(); ++i) node(moved, i) += 0.002 * random.cube();
  for (const auto& model : models) {
    const ContactSurface& s = model->surface;
    const SurfacePatch& patch = model->model.patch;
    VectorX patch_x(3 * patch.num_vertices()), facet_x(3 * s.facets.num_vertices());
    for (int i = 0; i < patch.num_vertices(); ++i) node(patch_x, i) = node(moved, patch.global_node[i]);
    s.follow(patch_x, facet_x);
    for (int f = 0; f < static_cast<int>(s.facets.triangles.size()); ++f) {
      Vec3 bary = random.cube().cwiseAbs();
      bary /= bary.sum();
      const TickContact contact{.triangle = s.facets.global_triangle[f], .facet = f, .bary = bary};
      const NodeWeights found = nodes.moved_by(model->model.frame, contact);
      Vec3 there = Vec3::Zero();
      for (int c = 0; c < 3; ++c) there += bary[c] * node(facet_x, s.facets.triangles[f][c]);
      ASSERT_LT((found.of(moved) - there).norm(), 1e-15) << "facet " << f;
      const NodeWeights own = s.moved_by(patch, f, bary);  // to the bit
      ASSERT_EQ(std::vector(found.node.begin(), found.node.begin() + found.count),
                std::vector(own.node.begin(), own.node.begin() + own.count));
      ASSERT_EQ(std::vector(found.weight.begin(), found.weight.begin() + found.count),
                std::vector(own.weight.begin(), own.weight.begin() + own.count));
      const TickContact placed = nodes.on_triangle(model->model.frame, contact);
      ASSERT_EQ(placed.bary, s.weights_in_triangle(f, bary));
      ASSERT_EQ(placed.facet, -1);
    }
  }
}

TEST_P(Reported, ContactsOnATriangleNeedNoModel) {
  ContactNodes nodes(body.surface);
  const TickContact contact{.triangle = 5, .bary = {0.5, 0.2, 0.3}};
  const NodeWeights found = nodes.moved_by(0, contact);
  ASSERT_EQ(found.count, 3);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(found.node[c], body.surface.triangles[5][c]);
    EXPECT_EQ(found.weight[c], contact.bary[c]);
  }
  EXPECT_EQ(nodes.on_triangle(0, contact).bary, contact.bary);
}

INSTANTIATE_TEST_SUITE_P(Surfaces, Reported, testing::ValuesIn(kSurfaces),
                         [](const auto& surface) { return surface.param.scheme; });

/// Each tick of the thread link copies one, and its queue has room for 4096.
TEST(LocalReport, IsSmall) {
  EXPECT_LE(sizeof(TickContact), 136u);
  EXPECT_LE(sizeof(LocalReport), 5600u);
}

}  // namespace
}  // namespace kt
