// The patch's motion goes from one local model to the next, and from that to the one after: it must not grow on its
// way.
#include "haptics/tick/local_motion.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/haptics_body.hpp"

namespace kt {
namespace {

const SoftBlock& sheet() {
  static const SoftBlock made{
      SoftBlockOptions{.mesh = "sheet.off", .layer = 0.0005, .young = 1e5, .reducer = "condensed", .reach = 0.012}};
  return made;
}

VectorX followed(const PreparedLocalModel& model) { return model.model.basis * model.state.q; }

/// Per recovered node.
double mean_square(const PreparedLocalModel& model) {
  return followed(model).squaredNorm() / static_cast<double>(model.model.recovered_node.size());
}

TEST(CarriedMotion, OfTheSameModelIsTheSame) {
  const auto a = sheet().local_model(Vec3(0.05, 0.05, 0.002)), b = sheet().local_model(Vec3(0.05, 0.05, 0.002));
  std::mt19937 random(1);
  std::normal_distribution<double> number;
  for (double& q : a->state.q) q = 1e-4 * number(random);
  for (double& q : a->state.q_rate) q = 1e-2 * number(random);
  a->state.q = a->model.fit * followed(*a);  // of these, what a fit keeps
  LocalMotion motion = make_local_motion(sheet().model->mesh().num_nodes());
  record_motion(*a, 0, motion);
  carry_motion(motion, *b);
  EXPECT_LE((followed(*b) - followed(*a)).norm(), 0.05 * followed(*a).norm());
  EXPECT_GE(followed(*b).norm(), 0.95 * followed(*a).norm());
}

/// Around a thin sheet's places in turn, as refreshes do while a tool moves to and fro. Between them nothing takes the
/// motion away.
TEST(CarriedMotion, DoesNotGrowFromRefreshToRefresh) {
  std::mt19937 random(2);
  std::normal_distribution<double> number;
  std::vector<std::unique_ptr<PreparedLocalModel>> models;
  for (const double x : {0.04, 0.043, 0.046, 0.05}) models.push_back(sheet().local_model(Vec3(x, 0.05, 0.002)));
  for (double& q : models[0]->state.q) q = 1e-4 * number(random);
  LocalMotion motion = make_local_motion(sheet().model->mesh().num_nodes());
  const double at_first = mean_square(*models[0]);
  ASSERT_GT(at_first, 0);
  double most = 0;
  for (std::size_t i = 1; i <= 60; ++i) {
    const PreparedLocalModel& before = *models[(i - 1) % models.size()];
    PreparedLocalModel& now = *models[i % models.size()];
    record_motion(before, 0, motion);
    double known = 0, sum = 0;
    for (const int n : now.model.recovered_node)
      if (const int row = motion.row[n]; row >= 0) {
        ++known;
        sum += (node(motion.x, row) - node(before.model.x0, row)).squaredNorm();
      }
    carry_motion(motion, now);
    ASSERT_LE(mean_square(now), (1 + 1e-9) * sum / known) << "refresh " << i;
    most = std::max(most, mean_square(now));
  }
  EXPECT_LE(most, 4 * at_first);
}

}  // namespace
}  // namespace kt
