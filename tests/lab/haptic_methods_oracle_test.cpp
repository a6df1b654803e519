// Each baseline against what its own idea says, by other means: recorded runs, statics, dense algebra.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_body.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

constexpr double kTop = 0.02;             // of meshes/block.msh [m]
const Vec3 kPlace(0.0412, 0.0263, kTop);  // on its surface, inside a triangle

/// A method over a body at rest that never hears of the contact: each refresh brings the same linear body.
class Bench {
 public:
  Bench(const std::string& method, double mu, const ProxyCoupling& coupling = {}) {
    HapticMethodOptions options;
    options.tools[0] = kPointTool;
    options.friction = {mu, mu};
    options.coupling = coupling;
    method_ = make_haptic_method(method, options);
  }
  /// The body linearized with the tool at `then`.
  void refresh(const Vec3& then) {
    auto model = body().local_model(kPlace);
    model->tool = then;
    method_->prepare_method_data(*model, 0.1);
    method_->adopt(std::move(model));
  }
  LocalFrame move(const Vec3& from, const Vec3& to, int ticks) {
    LocalFrame last;
    for (int i = 0; i < ticks; ++i)
      last = method_->step({from + i * (to - from) / ticks, from + (i + 1) * (to - from) / ticks});
    return last;
  }
  const PreparedLocalModel& prepared() const { return method_->model(); }
  const LocalModel& model() const { return method_->model().model; }
  const TickContact& sample() const { return method_->samples()[0]; }

 private:
  static const SoftBlock& body() {
    static const SoftBlock body;
    return body;
  }
  std::unique_ptr<HapticMethod> method_;
};

/// Rows of the basis at a contact, (3 x r).
MatrixX contact_rows(const LocalModel& m, const TickContact& s) {
  MatrixX J = MatrixX::Zero(3, m.basis.rows());
  const auto t = std::ranges::find(m.patch.global_triangle, s.triangle) - m.patch.global_triangle.begin();
  for (int c = 0; c < 3; ++c)
    J.block<3, 3>(0, 3 * m.patch.triangles[static_cast<std::size_t>(t)][c]) = s.bary[c] * Mat3::Identity();
  return J * m.basis;
}
Mat3 static_compliance(const LocalModel& m, const MatrixX& rows) {
  return rows * MatrixX(m.stiffness).ldlt().solve(MatrixX(rows.transpose()));
}

TEST(Hold, ShowsTheForceOfTheRefreshUntilTheNext) {
  for (double latency_ms : {0.0, 7.0}) {
    Scene scene = small_scene();
    scene.link.latency_ms = latency_ms;
    scene.local.blend_ms = 0;  // hold knows none of these
    scene.local.catch_up = false;
    scene.global.early_refresh = false;
    const SessionResult right = Session(scene).run();
    scene.local.method = "hold";
    const SessionResult held = Session(scene).run();
    ASSERT_EQ(held.tools[0].frames.size(), right.tools[0].frames.size());
    ASSERT_EQ(held.refreshes, right.refreshes);
    int different = 0;
    for (std::size_t k = 0; k < held.refreshes.size(); ++k) {
      const int then = held.refreshes[k].linearized_tick;
      const auto start_of = [&](std::size_t refresh) {  // what came after the end was not taken over
        const bool is_used = refresh < held.refreshes.size() && held.refreshes[refresh].adopted_tick >= 0;
        return is_used ? held.refreshes[refresh].adopted_tick : static_cast<int>(held.tools[0].frames.size());
      };
      const Vec3 expected = then == 0 ? Vec3(Vec3::Zero()) : right.tools[0].frames[then - 1].force;
      for (int i = start_of(k); i < start_of(k + 1); ++i) {
        ASSERT_EQ(held.tools[0].frames[i].force, expected) << "tick " << i;
        different += (right.tools[0].frames[i].force - expected).norm() > 0.01 * expected.norm();
      }
    }
    EXPECT_GT(different, 50) << "ticks at which holding is wrong";
  }
}

TEST(Frozen, StickingForceIsTheStaticStiffness) {
  Bench bench("frozen", 1000);
  const Vec3 start = kPlace + Vec3(0, 0, 0.0005), down = kPlace - Vec3(0, 0, 0.0008), aside(0.0003, -0.0002, 0);
  bench.refresh(start);
  EXPECT_EQ(bench.move(start, kPlace + Vec3(0, 0, 1e-6), 10).mode, ContactMode::free);
  bench.move(kPlace, down, 10);
  const LocalFrame frame = bench.move(down, down + aside, 7);
  ASSERT_EQ(frame.mode, ContactMode::stick);
  const Mat3 C = static_compliance(bench.model(), contact_rows(bench.model(), bench.sample()));
  const Vec3 expected = -C.inverse() * (down + aside - kPlace);
  EXPECT_LT((frame.force - expected).norm(), 1e-3 * expected.norm()) << frame.force.transpose();
  const LocalFrame later = bench.move(down + aside, down + aside, 500);
  EXPECT_LT((later.force - frame.force).norm(), 1e-9 * frame.force.norm()) << "no dynamics";
}

