#include "network/channel/rate_control.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

constexpr double kLeastExcess = 0.03;  // of loss beyond what is by chance, to be looked into
constexpr double kSigmas = 3;
constexpr double kLongestAlone = 32;  // [s]
constexpr double kNewShare = 0.25;    // of the newest window in the loss by chance
constexpr double kArrives = 1.2;      // of the share that arrives, slow over fast: at least that much on a full line
constexpr double kLeastLimit = 50;    // datagrams a second: 0.5 Mbit/s

std::chrono::steady_clock::duration seconds(double s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
}

/// Of a loss that was measured over so many datagrams.
double sigma(double loss, double datagrams) {
  return std::sqrt(std::max(loss * (1 - loss), 0.01) / std::max(datagrams, 1.0));
}

}  // namespace

void RateControl::told(const Feedback& told, std::uint64_t sent, Time now) {
  if (told.newest > sent || told.newest < from_) return;  // cannot be; sent before the window
  if (!has_begun_ || told.newest < first_.newest || told.came < first_.came) {
    if (has_begun_) return;  // an older one
    has_begun_ = true;
    first_ = told;
    began_ = now;
    return;
  }
  const double datagrams = static_cast<double>(told.newest - first_.newest);
  const double time = std::chrono::duration<double>(now - began_).count();
  if (time < kUsualWindow || datagrams < static_cast<double>(is_testing_ ? kFewestInTest : kFewest)) return;
  const double came = std::min(static_cast<double>(told.came - first_.came), datagrams);
  first_ = told;
  began_ = now;
  look_at({1 - came / datagrams, datagrams / time, came / time, datagrams}, sent, now);
}

void RateControl::look_at(const Window& window, std::uint64_t sent, Time now) {
  const double usual = chance_.value_or(0), excess = window.loss - usual;
  if (is_testing_) {
    judge(window, now);
  } else if (excess > std::max(kLeastExcess, kSigmas * sigma(usual, window.datagrams))) {
    before_ = window;
    is_testing_ = true;
    test_limit_ = std::max(kLeastLimit, kSlower * std::min(window.rate, limit_));
  } else {
    chance_ = usual + (chance_ ? kNewShare : 1) * excess;
    return grow(window, now);
  }
  from_ = sent;  // what is on its way was sent at another rate
  has_begun_ = false;
}

/// After an experiment.
void RateControl::judge(const Window& slow, Time now) {
  is_testing_ = false;
  const Window& fast = before_;
  const double chance = std::hypot(sigma(fast.loss, fast.datagrams), sigma(slow.loss, slow.datagrams));
  const bool is_less = fast.loss - slow.loss > std::max(kLeastExcess, kSigmas * chance);
  const bool is_full = is_less && (slow.loss < 0.5 * fast.loss || (1 - slow.loss) > kArrives * (1 - fast.loss));
  if (!is_full) {
    chance_ = (fast.loss * fast.datagrams + slow.loss * slow.datagrams) / (fast.datagrams + slow.datagrams);
    return;
  }
  ++full_;
  chance_ = std::min(chance_.value_or(0), slow.loss);  // the slower one may still have been too fast
  limit_ = std::max(kLeastLimit, kOfLine * std::max(fast.arriving, slow.arriving) / (1 - *chance_));
  alone_until_ = now + seconds(alone_);
  alone_ = std::min(2 * alone_, kLongestAlone);
}

void RateControl::grow(const Window& window, Time now) {
  if (limit_ == kNone || now < alone_until_) return;
  limit_ *= kFaster;
  if (limit_ > 4 * window.rate) limit_ = kNone;  // nobody asks for so much
}

}  // namespace kt
