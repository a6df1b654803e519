// Linearize, cut out a patch, reduce, step: each against the dense matrices of the whole body.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numeric>
#include <set>

#include "core/local/local_dynamics.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/linearized_block.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;  // relative, well-conditioned step matrices
TEST(Linearize, HoldsTheModelsForceMatricesAndFixedNodes) {
  const LinearizedBlock b;
  VectorX f;
  b.model->force(b.tangent.state, f);
  const TangentModel exact = linearize(*b.model, b.tangent.state);
  EXPECT_EQ(exact.f0, f);
  const Tangent t = b.model->tangent(b.tangent.state, TangentKind::exact);
  EXPECT_EQ(MatrixX(exact.dfdx), MatrixX(t.dfdx));
  EXPECT_EQ(MatrixX(exact.dfdv), MatrixX(t.dfdv));
  EXPECT_EQ(MatrixX(exact.mass), MatrixX(b.model->mass()));
  EXPECT_EQ(exact.fixed_nodes, b.model->fixed_nodes());
}

TEST(Linearize, PredictsTheForceOfANearbyStateToSecondOrder) {
  const LinearizedBlock b;
  const TangentModel t = linearize(*b.model, b.tangent.state);
  const VectorX dx = random_vector(t.f0.size(), 8), dv = random_vector(t.f0.size(), 9);
  const auto miss = [&](double size) {
    VectorX f;
    b.model->force({0, t.state.x + size * b.edge * dx, t.state.v + size * dv}, f);
    return (f - (t.f0 + t.dfdx * (size * b.edge * dx) + t.dfdv * (size * dv))).norm();
  };
  EXPECT_NEAR(std::log2(miss(2e-3) / miss(1e-3)), 2, 0.05);
}

TEST(Patch, HoldsEveryTriangleInReachAndOneRingMore) {
  const LinearizedBlock b(5);
  const VectorX& x = b.tangent.state.x;
  for (double reach : {0.0, 0.8 * b.edge, 1.7 * b.edge, 1.0}) {
    const ContactSite site{b.site.centre, b.site.triangle, reach};
    const SurfacePatch patch = make_patch(b.surface, x, site);
    const std::set<int> in(patch.global_triangle.begin(), patch.global_triangle.end());
    EXPECT_TRUE(std::is_sorted(patch.global_triangle.begin(), patch.global_triangle.end()));
    EXPECT_EQ(in.size(), patch.global_triangle.size());
    std::set<int> near{site.triangle};
    for (int t = 0; t < static_cast<int>(b.surface.triangles.size()); ++t)
      for (double u = 0; u <= 1; u += 0.05)  // sampled, so it can only miss triangles
        for (double w = 0; u + w <= 1; w += 0.05) {
          const Triangle& g = b.surface.triangles[t];
          const Vec3 p = (1 - u - w) * node(x, g[0]) + u * node(x, g[1]) + w * node(x, g[2]);
          if ((p - site.centre).norm() <= reach) near.insert(t);
        }
    for (int t : near)
      for (int v : b.surface.triangles[t])
        for (int ring : b.surface.topology.triangles_of(v)) EXPECT_TRUE(in.count(ring)) << reach;
    for (std::size_t t = 0; t < patch.triangles.size(); ++t) {
      bool rim = false;
      for (int c = 0; c < 3; ++c) {
        const int global = patch.global_node[patch.triangles[t][c]];
        EXPECT_EQ(global, b.surface.triangles[patch.global_triangle[t]][c]);
        for (int other : b.surface.topology.triangles_of(global)) rim |= !in.count(other);
      }
      EXPECT_EQ(patch.on_rim[t] != 0, rim);
    }
    EXPECT_TRUE(reach < 1 || in.size() == b.surface.triangles.size());
  }
}

/// The global dofs that coordinate k of the model displaces, by one: these reducers keep nodes as they are.
std::vector<int> kept_dofs(const LocalModel& m) {
  std::vector<int> dofs(m.dof(), -1);
  for (int c = 0; c < m.basis.outerSize(); ++c)
    for (SparseMatrix::InnerIterator it(m.basis, c); it; ++it) {
      EXPECT_EQ(it.value(), 1);
      dofs[c] = 3 * m.recovered_node[it.row() / 3] + static_cast<int>(it.row() % 3);
    }
  return dofs;
}

