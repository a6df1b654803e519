// The fine patch in series with coarse cells: affine fields, the coarse body's own tangent, dense inverses, and presses
// on a bonded layer against rings.
#include "core/fine/fine_yield.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <set>

#include "core/body/wrapping_model.hpp"
#include "core/fine/isotropic_cells.hpp"
#include "tests/support/fine_press.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

constexpr double kYoung = 1e4;

/// Cells of 10 mm with nodes moved out of line, clamped below.
struct Body {
  std::unique_ptr<DeformableModel> model;
  std::unique_ptr<Refinable> isotropic;  // of a model that tells nothing
  FineBody fine;
  int corners = 0;

  explicit Body(const std::string& type, ModelOptions options = {}, int wide = 5, int high = 2) {
    Mesh mesh = kuhn_block(wide, wide, high, 0.01);
    Sample s{std::mt19937_64(7)};
    corners = mesh.num_nodes();
    for (int i = 0; i < corners; ++i) {
      if (node(mesh.x, i).z() < 1e-9 && options.fixed_nodes.empty()) is_below.push_back(i);
      node(mesh.x, i) += 0.0015 * s.cube();
    }
    options.young = kYoung;
    if (options.fixed_nodes.empty()) options.fixed_nodes = is_below;
    if (options.fixed_nodes == std::vector{-1}) options.fixed_nodes.clear();
    model = make_model(type, std::move(mesh), options);
    fine = make_fine_body(*model, *told_by(*model));
  }
  std::vector<int> is_below;

  /// Bent and moving: no cell is as it was.
  State strained(double by) const {
    State out = rest_state(*model);
    const VectorX x = out.x;
    for (int i = 0; i < model->mesh().num_nodes(); ++i) {
      const Vec3 p = node(x, i) / 0.02;
      node(out.x, i) += by * 0.02 * Vec3(std::sin(p.z()), 0.3 * p.x() * p.z(), -0.5 * p.z() * std::cos(p.y()));
      node(out.v, i) += Vec3(p.y() * p.y(), -p.x(), std::sin(p.x() + p.z()));
    }
    return out;
  }
};

FineZoneOptions small_zone(double edge = 0.0035) {
  return {.centre = {0.027, 0.024, 0.02}, .radius = 0.014, .reach = 0.006, .size = {.edge = edge, .flat = 0.004}};
}

/// Where a fine node is, as shares of the corners of a cell that holds it, found by its place at rest.
struct Located {
  int cell = -1;
  Eigen::Vector4d shares;
};
Located locate(const FineBody& body, const FineZone& zone, const Vec3& place) {
  for (const int c : zone.cells) {
    const Tetrahedron& t = body.mesh->tetrahedra[c];
    Eigen::Matrix4d A;
    for (int i = 0; i < 4; ++i) A.col(i) << node(body.mesh->x, t[i]), 1;
    const Eigen::Vector4d shares = A.fullPivLu().solve(Eigen::Vector4d(place.x(), place.y(), place.z(), 1));
    if (shares.minCoeff() > -1e-9) return {c, shares};
  }
  return {};
}

/// What the body's nodes move each of some fine nodes by, from the shape functions of the cell that holds it, for
/// three coordinates each.
MatrixX field_of(const FineBody& body, const FineZone& zone, std::span<const int> nodes) {
  MatrixX out = MatrixX::Zero(3 * static_cast<Eigen::Index>(nodes.size()), 3 * body.mesh->num_nodes());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Located at = locate(body, zone, zone.nodes[nodes[i]].of(body.mesh->x));
    const std::span<const int> cell = body.material->cell_nodes(at.cell);
    VectorX N(cell.size());
    if (cell.size() == 4) {
      N = at.shares;
    } else {
      constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
      for (int c = 0; c < 4; ++c) N[c] = at.shares[c] * (2 * at.shares[c] - 1);
      for (int e = 0; e < 6; ++e) N[4 + e] = 4 * at.shares[kEdges[e][0]] * at.shares[kEdges[e][1]];
    }
    for (std::size_t a = 0; a < cell.size(); ++a)
      for (int d = 0; d < 3; ++d) out(3 * static_cast<Eigen::Index>(i) + d, 3 * cell[a] + d) += N[static_cast<int>(a)];
  }
  return out;
}

std::vector<int> dofs_of(std::span<const int> nodes) {
  std::vector<int> out;
  for (const int i : nodes) out.insert(out.end(), {3 * i, 3 * i + 1, 3 * i + 2});
  return out;
}