TEST(Frozen, NormalAndPlaceStayWhereTheRefreshFoundThem) {
  Bench bench("frozen", 0);
  const Vec3 down = kPlace - Vec3(0, 0, 0.0008), far(0.012, 0.004, 0);
  bench.refresh(kPlace);
  const LocalFrame before = bench.move(kPlace, down, 10);
  const int triangle = bench.sample().triangle;
  const MatrixX rows = contact_rows(bench.model(), bench.sample());
  const double C = static_compliance(bench.model(), rows)(2, 2);
  EXPECT_NEAR(before.force.z(), 0.0008 / C, 1e-6 / C * 0.0008);
  const LocalFrame after = bench.move(down, down + far, 100);  // triangles further on
  EXPECT_EQ(bench.sample().triangle, triangle);
  EXPECT_LT((after.force - before.force).norm(), 1e-9 * before.force.norm());
}

TEST(Frozen, ABodyThatFloatsIsHeldByItsInertia) {
  SoftBlockOptions options;
  options.clamped = -1;
  options.reducer = "full";
  const SoftBlock body(options);
  HapticMethodOptions o;
  o.tools[0] = kPointTool;
  o.friction = {0, 0};
  const auto method = make_haptic_method("frozen", o);
  auto model = body.local_model(kPlace);
  const double interval = 0.1;
  model->tool = kPlace;
  method->prepare_method_data(*model, interval);
  method->adopt(std::move(model));
  const Vec3 down = kPlace - Vec3(0, 0, 0.0005);
  const double force = method->step({kPlace, down}).force.z();
  double mass = 0;
  const SparseMatrix& M = method->model().model.mass;
  for (int i = 0; i < M.rows(); ++i) mass += M.coeff(i, i) / 3;
  const double as_a_whole = mass * 0.0005 / (interval * interval);  // near its middle, and a little softer than that
  EXPECT_GT(force, 0.5 * as_a_whole);
  EXPECT_LT(force, as_a_whole);
}

TEST(Legacy, FirstTickIsTheImplicitStepOfTheVertexPutOntoTheTool) {
  Bench bench("legacy", 1000);
  const Vec3 tool = kPlace - Vec3(0, 0, 0.001);
  bench.refresh(tool);
  const LocalModel& m = bench.model();
  int vertex = 0;
  for (int i = 0; i < m.patch.num_vertices(); ++i)
    if ((node(m.x0, i) - tool).norm() < (node(m.x0, vertex) - tool).norm()) vertex = i;
  const LocalFrame frame = bench.move(tool, tool, 1);
  ASSERT_EQ(frame.mode, ContactMode::stick);
  EXPECT_EQ(bench.sample().bary.maxCoeff(), 1);
  for (int c = 0; c < 3; ++c)
    if (bench.sample().bary[c] == 1) {
      const auto t = std::ranges::find(m.patch.global_triangle, bench.sample().triangle);
      EXPECT_EQ(m.patch.triangles[static_cast<std::size_t>(t - m.patch.global_triangle.begin())][c], vertex);
    }

  // The wall's coordinates are node displacements: the vertex is pushed down by the depth, all else as it was.
  const double h = 1e-3;
  const MatrixX J = contact_rows(m, bench.sample());
  const VectorX q = J.transpose() * Vec3(0, 0, -0.001);
  const MatrixX A = MatrixX(m.mass) + h * MatrixX(m.damping) + h * h * MatrixX(m.stiffness);
  const Eigen::LDLT<MatrixX> solve(A);
  const VectorX v_free = solve.solve(h * (m.f0 - m.stiffness * q));
  const Mat3 W = J * solve.solve(MatrixX(J.transpose()));
  const Vec3 expected = W.inverse() * (J * v_free) / h;  // holds the vertex still
  EXPECT_LT((frame.force - expected).norm(), 1e-9 * expected.norm()) << frame.force.transpose();

  // Neighbours give way in the ticks after; the next model forgets that.
  const LocalFrame settled = bench.move(tool, tool, 50);
  EXPECT_LT(settled.f_n, 0.9 * frame.f_n);
  const LocalFrame aside = bench.move(tool, tool + Vec3(0.0001, 0, -0.0002), 20);
  ASSERT_EQ(aside.mode, ContactMode::stick);
  const Vec3 moved = J * bench.prepared().state.q, expected_move(0.0001, 0, -0.0012);
  EXPECT_LT((moved - expected_move).norm(), 1e-9) << "the vertex goes with the tool";
  EXPECT_LT((bench.sample().point - node(m.x0, vertex) - moved).norm(), 1e-12);
  bench.refresh(tool);
  EXPECT_LT((bench.move(tool, tool, 1).force - frame.force).norm(), 1e-12);
}

