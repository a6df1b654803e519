// What is predicted of a tick, against what can be counted: nodes under a disc, numbers that a solver reads.
#include "haptics/cost/tick_cost.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace kt {
namespace {

constexpr double kCell = 0.01;  // [m]

/// Nodes of quadratic triangles over squares that are cut in two, within a disc about a place: corners and middles of
/// edges lie on a grid of half the edge.
double count_nodes(double radius, double edge) {
  const double step = 0.5 * edge;
  const auto most = static_cast<int>(radius / step) + 2;
  double sum = 0;
  constexpr int kPlaces = 7;  // of the disc's middle, each way
  for (int p = 0; p < kPlaces; ++p)
    for (int q = 0; q < kPlaces; ++q)
      for (int i = -most; i <= most; ++i)
        for (int k = -most; k <= most; ++k)
          sum += std::hypot((i + 1.0 * p / kPlaces) * step, (k + 1.0 * q / kPlaces) * step) <= radius;
  return sum / (kPlaces * kPlaces);
}

TEST(ExpectedNodes, AreThoseUnderADisc) {
  const std::vector<SurfaceCell> cells(40, {0.5 * kCell * kCell, kCell});
  for (const double radius : {0.003, 0.005, 0.008})
    for (const double leaf : {0.02, 0.01, 0.006, 0.004, 0.002}) {
      double edge = kCell;
      while (edge > leaf) edge /= 2;
      EXPECT_NEAR(expected_nodes(radius, cells, leaf) / count_nodes(radius, edge), 1, 0.06) << radius << " " << leaf;
    }
}

TEST(ExpectedPlaces, AreOneAndThenAsTheAreaOverTheTrianglesGrows) {
  EXPECT_EQ(expected_places(0, 1e-5), 1);
  const double more = expected_places(0.004, 1e-5) - 1;
  EXPECT_GT(more, 0);
  EXPECT_NEAR(expected_places(0.008, 1e-5) - 1, 4 * more, 1e-12);
  EXPECT_NEAR(expected_places(0.004, 0.5e-5) - 1, 2 * more, 1e-12);
  EXPECT_LT(more, std::numbers::pi * 0.004 * 0.004 / 1e-5) << "no more than there are triangles";
}

TEST(PressedContactRadius, IsHertzs) {
  const ToolShape ball{ToolShape::Kind::sphere, 0.008};
  EXPECT_NEAR(pressed_contact_radius(ball, 0.002), 0.004, 1e-15);
  EXPECT_NEAR(pressed_contact_radius(ball, 0.5), 0.008, 1e-15) << "no wider than the ball";
  EXPECT_GT(pressed_contact_radius(ball, 0), 0) << "not known";
}

/// So many coordinates, and a patch of 40 vertices; no tool has to do with it.
LocalModel model_of(int dof) {
  LocalModel out;
  out.f0 = VectorX::Zero(dof);
  out.patch.global_node.assign(40, 0);
  out.basis = MatrixX::Ones(120, dof).sparseView();
  out.stiffness = MatrixX::Identity(dof, dof).sparseView();
  return out;
}

ExpectedTouch on_nodes(double places) { return {.places = places, .is_refined = true}; }

/// Sweeps read W, 9 numbers for each pair of places, ten to forty times in a tick of two or three guesses; a number
/// takes about a nanosecond.
TEST(PredictedTick, GrowsByWhatASolverReadsOfItsPlaces) {
  const LocalModel model = model_of(80);
  for (const double places : {10.0, 20.0, 36.0}) {
    const double more = predict_tick_us(model, on_nodes(places)) - predict_tick_us(model, on_nodes(places - 1));
    const double numbers = 9 * (places * places - (places - 1) * (places - 1));
    EXPECT_GT(more, 10 * 1e-3 * numbers) << places;
    EXPECT_LT(more, 40 * 1e-3 * numbers) << places;
  }
}

TEST(PredictedTick, IsLongerWithEachPlaceAndWithWhatIsAround) {
  const LocalModel model = model_of(80);
  for (const bool is_refined : {false, true}) {
    double before = predict_tick_us(model);
    for (int places = 1; places <= 36; ++places) {
      const ExpectedTouch touch{.places = 1.0 * places, .is_refined = is_refined};
      const double now = predict_tick_us(model, touch);
      EXPECT_GT(now, before) << places;
      before = now;
      EXPECT_GT(predict_tick_us(model, {.places = 1.0 * places, .facets = 1000, .is_refined = is_refined}), now);
      EXPECT_GT(predict_tick_us(model, {.places = 1.0 * places, .is_refined = is_refined, .is_long = true}), now);
    }
  }
}

TEST(SeenTouch, HoldsWhatTicksHeldInTheMiddle) {
  std::vector<LocalReport> reports(5);
  const std::array<int, 5> counts{0, 7, 20, 9, 0};
  for (std::size_t i = 0; i < counts.size(); ++i) reports[i].count = counts[i];
  const ExpectedTouch expected{.places = 30, .facets = 100};
  const ExpectedTouch now = seen_touch(expected, reports, true);
  EXPECT_EQ(now, (ExpectedTouch{.places = 9, .facets = 100, .is_refined = true}));
  EXPECT_EQ(seen_touch(expected, std::span(reports).first(1), true), expected) << "nothing was touched";
  EXPECT_EQ(seen_touch({}, reports, true), ExpectedTouch{}) << "of a method without places";
}

/// So that it says nothing about which local model is cheaper.
TEST(PredictedTick, HasTheSameContactWhateverTheModel) {
  const auto of_contact = [](const LocalModel& model) {
    return predict_tick_us(model, on_nodes(17)) - predict_tick_us(model);
  };
  EXPECT_NEAR(of_contact(model_of(60)), of_contact(model_of(400)), 1e-9);
}

TEST(PredictedTick, DoesNotGetCheaperWhereTheInverseIsNoLongerKept) {
  double before = 0;
  for (int dof : {100, 300, 450, 451, 600, 800}) {
    const double now = predict_tick_us(model_of(dof));
    EXPECT_GT(now, before) << dof;
    before = now;
  }
}

}  // namespace
}  // namespace kt