MatrixX symmetric_block(const SparseMatrix& dfdx, std::span<const int> nodes) {
  const std::vector<int> dofs = dofs_of(nodes);
  const MatrixX K = -MatrixX(dfdx)(dofs, dofs);
  return 0.5 * (K + K.transpose());
}

/// The last `count` rows and columns of the inverse.
MatrixX inverse_of(const MatrixX& A, Eigen::Index count) {
  MatrixX unit = MatrixX::Zero(A.rows(), count);
  unit.bottomRows(count).setIdentity();
  return A.llt().solve(unit).bottomRows(count);
}

/// A zone that is the whole of a free block, fine at one corner of its top: many nodes hang.
TEST(FineYield, AffineFieldsHaveConstantStressOverHangingNodes) {
  const Body body("fem", {.fixed_nodes = {-1}, .material = "linear"}, 3);
  const VectorX& x = body.fine.mesh->x;
  const FineZone zone = make_fine_zone(body.fine, {.centre = {0.012, 0.013, 0.02},
                                                   .radius = 1,
                                                   .reach = 1,
                                                   .size = {.edge = 0.0012, .flat = 0.003, .slope = 0.6},
                                                   .most_nodes = 100000});
  int hanging = 0, most_levels = 0;
  for (std::size_t i = 0; i < zone.nodes.size(); ++i) hanging += zone.first[i + 1] - zone.first[i] > 1;
  for (const FineLeaf& leaf : zone.leaves) most_levels = std::max(most_levels, leaf.level);
  ASSERT_GT(hanging, 100);
  ASSERT_GE(most_levels, 3);
  const State rest = rest_state(*body.model);
  const SparseMatrix K = fine_stiffness(body.fine, zone, {rest});
  EXPECT_EQ(SparseMatrix(K - SparseMatrix(K.transpose())).norm(), 0);

  Mat3 A;
  A << 0.1, 0.02, -0.03, 0.05, -0.07, 0.01, 0.04, 0.03, 0.06;
  VectorX u(3 * zone.num_unknown());
  for (int i = 0; i < zone.num_unknown(); ++i)
    node(u, i) = A * zone.nodes[zone.unknown[i]].of(x) + Vec3(0.3, -0.2, 0.1);
  const VectorX f = K * u;
  // The surface's nodes are pulled; no force is left on any other.
  std::set<int> on_surface;
  for (const Triangle& t : zone.facets)
    for (const int i : t)
      for (int k = zone.first[i]; k < zone.first[i + 1]; ++k) on_surface.insert(zone.from[k]);
  int inside = 0;
  for (int i = 0; i < zone.num_unknown(); ++i)
    if (!on_surface.contains(i)) {
      EXPECT_LE(node(f, i).lpNorm<Eigen::Infinity>(), 1e-10 * f.lpNorm<Eigen::Infinity>());
      ++inside;
    }
  ASSERT_GT(inside, 100);
  double volume = 0;
  for (const Tetrahedron& t : body.fine.mesh->tetrahedra) volume += tetrahedron_volume(x, t);
  const double energy = volume * A.reshaped().dot(isotropic_moduli(kYoung, 0.3) * A.reshaped());
  EXPECT_NEAR(u.dot(f) / energy, 1, 1e-10);
  // Facets close the surface: their area vectors add up to nothing.
  Vec3 area = Vec3::Zero();
  for (const Triangle& t : zone.facets) {
    const Vec3 a = zone.nodes[t[0]].of(x);
    area += (zone.nodes[t[1]].of(x) - a).cross(zone.nodes[t[2]].of(x) - a);
  }
  EXPECT_LE(area.norm(), 1e-15);
}

/// Motions of the coarse nodes are motions of the fine ones, and cost the same energy: in any material, strained and
/// moving, exact and definite.
TEST(FineYield, LeavesAreAsStiffAsTheirCellsForMotionsOfTheseAlone) {
  for (const char* material : {"linear", "corotational", "neo_hookean"})
    for (const TangentKind kind : {TangentKind::symmetric, TangentKind::definite})
      for (const std::string element : {"tet4", "tet10"}) {
        const Body body("fem", {.damping_stiffness = 0.002, .material = material, .element = element});
        const State state = body.strained(0.25);
        // Quadratic cells are strained differently everywhere, which finer leaves see in more places.
        const FineZone zone = make_fine_zone(body.fine, small_zone(element == "tet4" ? 0.0035 : 0.02));
        ASSERT_EQ(element == "tet4", zone.leaves.size() > zone.cells.size());
        ASSERT_GT(zone.inner.size(), 4u);
        const MatrixX P = field_of(body.fine, zone, zone.unknown)(Eigen::all, dofs_of(zone.inner));
        const MatrixX fine = P.transpose() * fine_stiffness(body.fine, zone, {state, kind}) * P;
        const MatrixX coarse = symmetric_block(body.model->tangent(state, kind).dfdx, zone.inner);
        EXPECT_LE((fine - coarse).norm(), 1e-10 * coarse.norm()) << material << ' ' << element;
      }
}

