// How much of a contact's yield is that of the refined cells: by hand for one triangle, and by the force that a body
// has without them.
#include <gtest/gtest.h>

#include <cmath>

#include "core/local/fine_patch.hpp"
#include "haptics/cost/refined_share.hpp"
#include "haptics/session/session.hpp"
#include "tests/support/lattice_scene.hpp"

namespace kt {
namespace {

SparseMatrix times_one(Eigen::Index n, double value) {
  SparseMatrix out(n, n);
  out.setIdentity();
  return value * out;
}

/// A triangle on three springs of `stiffness` each, all of it yielding by `compliance` more.
LocalModel on_springs(double stiffness, double compliance) {
  auto fine = std::make_shared<FinePatch>();
  fine->facets = {{0, 1, 2}};
  fine->triangle = {7};
  fine->corners = fine->to_facet = {Mat3::Identity()};
  fine->first = fine->first_from = {0, 1, 2, 3};
  fine->node = {4, 5, 6};
  fine->from = {0, 0, 0};
  fine->weight = fine->share = {1, 1, 1};
  fine->yielding = {{7, Vec3::Constant(1.0 / 3)}};
  fine->R = compliance * MatrixX::Identity(3, 3);
  LocalModel out;
  out.recovered_node = {4, 5, 6};
  out.basis = times_one(9, 1);
  out.stiffness = times_one(9, stiffness);
  out.mass = times_one(9, 0.02);
  out.fine = std::move(fine);
  return out;
}

TEST(RefinedShare, IsThatOfComplianceInSeries) {
  TickContact contact;
  contact.triangle = 7;
  contact.bary = Vec3(0.5, 0.25, 0.25);
  contact.impulse = Vec3(0.1, 0, -0.2);
  for (const double stiffness : {20.0, 0.0}) {                                   // nothing but inertia holds the body
    const double body = contact.bary.squaredNorm() / (stiffness + 0.02 / 0.01);  // f S f over f f
    EXPECT_NEAR(refined_share(on_springs(stiffness, 0.03), {&contact, 1}), 0.03 / (0.03 + body), 1e-12);
  }
  EXPECT_TRUE(std::isnan(refined_share(on_springs(20, 0.03), {})));
  contact.triangle = 3;
  EXPECT_TRUE(std::isnan(refined_share(on_springs(20, 0.03), {&contact, 1}))) << "beside the cells";
}

struct Pressed {
  double force = 0, share = 0;
};

/// A ball of 6 mm at rest, 1 mm deep in the middle of a block of cells of 7.5 mm that is clamped below.
Pressed press(const std::string& refine, int layers) {
  Scene s = scene_of_lattice();
  s.object.body = "mesh";
  s.local.refine = refine;
  s.tool.radius = 0.006;
  s.tool.path.press_drag = PressDrag{.at = std::array{0.0225, 0.0225}, .depth = 1e-3, .press_time = 0.1, .speed = 0};
  s.duration = 0.25;
  const SessionResult r = Session(s, kuhn_block(6, 6, layers, 0.0075)).run();
  return {r.tools[0].frames.back().f_n, r.refresh.refined_share.empty() ? 0 : r.refresh.refined_share.back()};
}

TEST(RefinedShare, IsWhatTheForceIsSmallerByWithTheCells) {
  for (const int layers : {1, 5}) {
    const Pressed with = press("follow", layers), without = press("off", layers);
    EXPECT_NEAR(with.share, 1 - with.force / without.force, 0.1) << layers;
  }
}

}  // namespace
}  // namespace kt