void expect_restriction(const LinearizedBlock& b, const LocalModel& m) {
  const std::vector<int> dofs = kept_dofs(m);
  EXPECT_EQ(MatrixX(m.mass), MatrixX(b.tangent.mass)(dofs, dofs));
  EXPECT_EQ(MatrixX(m.stiffness), -MatrixX(b.tangent.dfdx)(dofs, dofs));
  EXPECT_EQ(MatrixX(m.damping), -MatrixX(b.tangent.dfdv)(dofs, dofs));
  EXPECT_EQ(m.q_rate0, VectorX(b.tangent.state.v(dofs)));
  // The force when the kept nodes stand still too: what moves brings its own damping.
  const VectorX still = b.tangent.f0 - b.tangent.dfdv * b.tangent.state.v;
  EXPECT_LE(relative_error(m.f0, still(dofs)), kRoundoff);
  EXPECT_EQ(m.t, b.tangent.state.t);
}

TEST(Wall, IsTheRestrictionOfTheFullMatricesToPatchAndRings) {
  const LinearizedBlock b(5);
  std::set<int> patch_nodes, fixed(b.tangent.fixed_nodes.begin(), b.tangent.fixed_nodes.end());
  for (int i : make_patch(b.surface, b.tangent.state.x, b.site).global_node) patch_nodes.insert(i);
  int nearest = *patch_nodes.begin();
  for (int i : patch_nodes)
    if ((node(b.tangent.state.x, i) - b.site.centre).norm() < (node(b.tangent.state.x, nearest) - b.site.centre).norm())
      nearest = i;
  std::set<int> reached{nearest};
  for (int rings : {0, 1, 2, 9}) {
    reached = {nearest};
    for (int ring = 0; ring < rings; ++ring) {
      std::set<int> next = reached;
      for (const Tetrahedron& t : b.mesh.tetrahedra)
        if (std::any_of(t.begin(), t.end(), [&](int i) { return reached.count(i) > 0; }))
          next.insert(t.begin(), t.end());
      reached = next;
    }
    std::set<int> expected = reached;
    expected.insert(patch_nodes.begin(), patch_nodes.end());
    for (int i : fixed) expected.erase(i);
    const LocalModel m = b.reduce("wall", {.rings = rings});
    std::set<int> found;
    for (int d : kept_dofs(m)) found.insert(d / 3);
    EXPECT_EQ(found, expected) << rings;
    EXPECT_EQ(m.reducer, "wall");
    expect_restriction(b, m);
  }
}

TEST(Full, KeepsEveryFreeNode) {
  const LinearizedBlock b;
  const LocalModel m = b.reduce("full");
  EXPECT_EQ(m.dof(), 3 * (b.mesh.num_nodes() - static_cast<int>(b.tangent.fixed_nodes.size())));
  EXPECT_EQ(m.reducer, "full");
  expect_restriction(b, m);
}

TEST(Full, StepsAsTheWholeLinearizedBodyDoes) {
  const LinearizedBlock b;
  const double h = 1e-3;
  const LocalModel m = b.reduce("full");
  const LocalDynamics dynamics(m, LocalScheme::implicit_euler, Metric::implicit, h);
  const std::vector<int> dofs = kept_dofs(m);
  // Brute force on all 3n dofs: fixed ones get rows and columns of the identity.
  MatrixX A = MatrixX(b.tangent.mass - h * b.tangent.dfdv - h * h * b.tangent.dfdx);
  for (int i : b.tangent.fixed_nodes)
    for (int d = 3 * i; d < 3 * i + 3; ++d) {
      A.row(d).setZero();
      A.col(d).setZero();
      A(d, d) = 1;
    }
  const Eigen::LLT<MatrixX> llt(A);
  VectorX q = VectorX::Zero(m.dof()), rate = m.q_rate0, out(m.dof()), end(m.dof());
  VectorX x = b.tangent.state.x, v = b.tangent.state.v;
  for (int step = 0; step < 20; ++step) {
    dynamics.free_motion(q, rate, out, end);
    rate = out;
    q += h * rate;
    // M (v+ - v) = h (f0 + dfdx (x + h v+ - x0) + dfdv (v+ - v0))
    const VectorX f = b.tangent.f0 + b.tangent.dfdx * (x - b.tangent.state.x) - b.tangent.dfdv * b.tangent.state.v;
    VectorX rhs = b.tangent.mass * v + h * f;
    for (int i : b.tangent.fixed_nodes) node(rhs, i).setZero();
    v = llt.solve(rhs);
    x += h * v;
  }
  EXPECT_LE(relative_error(rate, v(dofs)), 10 * kRoundoff);
  EXPECT_LE(relative_error(q, VectorX(x(dofs)) - VectorX(b.tangent.state.x(dofs))), 10 * kRoundoff);
}

