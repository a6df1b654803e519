// The certificate against the whole body's complex dynamic stiffness, solved directly.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <numbers>
#include <utility>

#include "core/local/certificate.hpp"
#include "core/local/certified_rates.hpp"
#include "tests/support/linearized_block.hpp"

namespace kt {
namespace {

/// |Z - Z_body| / |Z_body| by complex LU factorizations alone.
double direct_error(const FreeBody& body, const LocalModel& m, int vertex, double hz) {
  using C = std::complex<double>;
  const double w = 2 * std::numbers::pi * hz;
  const auto dynamic = [&](const SparseMatrix& M, const SparseMatrix& D, const SparseMatrix& K) {
    return Eigen::MatrixXcd(MatrixX(K - w * w * M).cast<C>() + C(0, w) * MatrixX(D).cast<C>());
  };
  const int k = body.dofs.to_free[3 * m.patch.global_node[vertex]];
  Eigen::MatrixXcd unit = Eigen::MatrixXcd::Zero(body.dofs.size(), 3);
  unit.middleRows(k, 3).setIdentity();
  const Eigen::SparseMatrix<C> stiff = SparseMatrix(body.stiffness - w * w * body.mass).cast<C>(),
                               damped = body.damping.cast<C>();
  const Eigen::SparseLU<Eigen::SparseMatrix<C>> lu(stiff + C(0, w) * damped);
  const Eigen::MatrixXcd exact = lu.solve(unit).middleRows(k, 3);
  const MatrixX rows = MatrixX(m.basis).middleRows(3 * vertex, 3);
  const Eigen::MatrixXcd own =
      rows * dynamic(m.mass, m.damping, m.stiffness).partialPivLu().solve(rows.transpose().cast<C>().eval());
  return (own.inverse() - exact.inverse()).norm() / exact.inverse().norm();
}

struct Certified {
  explicit Certified(const std::string& reducer, const std::string& type = "fem")
      : block(6, type), body(block.tangent) {
    model = find_reducer(reducer)(block.tangent, block.patch(), block.site, {.rings = 2, .graded = &graded});
    if (reducer != "krylov") graded.update(block.tangent, block.patch());
    vertices = certified_vertices(model, block.site);
  }
  LinearizedBlock block;
  FreeBody body;
  GradedBody graded;
  LocalModel model;
  std::vector<int> vertices;
};

TEST(Certificate, InFullIsTheWorstDirectErrorOfEachFrequency) {
  for (const char* reducer : {"wall", "krylov"}) {
    const Certified c(reducer);
    const std::vector<double> hz{0, 30, 200};
    const Certificate found = BodyCertificate(c.body, c.model.patch, c.vertices, hz).certify(c.model);
    EXPECT_EQ(found.hz, hz);
    double worst = 0;
    for (std::size_t f = 0; f < hz.size(); ++f) {
      double expected = 0;
      for (int v : c.vertices) expected = std::max(expected, direct_error(c.body, c.model, v, hz[f]));
      EXPECT_NEAR(found.error[f], expected, 1e-5) << reducer << hz[f];
      worst = std::max(worst, found.error[f]);
    }
    EXPECT_EQ(found.worst, worst);
    EXPECT_GT(found.worst, reducer == std::string("wall") ? 0.1 : 1e-4);
  }
}

TEST(Certificate, AtRunTimeComesToTheDirectErrorWithEveryStep) {
  for (const char* reducer : {"wall", "krylov"}) {
    const Certified c(reducer);
    ASSERT_FALSE(c.graded.is_whole());
    for (double hz : kCertifiedHz) {
      const int v = c.vertices[1];
      const double exact = direct_error(c.body, c.model, v, hz);
      EXPECT_NEAR(estimate_error(c.graded, c.model, v, hz, 14), exact, 0.03 * exact) << reducer << hz;
      // What a refresh can afford: the size of the error, where it is an error that one could feel.
      EXPECT_NEAR(estimate_error(c.graded, c.model, v, hz), exact, 0.35 * exact + 0.002) << reducer << hz;
    }
  }
}

TEST(Certificate, AtSetUpComesFromAGoodModelNearTheDirectOne) {
  for (const char* type : {"fem", "msd"}) {
    Certified c("krylov", type);
    const LocalModel wall = find_reducer("wall")(c.block.tangent, c.block.patch(), c.block.site, {.rings = 2});
    const LocalModel best = find_reducer("krylov")(c.block.tangent, c.block.patch(), c.block.site,
                                                   {.shifts_hz = {0, 20, 40, 80, 160, 400}, .graded = &c.graded});
    const BodyCertificate estimated(c.graded, best, c.vertices), exact(c.body, c.model.patch, c.vertices);
    for (const LocalModel* model : {&std::as_const(c.model), &wall}) {
      const Certificate e = estimated.certify(*model), x = exact.certify(*model);
      for (std::size_t f = 0; f < e.hz.size(); ++f)
        EXPECT_NEAR(e.error[f], x.error[f], 0.006 * (1 + x.error[f]))
            << type << " " << model->reducer << " " << e.hz[f];
    }
  }
}

TEST(Certificate, DoesNotJudgeWhereTheBodyHasNoAnswer) {
  const Certified c("krylov", "msd");
  LocalModel loose = c.model;  // a motion that no spring holds
  loose.stiffness.coeffRef(0, 0) = 0;
  const Certificate found = BodyCertificate(c.graded, loose, c.vertices, std::vector<double>{0, 30}).certify(c.model);
  EXPECT_TRUE(std::isnan(found.error[0]));
  EXPECT_TRUE(std::isfinite(found.error[1]));
}

TEST(Certificate, OfAWholeBodysKrylovModelIsExactAtOnce) {
  const Certified c("krylov", "msd");
  GradedBody whole;
  whole.update_whole(c.block.tangent);
  const LocalModel m =
      find_reducer("krylov")(c.block.tangent, c.block.patch(), c.block.site, {.rank_tolerance = 1e-6, .grading = 0});
  const LocalModel wall = find_reducer("wall")(c.block.tangent, c.block.patch(), c.block.site, {.rings = 2});
  const double exact = direct_error(c.body, wall, c.vertices[0], 0);
  EXPECT_NEAR(estimate_error(whole, wall, c.vertices[0], 0, 1), exact, 1e-6 * exact);
  EXPECT_LT(direct_error(c.body, m, c.vertices[0], 0), 1e-6);
}

TEST(Certificate, LooksWhereTheToolCanBe) {
  const Certified c("wall");
  ASSERT_GE(c.vertices.size(), 3u);
  double nearest = 1;
  for (int v = 0; v < c.model.patch.num_vertices(); ++v)
    nearest = std::min(nearest, (node(c.model.x0, v) - c.block.site.centre).norm());
  EXPECT_EQ((node(c.model.x0, c.vertices[0]) - c.block.site.centre).norm(), nearest);
  for (int v : c.vertices)  // every triangle around it is in the patch
    EXPECT_EQ(c.model.patch.topology.triangles_of(v).size(),
              c.block.surface.topology.triangles_of(c.model.patch.global_node[v]).size());
}

TEST(Certificate, TakesTheFrequenciesInTurnAndKeepsTheLatest) {
  const Certified c("krylov");
  RunningCertificate running({0, 100});
  EXPECT_TRUE(std::isnan(running.sample(c.graded, c.model, c.block.site).error[1]));
  const Certificate second = running.sample(c.graded, c.model, c.block.site);
  EXPECT_EQ(second.error[0], estimate_error(c.graded, c.model, c.vertices[0], 0));
  EXPECT_EQ(second.error[1], estimate_error(c.graded, c.model, c.vertices[0], 100));
  EXPECT_EQ(second.worst, std::max(second.error[0], second.error[1]));
  EXPECT_EQ(running.sample(c.graded, c.model, c.block.site).error[0],
            estimate_error(c.graded, c.model, c.vertices[1], 0));
}

}  // namespace
}  // namespace kt
