// Which name of a force Haply's service takes, and whether it takes any: from what it repeats, without a clock.
#include "haptics/driver/haply/haply_echo.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A service that knows one name, or none, and answers each message after some others.
class Service {
 public:
  Service(std::optional<HaplyKey> knows, HaplyKey first) : knows_(knows), echo(first) {}
  /// One message of ours with a force, and one answer.
  void send(const Vec3& force, std::int64_t order_ns = 0) {
    now += 2 * kMs;
    echo.sent(force, order_ns, now);
    if (knows_ == echo.key()) repeated_ = factor * force;
    later_.push_back(repeated_);
    if (later_.size() > late) {
      echo.heard(repeats ? std::optional<Vec3>(later_.front()) : std::nullopt, now);
      later_.erase(later_.begin());
    }
  }
  bool proves(int messages) {
    for (int i = 0; i < messages && !echo.is_proven(); ++i) send(echo.proof());
    return echo.is_proven();
  }

  std::size_t late = 0;
  double factor = 1;
  bool repeats = true;
  std::int64_t now = 0;

 private:
  std::optional<HaplyKey> knows_;
  Vec3 repeated_ = Vec3::Zero();
  std::vector<Vec3> later_;

 public:
  HaplyEcho echo;
};

TEST(HaplyEcho, FindsTheNameWhicheverComesFirst) {
  for (const HaplyKey knows : {HaplyKey::vector, HaplyKey::values})
    for (const HaplyKey first : {HaplyKey::vector, HaplyKey::values})
      for (const std::size_t late : {0u, 5u}) {
        Service service(knows, first);
        service.late = late;
        EXPECT_TRUE(service.proves(knows == first ? 10 : 200)) << late;
        EXPECT_EQ(service.echo.key(), knows);
        EXPECT_NEAR(service.echo.most(), HaplyEcho::kProof, 1e-12) << "no more than that was sent";
      }
}

TEST(HaplyEcho, WhoTakesOrRepeatsNothingIsNeverTrusted) {
  Service deaf(std::nullopt, HaplyKey::vector);
  EXPECT_FALSE(deaf.proves(2000));
  Service mute(HaplyKey::vector, HaplyKey::vector);
  mute.repeats = false;
  EXPECT_FALSE(mute.proves(2000));
}

TEST(HaplyEcho, WhoStopsRepeatingHasToProveItselfAgain) {
  Service service(HaplyKey::vector, HaplyKey::vector);
  ASSERT_TRUE(service.proves(10));
  for (int i = 0; i < 1000; ++i) service.send({0, 0, 2});
  EXPECT_TRUE(service.echo.is_proven());
  service.factor = 0;
  int messages = 0;
  for (; service.echo.is_proven() && messages < 1000; ++messages) service.send({0, 0, 2});
  EXPECT_LT(messages, 100) << "0.2 s";
  service.factor = 1;
  EXPECT_TRUE(service.proves(200)) << "and may";
}

TEST(HaplyEcho, SmallForcesAndSmallerEchoesAreNoSilence) {
  Service service(HaplyKey::values, HaplyKey::values);
  ASSERT_TRUE(service.proves(10));
  service.factor = 0;
  for (int i = 0; i < 1000; ++i) service.send({0, 0, 0.01});
  EXPECT_TRUE(service.echo.is_proven()) << "too small to be told from none";
  service.factor = 0.1;
  for (int i = 0; i < 1000; ++i) service.send({0, 0, 2});
  EXPECT_TRUE(service.echo.is_proven());
  EXPECT_NEAR(service.echo.most(), 0.2, 1e-12) << "what was taken is told";
}

TEST(HaplyEcho, TellsTheWayOfAMessage) {
  Service service(HaplyKey::vector, HaplyKey::vector);
  service.late = 3;
  ASSERT_TRUE(service.proves(10));
  int told = 0;
  for (int i = 1; i <= 100; ++i) {
    service.send({0, 0, 0.01 * i}, service.now + 2 * kMs);
    if (const auto delay = service.echo.take_delay()) {
      EXPECT_EQ(*delay, 6 * kMs);
      ++told;
    }
  }
  EXPECT_GT(told, 90);
}

}  // namespace
}  // namespace kt