struct DynamicsCase {
  std::string reducer;
  int cells;  // 3: dense inverse, 5: sparse factors
};

TEST(LocalDynamics, IsDenseAlgebraForBothSchemesAllMetricsAndBothSolverPaths) {
  for (const DynamicsCase& c : {DynamicsCase{"wall", 3}, DynamicsCase{"full", 3}, DynamicsCase{"full", 5}}) {
    const LinearizedBlock b(c.cells);
    const LocalModel m = b.reduce(c.reducer);
    ASSERT_EQ(m.dof() > 450, c.cells == 5);  // beyond the dense limit
    const double h = 1e-3;
    const MatrixX M = m.mass, D = m.damping, K = m.stiffness, implicit = M + h * D + h * h * K;
    const MatrixX B = MatrixX(m.basis).topRows(3 * m.patch.num_vertices());
    const VectorX q = 1e-4 * random_vector(m.dof(), 1), rate = 0.1 * random_vector(m.dof(), 2);
    for (LocalScheme scheme : {LocalScheme::symplectic_euler, LocalScheme::implicit_euler})
      for (Metric metric : {Metric::identity, Metric::mass, Metric::implicit}) {
        const bool is_implicit = scheme == LocalScheme::implicit_euler;
        const LocalDynamics dynamics(m, scheme, metric, h);
        const Eigen::LLT<MatrixX> A(is_implicit ? implicit : M);
        const MatrixX Y = A.solve(MatrixX(B.transpose()));
        EXPECT_LE(relative_error(dynamics.inertia().Y, Y), kRoundoff);
        EXPECT_LE(relative_error(dynamics.inertia().C, B * Y), kRoundoff);
        const MatrixX inner = metric == Metric::identity ? MatrixX::Identity(m.dof(), m.dof())
                              : metric == Metric::mass   ? M
                                                         : implicit;
        const MatrixX Y_metric = Eigen::LLT<MatrixX>(inner).solve(MatrixX(B.transpose()));
        EXPECT_LE(relative_error(dynamics.metric().Y, Y_metric), kRoundoff);
        EXPECT_LE(relative_error(dynamics.metric().C, B * Y_metric), kRoundoff);

        const VectorX force = m.f0 - K * q - D * rate;
        const VectorX free =
            is_implicit ? VectorX(A.solve(M * rate + h * (m.f0 - K * q))) : VectorX(rate + h * A.solve(force));
        VectorX found(m.dof()), end(m.dof());
        EXPECT_EQ(allocations_during([&] { dynamics.force(q, rate, found); }), 0);
        EXPECT_LE(relative_error(found, force), kRoundoff);
        EXPECT_EQ(allocations_during([&] { dynamics.free_motion(q, rate, found, end); }), 0);
        EXPECT_EQ(end, found);
        EXPECT_LE(relative_error(found, free), kRoundoff) << c.reducer << c.cells;
        EXPECT_EQ(dynamics.h(), h);
      }
  }
}

/// One patch vertex whose motion is the sum of vibrations of many kinds: stiff, soft, free, light and heavy damping.
LocalModel vibrations(const VectorX& mass, const VectorX& damping, const VectorX& stiffness) {
  LocalModel m;
  const int r = static_cast<int>(mass.size());
  m.patch.global_node = {0};
  m.mass = SparseMatrix(mass.asDiagonal());
  m.damping = SparseMatrix(damping.asDiagonal());
  m.stiffness = SparseMatrix(stiffness.asDiagonal());
  m.f0 = random_vector(r, 3);
  MatrixX basis(3, r);
  for (int c = 0; c < r; ++c) basis.col(c) = random_vector(3, static_cast<unsigned>(10 + c));
  m.basis = basis.sparseView();
  return m;
}

