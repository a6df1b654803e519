// Tools dragged over whole closed surfaces: contact is never lost, nothing is hit twice, nobody gets in. The long
// version is bench/sliding_table.
#include <gtest/gtest.h>

#include "bench/sliding.hpp"

namespace kt {
namespace {

constexpr int kTicks = 1500;           // some ten edges, one or two vertices
constexpr double kPenetration = 1e-9;  // of the mesh's size
constexpr double kEdgesASecond = 6;

struct Drag {
  const char* mesh;
  double radius, depth;  // of the mean edge
  double mu;
};

SlidingBody body_of(const char* mesh) { return SlidingBody(load_mesh(KT_SOURCE_DIR "/meshes/" + std::string(mesh))); }

ToolShape tool_of(const SlidingBody& body, const Drag& drag) {
  return {drag.radius > 0 ? ToolShape::Kind::sphere : ToolShape::Kind::point, drag.radius * body.edge};
}

template <class Visit>
SlidingReport slide(const SlidingBody& body, const Drag& drag, Visit visit) {
  return slide(body, tool_of(body, drag), drag.mu, drag.depth * body.edge, kEdgesASecond * body.edge, kTicks, visit);
}

class Sliding : public testing::TestWithParam<Drag> {};
INSTANTIATE_TEST_SUITE_P(Tools, Sliding,
                         testing::Values(Drag{"torus.off", 0, 0.15, 0.3}, Drag{"torus.off", 0.5, 0.05, 1},
                                         Drag{"torus.off", 4, 0.08, 0}, Drag{"genus5.off", 0, 0.15, 0},
                                         Drag{"genus5.off", 0.5, 0.05, 0.3}, Drag{"genus5.off", 4, 0.08, 1}));

TEST_P(Sliding, KeepsItsContactHitsNothingTwiceAndStaysOutside) {
  const SlidingBody body = body_of(GetParam().mesh);
  const SlidingReport report = slide(body, GetParam(), [](const LocalFrame& frame) {
    ASSERT_TRUE(frame.force.allFinite());
    ASSERT_EQ(frame.flags, 0U);
  });
  EXPECT_EQ(report.lost, 0);
  EXPECT_EQ(report.double_hits, 0);
  EXPECT_EQ(report.exhausted, 0);
  EXPECT_LE(report.penetration, kPenetration);
  EXPECT_GT(report.crossings.size(), 3U);
}

TEST_P(Sliding, DoesNotDependOnHowTheSurfaceIsNumbered) {
  // Sums run in another order. Where rounding decides whether a tick's guess is good enough, one of both goes on with
  // it and the other improves it: they differ by what is good enough.
  constexpr double kSettled = 5e-7;  // [m], of the tick
  const Mesh mesh = load_mesh(KT_SOURCE_DIR "/meshes/" + std::string(GetParam().mesh));
  const SlidingBody body(mesh), other(renumbered(mesh, 5));
  const ToolShape tool = tool_of(body, GetParam());
  const double depth = GetParam().depth * body.edge;
  LocalSimulation a(tool, SlidingBody::kStep, make_contact_solver("coulomb", {GetParam().mu, GetParam().mu}));
  LocalSimulation b(tool, SlidingBody::kStep, make_contact_solver("coulomb", {GetParam().mu, GetParam().mu}));
  a.adopt(body.local_model("refit_bvh"));
  b.adopt(other.local_model("brute_force"));
  SurfaceWalk walk(body, tool, depth);
  Vec3 at = walk.tool() + 1.5 * depth * walk.normal();
  double largest = 0, mean = 0;
  for (int i = 0; i < 600; ++i) {
    const Vec3 next = i < 50 ? Vec3(at + 0.03 * depth * -walk.normal()) : walk.tool();
    const LocalFrame one = a.step({at, next}), two = b.step({at, next});
    ASSERT_EQ(one.contacts, two.contacts) << "tick " << i;
    largest = std::max(largest, (one.force - two.force).norm());
    mean += one.force.norm() / 600;
    at = next;
    if (i >= 50) walk.advance(kEdgesASecond * body.edge * SlidingBody::kStep);
  }
  EXPECT_GT(mean, 0);
  EXPECT_LE(largest, kSettled / depth * mean);
}

}  // namespace
}  // namespace kt