/// Of a linear material quadratic cells are integrated exactly, so that refined ones cost the same energy, too.
TEST(FineYield, RefinedQuadraticCellsAreAsStiffForMotionsOfTheCoarseNodes) {
  const Body body("fem", {.material = "linear", .element = "tet10"});
  const FineZone zone = make_fine_zone(body.fine, small_zone());
  ASSERT_GT(zone.leaves.size(), zone.cells.size());
  const State rest = rest_state(*body.model);
  const MatrixX P = field_of(body.fine, zone, zone.unknown)(Eigen::all, dofs_of(zone.inner));
  const MatrixX fine = P.transpose() * fine_stiffness(body.fine, zone, {rest}) * P;
  const MatrixX coarse = symmetric_block(body.model->tangent(rest, TangentKind::symmetric).dfdx, zone.inner);
  EXPECT_LE((fine - coarse).norm(), 1e-10 * coarse.norm());
}

struct YieldCase {
  const char* name;
  std::string type;
  ModelOptions options;
  FineZoneOptions zone;
  double strain = 0;
  bool is_softer = false;  ///< the coarse body, in places
  double factor = 1;       ///< of the coarse body's stiffness
};

class FineYieldOf : public testing::TestWithParam<YieldCase> {};

TEST_P(FineYieldOf, IsTheDifferenceOfDenseInversesAndNeverNegative) {
  const YieldCase& c = GetParam();
  const Body body(c.type, c.options);
  const State state = body.strained(c.strain);
  const TangentKind kind = TangentKind::symmetric;
  const SparseMatrix dfdx = c.factor * body.model->tangent(state, kind).dfdx;
  const FineZone zone = make_fine_zone(body.fine, c.zone);
  ASSERT_GT(zone.num_yielding, 20);
  ASSERT_GT(zone.inner.size(), 3u);
  const auto solver = make_block_solver();
  const FineYield yield = find_yield(body.fine, zone, {state, kind}, dfdx, *solver);
  EXPECT_EQ(yield.retardation, c.options.damping_stiffness);

  const Eigen::Index p = 3 * zone.num_yielding;
  const MatrixX S_f = inverse_of(MatrixX(fine_stiffness(body.fine, zone, {state, kind})), p);
  const MatrixX K_c = symmetric_block(dfdx, zone.inner), S_c = inverse_of(K_c, K_c.rows());
  const MatrixX W = field_of(body.fine, zone, zone.yielding())(Eigen::all, dofs_of(zone.inner));
  MatrixX expected = S_f - W * S_c * W.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixX> eigen(expected);
  const double lowest = eigen.eigenvalues()[0], highest = eigen.eigenvalues()[p - 1];
  EXPECT_EQ(yield.added > 0, c.factor == 0.57);
  if (yield.added > 0) {  // slightly so
    EXPECT_LT(lowest, -1e-8 * highest);
    EXPECT_GE(lowest, -yield.added);
    EXPECT_LE(yield.added, 5.001e-2 * expected.trace() / static_cast<double>(p));
    expected.diagonal().array() += yield.added;
  } else if (lowest < -1e-8 * highest) {  // where the coarse cells are softer in places
    EXPECT_NEAR(yield.least, lowest / std::max(highest, -lowest), 1e-6);
    expected = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
  } else {
    EXPECT_EQ(yield.least, 0);
  }
  EXPECT_EQ(lowest < -1e-8 * highest, c.is_softer) << lowest / highest;
  EXPECT_LE((yield.R - expected).norm(), 1e-9 * expected.norm());
  EXPECT_EQ((yield.R - yield.R.transpose()).lpNorm<Eigen::Infinity>(), 0);
  const VectorX values = Eigen::SelfAdjointEigenSolver<MatrixX>(yield.R).eigenvalues();
  EXPECT_GE(values[0], -1e-12 * values[p - 1]);
  // The weights that the tick will have are those of the coarse field.
  const MatrixX all = field_of(body.fine, zone, zone.yielding());
  const MatrixX weights = coarse_weights(body.fine, zone, zone.yielding());
  for (int d = 0; d < 3; ++d)
    EXPECT_LE((all(Eigen::seqN(d, zone.num_yielding, 3), Eigen::seqN(d, body.fine.mesh->num_nodes(), 3)) - weights)
                  .lpNorm<Eigen::Infinity>(),
              1e-12);
  // Twice the same, with an analysis that is kept and with a new one.
  EXPECT_EQ(find_yield(body.fine, zone, {state, kind}, dfdx, *solver).R, yield.R);
  const auto fresh = make_block_solver();
  EXPECT_EQ(find_yield(body.fine, make_fine_zone(body.fine, c.zone), {state, kind}, dfdx, *fresh).R, yield.R);
}