TEST(LocalDynamics, ExactStepsAreThoseOfManySmallOnes) {
  const double h = 1e-3;
  const VectorX mass{{1, 0.5, 1, 2, 1, 1}}, damping{{0, 3, 4000, 10, 0, 200}}, stiffness{{1e4, 0, 2e6, 9e5, 4e6, 1e4}};
  const LocalModel m = vibrations(mass, damping, stiffness);
  const LocalDynamics dynamics(m, LocalScheme::exact, Metric::implicit, h);
  const VectorX q0 = 1e-3 * random_vector(6, 1), v0 = 0.1 * random_vector(6, 2);
  const auto fine = [&](const VectorX& force) {  // classical Runge-Kutta of order 4
    VectorX q = q0, v = v0;
    const int steps = 2000;
    const double dt = h / steps;
    const auto a = [&](const VectorX& x, const VectorX& u) {
      return VectorX((force - stiffness.cwiseProduct(x) - damping.cwiseProduct(u)).cwiseQuotient(mass));
    };
    for (int i = 0; i < steps; ++i) {
      const VectorX q1 = v, v1 = a(q, v), q2 = v + dt / 2 * v1, v2 = a(q + dt / 2 * q1, v + dt / 2 * v1);
      const VectorX q3 = v + dt / 2 * v2, v3 = a(q + dt / 2 * q2, v + dt / 2 * v2);
      const VectorX q4 = v + dt * v3, v4 = a(q + dt * q3, v + dt * v3);
      q += dt / 6 * (q1 + 2 * q2 + 2 * q3 + q4);
      v += dt / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    }
    return std::pair(q, v);
  };
  VectorX mean(6), end(6);
  EXPECT_EQ(allocations_during([&] { dynamics.free_motion(q0, v0, mean, end); }), 0);
  const auto [q, v] = fine(m.f0);
  EXPECT_LE(relative_error(q0 + h * mean, q), 1e-9);
  EXPECT_LE(relative_error(end, v), 1e-9);
  // A contact impulse acts as a force over the step.
  const Vec3 impulse(1e-3, -2e-3, 3e-3);
  const auto [q_pushed, v_pushed] = fine(m.f0 + MatrixX(m.basis).transpose() * impulse / h);
  EXPECT_LE(relative_error(q0 + h * (mean + dynamics.metric().Y * impulse), q_pushed), 1e-9);
  EXPECT_LE(relative_error(end + dynamics.end_response() * impulse, v_pushed), 1e-9);
  EXPECT_LE(relative_error(dynamics.metric().C, MatrixX(m.basis) * dynamics.metric().Y), kRoundoff);
}

TEST(LocalDynamics, UncoupledEulerStepsAreThoseOfTheMatrices) {
  const double h = 1e-3;
  const VectorX mass{{1, 0.5, 1}}, damping{{0, 3, 40}}, stiffness{{1e4, 0, 2e6}};
  const LocalModel m = vibrations(mass, damping, stiffness);
  const VectorX q = 1e-3 * random_vector(3, 1), v = 0.1 * random_vector(3, 2);
  for (LocalScheme scheme : {LocalScheme::symplectic_euler, LocalScheme::implicit_euler}) {
    const bool is_implicit = scheme == LocalScheme::implicit_euler;
    const LocalDynamics dynamics(m, scheme, is_implicit ? Metric::implicit : Metric::mass, h);
    const VectorX A = is_implicit ? VectorX(mass + h * damping + h * h * stiffness) : mass;
    const VectorX f = m.f0 - stiffness.cwiseProduct(q);
    const VectorX expected = is_implicit ? VectorX((mass.cwiseProduct(v) + h * f).cwiseQuotient(A))
                                         : VectorX(v + h * (f - damping.cwiseProduct(v)).cwiseQuotient(A));
    VectorX mean(3), end(3);
    dynamics.free_motion(q, v, mean, end);
    EXPECT_LE(relative_error(mean, expected), kRoundoff);
    EXPECT_EQ(end, mean);
    EXPECT_LE(relative_error(dynamics.metric().Y, A.cwiseInverse().asDiagonal() * MatrixX(m.basis).transpose()),
              kRoundoff);
  }
}

TEST(LocalDynamics, RefusesExactStepsOfCoupledCoordinates) {
  EXPECT_THROW(LocalDynamics(LinearizedBlock().reduce("wall"), LocalScheme::exact, Metric::implicit, 1e-3), InputError);
}

TEST(LocalDynamics, RefusesAMassThatIsNotPositiveDefinite) {
  LocalModel m = LinearizedBlock().reduce("wall");
  m.mass.coeffRef(4, 4) = -1;
  m.mass.coeffRef(4, 5) = m.mass.coeffRef(5, 4) = 0.5;
  EXPECT_THROW(LocalDynamics(m, LocalScheme::symplectic_euler, Metric::mass, 1e-3), RunError);
}

}  // namespace
}  // namespace kt