TEST(Legacy, WayMadeWhileTheModelTravelledIsLost) {
  const Vec3 then = kPlace - Vec3(0, 0, 0.001), arrived = then - Vec3(0.0004, 0, 0.001);
  Bench in_time("legacy", 0.5), late("legacy", 0.5);
  in_time.refresh(then);
  late.refresh(then);
  const Vec3 on(0.0002, 0, -0.0003);
  const LocalFrame a = in_time.move(then, then + on, 5), b = late.move(arrived, arrived + on, 5);
  EXPECT_GT(a.f_n, 0);
  EXPECT_LT((a.force - b.force).norm(), 1e-9 * a.f_n) << "the same, although the tool is a millimetre deeper";
}

TEST(Legacy, FeelsNoContactThatTheRefreshDidNotSee) {
  Bench bench("legacy", 0.5);
  const Vec3 over = kPlace + Vec3(0, 0, 0.001), in = kPlace - Vec3(0, 0, 0.001);
  bench.refresh(over);
  EXPECT_TRUE(bench.move(over, in, 20).force.isZero(0));
  bench.refresh(in);
  EXPECT_GT(bench.move(in, in, 1).f_n, 0);
}

TEST(Penalty, StaticForceIsCouplingAndBodyInSeries) {
  const ProxyCoupling coupling{.stiffness = 150, .damping = 0.02};
  Bench bench("penalty", 0, coupling);
  const Vec3 start = kPlace + Vec3(0, 0, 0.0002), down = kPlace - Vec3(0, 0, 0.0005);
  bench.refresh(start);
  bench.move(start, down, 50);
  const LocalFrame frame = bench.move(down, down, 3000);
  ASSERT_EQ(frame.mode, ContactMode::slide);
  const LocalModel& m = bench.model();
  const TickContact& s = bench.sample();
  const MatrixX rows = contact_rows(m, s);
  // Balance of the body, and of the spring between the tool and the surface.
  const VectorX residual = m.stiffness * bench.prepared().state.q - m.f0 + rows.transpose() * frame.force;
  EXPECT_LT(residual.norm(), 1e-6 * frame.f_n);
  constexpr double kTilt = 2e-3;  // the depth is measured along the face's normal, the force is along the blended one
  EXPECT_NEAR(frame.f_n, coupling.stiffness * s.normal.dot(s.point - down), kTilt * frame.f_n);
  // Together: 1 / k = 1 / k_coupling + 1 / k_body; a little off, for the point that is touched moves with the dent.
  const double series = 0.0005 / (static_compliance(m, rows)(2, 2) + 1 / coupling.stiffness);
  EXPECT_NEAR(frame.f_n, series, 0.01 * series);
}

TEST(Penalty, TheBodyFeelsTheForceOneTickLater) {
  Bench bench("penalty", 0, {.stiffness = 100, .damping = 0});
  const Vec3 in = kPlace - Vec3(0, 0, 0.0005);
  bench.refresh(in);
  const LocalFrame first = bench.move(in, in, 1);
  EXPECT_NEAR(first.f_n, 100 * 0.0005, 1e-9);
  EXPECT_TRUE(bench.prepared().state.q.isZero(1e-15)) << "not yet";
  bench.move(in, in, 1);
  EXPECT_FALSE(bench.prepared().state.q.isZero(1e-9));
}

TEST(Penalty, StickingProxyPullsLikeItsSpringAndSlipsAtMu) {
  const double mu = 0.5;
  Bench bench("penalty", mu, {.stiffness = 100, .damping = 0});
  const Vec3 start = kPlace + Vec3(0, 0, 0.0002), down = kPlace - Vec3(0, 0, 0.0005);
  bench.refresh(start);
  bench.move(start, down, 50);
  const LocalFrame still = bench.move(down, down, 500), pulled = bench.move(down, down + Vec3(0.00005, 0, 0), 5);
  EXPECT_EQ(pulled.mode, ContactMode::stick);
  EXPECT_LT(pulled.force.x(), still.force.x() - 1e-4);
  const LocalFrame slid = bench.move(down, down + Vec3(0.004, 0, 0), 80);
  EXPECT_EQ(slid.mode, ContactMode::frictional_slide);
  EXPECT_NEAR(slid.f_t, mu * slid.f_n, 1e-6 * slid.f_n);
}

}  // namespace
}  // namespace kt