const std::vector<Inclusion> kBall{{.center = {0.027, 0.024, 0.012}, .radius = 0.006, .stiffer = 5}};
/// In the corners of cells of which it holds the middle of some.
const std::vector<Inclusion> kTop{{.center = {0.030, 0.030, 0.02}, .radius = 0.007, .stiffer = 20}};

/// Of cells that nothing refines, which models give the inclusions that hold their middles.
TEST(FineYield, LeavesHaveTheInclusionsOfTheirMiddles) {
  for (const std::string element : {"tet4", "tet10"}) {
    const Body body("fem", {.material = "linear", .element = element, .inclusions = kTop});
    const FineZone zone = make_fine_zone(body.fine, small_zone(0.02));
    ASSERT_EQ(zone.leaves.size(), zone.cells.size());
    const State rest = rest_state(*body.model);
    const MatrixX P = field_of(body.fine, zone, zone.unknown)(Eigen::all, dofs_of(zone.inner));
    const MatrixX fine = P.transpose() * fine_stiffness(body.fine, zone, {rest}) * P;
    const MatrixX coarse = symmetric_block(body.model->tangent(rest, TangentKind::symmetric).dfdx, zone.inner);
    EXPECT_LE((fine - coarse).norm(), 1e-10 * coarse.norm()) << element;
  }
}

/// At a side of the block: facets on two faces, creased between.
FineZoneOptions side_zone() {
  FineZoneOptions out = small_zone();
  out.centre.x() = 0.0495;
  return out;
}
/// Where the clamped face is near.
FineZoneOptions low_zone() {
  FineZoneOptions out = small_zone();
  out.centre = {0.0495, 0.024, 0.006};
  return out;
}

INSTANTIATE_TEST_SUITE_P(
    Bodies, FineYieldOf,
    testing::Values(
        YieldCase{"tet4", "fem", {.material = "linear"}, small_zone()},
        YieldCase{"tet4_strained", "fem", {.damping_stiffness = 0.002, .material = "neo_hookean"}, small_zone(), 0.15},
        YieldCase{"tet4_side", "fem", {.material = "linear"}, side_zone()},
        YieldCase{"tet4_clamped", "fem", {.material = "linear"}, low_zone()},
        YieldCase{"tet4_stiffer_ball", "fem", {.material = "linear", .inclusions = kBall}, small_zone()},
        YieldCase{"tet4_ball_at_the_top", "fem", {.material = "linear", .inclusions = kTop}, small_zone()},
        YieldCase{"tet10", "fem", {.material = "linear", .element = "tet10"}, small_zone()},
        YieldCase{"tet10_side", "fem", {.poisson = 0.49, .material = "linear", .element = "tet10"}, side_zone()},
        YieldCase{"springs", "msd", {}, small_zone(), 0, true},
        YieldCase{"slightly_softer", "fem", {}, small_zone(), 0, true, 0.57},
        YieldCase{"much_softer", "fem", {}, small_zone(), 0, true, 0.5}),
    [](const auto& row) { return std::string(row.param.name); });

/// A body of quadratic cells that nothing refines is its own fine patch, at rest and strained.
TEST(FineYield, IsNothingWhereTheCoarseCellsAreAsFine) {
  const Body body("fem", {.material = "neo_hookean", .element = "tet10"});
  for (const double strain : {0.0, 0.15}) {
    const State state = body.strained(strain);
    const SparseMatrix dfdx = body.model->tangent(state, TangentKind::symmetric).dfdx;
    const auto share = [&](double edge) {
      const FineZone zone = make_fine_zone(body.fine, small_zone(edge));
      const auto solver = make_block_solver();
      const MatrixX R = find_yield(body.fine, zone, {state}, dfdx, *solver).R;
      const MatrixX S_f = inverse_of(MatrixX(fine_stiffness(body.fine, zone, {state})), R.rows());
      return R.lpNorm<Eigen::Infinity>() / S_f.lpNorm<Eigen::Infinity>();
    };
    EXPECT_LE(share(0.02), 1e-12);
    EXPECT_GE(share(0.006), 0.02);
  }
}

