#pragma once
// What is behind a Touch, for what is made on top of it: sessions, views, links of one's own, tests.
#include <span>

#include "haptics/touch/body_link.hpp"

namespace kt {

struct TickContact;  // haptics/tick/tick_contact.hpp
class Touch;

struct TouchHalves {
  /// The body at the other end of a link of one's own (network/hand_link.hpp). After place(), before the first tick;
  /// throws what the maker throws.
  static void start(Touch& touch, const LinkMaker& make);
  /// Who follows the local models. Before the first tick, and before start(). Borrowed.
  static void observe(Touch& touch, ModelObserver* observer);
  /// What tick() would do first: without start(), the refresh that is due. To take its time apart from the tick's.
  static void refresh_if_due(Touch& touch) noexcept;

  // While nobody ticks:
  static BodySide& slow(Touch& touch);
  static const BodySide& slow(const Touch& touch);
  static const HapticSide& fast(const Touch& touch);
  static int lost_reports(const Touch& touch);
  /// At each contact of all tools, what the last tick did to the body.
  static std::span<const TickContact> last_samples(const Touch& touch) noexcept;
  /// As Touch::copy_positions(), as they are now: without a thread of the body's own.
  static void copy_positions_now(Touch& touch, VectorX& x);
};

}  // namespace kt