/// A user's own model: only its forces and what it names.
class OwnModel final : public WrappingModel {
 public:
  OwnModel(const DeformableModel& model, ModelInfo info) : WrappingModel(model), info_(std::move(info)) {}
  ModelInfo info() const override { return info_; }

 private:
  ModelInfo info_;
};

TEST(FineYield, OfAModelThatNamesItsMaterialIsThatOfTheMaterial) {
  const Body body("fem", {.material = "corotational"});
  const OwnModel own(*body.model, {"own", "", {{"young", kYoung}, {"poisson", 0.3}, {"damping_stiffness", 0.003}}});
  EXPECT_EQ(told_by(own), nullptr);
  const auto material = isotropic_cells(own);
  EXPECT_EQ(material->retardation(), 0.003);
  const FineBody fine = make_fine_body(own, *material);
  // Turned as a whole: what both say of their cells is the same material, turned.
  State state = rest_state(own);
  const Mat3 turn = Eigen::AngleAxisd(1.2, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (int i = 0; i < own.mesh().num_nodes(); ++i) node(state.x, i) = turn * node(own.mesh().x, i);
  const SparseMatrix dfdx = own.tangent(state, TangentKind::symmetric).dfdx;
  const FineZone zone = make_fine_zone(fine, small_zone());
  const auto solver = make_block_solver(), other = make_block_solver();
  const FineYield named = find_yield(fine, zone, {state}, dfdx, *solver);
  const FineYield told = find_yield(body.fine, zone, {state}, dfdx, *other);
  EXPECT_EQ(named.least, 0);
  EXPECT_LE((named.R - told.R).norm(), 1e-9 * told.R.norm());
}

TEST(FineYield, RefusesModelsThatTellTooLittle) {
  const Body linear("fem", {.material = "linear"}), quadratic("fem", {.material = "linear", .element = "tet10"});
  const ModelInfo named{"own", "", {{"young", kYoung}, {"poisson", 0.3}}};
  EXPECT_THROW(isotropic_cells(OwnModel(*linear.model, {"own", "", {{"young", kYoung}}})), InputError);
  EXPECT_THROW(isotropic_cells(OwnModel(*linear.model, {"own", "", {{"young", -1}, {"poisson", 0.3}}})), InputError);
  EXPECT_THROW(isotropic_cells(OwnModel(*linear.model, {"own", "", {{"young", 1}, {"poisson", 0.5}}})), InputError);
  EXPECT_NO_THROW(isotropic_cells(OwnModel(*linear.model, named)));
  // Nodes between corners, of which a model that tells nothing says nothing.
  EXPECT_THROW(isotropic_cells(OwnModel(*quadratic.model, named)), InputError);
}

struct PressLimit {
  const char* name;
  PressBlockOptions block;
  FinePress press;
  double most;
};

class FinePresses : public testing::TestWithParam<PressLimit> {};

/// The whole table: bench/fine_press_table.cpp.
TEST_P(FinePresses, AreThoseOfTheContinuum) {
  const PressLimit& limit = GetParam();
  const PressBlock block(limit.block);
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.5, 0.0}, {0.3333, 0.6667}}) {
    FinePress press = limit.press;
    press.x = x;
    press.y = y;
    const FinePressed p = press_fine(block, press);
    EXPECT_GE(p.fine, 0.97) << "coarse " << p.coarse;
    EXPECT_LE(p.fine, limit.most) << "coarse " << p.coarse;
    EXPECT_LE(p.unknown, press.most_nodes);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Rows, FinePresses,
    testing::Values(PressLimit{"tet4", {}, {}, 1.12}, PressLimit{"tet4_shallow", {}, {.depth = 0.0005}, 1.12},
                    PressLimit{"tet4_finer", {}, {.depth = 0.003, .fineness = 0.5, .most_nodes = 5000}, 1.08},
                    PressLimit{"tet4_10_mm", {.cell = 0.01}, {.depth = 0.003}, 1.13},
                    PressLimit{"layer_3_mm", {.thickness = 0.003}, {}, 1.09},
                    PressLimit{"tet10_nu_049",
                               {.element = "tet10", .cell = 0.01, .poisson = 0.49},
                               {.fineness = 0.5, .most_nodes = 5000},
                               1.06}),
    [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace kt
