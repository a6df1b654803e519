// Mailbox and ring between two threads. No sleeps: the threads race as they like, only order and ownership count.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "haptics/link/mailbox.hpp"
#include "haptics/link/ring.hpp"

namespace kt {
namespace {

/// A value that counts how many of its kind live.
struct Counted {
  static std::atomic<int> alive;
  int value;
  explicit Counted(int v) : value(v) { ++alive; }
  ~Counted() { --alive; }
};
std::atomic<int> Counted::alive{0};

TEST(Mailbox, GivesTheLatestAndHandsBackWhatNobodyTook) {
  Mailbox<Counted> box;
  EXPECT_TRUE(box.is_empty());
  EXPECT_EQ(box.take(), nullptr);
  EXPECT_EQ(box.put(std::make_unique<Counted>(1)), nullptr);
  const auto refused = box.put(std::make_unique<Counted>(2));
  ASSERT_NE(refused, nullptr);
  EXPECT_EQ(refused->value, 1);
  EXPECT_EQ(box.take()->value, 2);
  EXPECT_TRUE(box.is_empty());
}

TEST(Mailbox, OwnsWhatIsLeftInIt) {
  const int before = Counted::alive;
  {
    Mailbox<Counted> box;
    box.put(std::make_unique<Counted>(1));
    EXPECT_EQ(Counted::alive, before + 1);
  }
  EXPECT_EQ(Counted::alive, before);
}

TEST(Mailbox, TwoThreadsLoseNothingAndSeeNewerOnesOnly) {
  constexpr int kCount = 200000;
  const int before = Counted::alive;
  int taken = 0, given_back = 0;
  {
    Mailbox<Counted> box;
    std::atomic<bool> done{false};
    std::thread reader([&] {
      int last = -1;
      for (bool end = false; !end;) {
        end = done;  // read before the last look
        while (const auto object = box.take()) {
          EXPECT_GT(object->value, last);
          last = object->value;
          ++taken;
        }
      }
      EXPECT_EQ(last, kCount - 1);
    });
    for (int i = 0; i < kCount; ++i) given_back += box.put(std::make_unique<Counted>(i)) != nullptr;
    done = true;
    reader.join();
  }
  EXPECT_EQ(taken + given_back, kCount);
  EXPECT_EQ(Counted::alive, before);
}

TEST(Ring, KeepsTheOrderAndRefusesWhenFull) {
  Ring<int> ring(3);
  int out = 0;
  EXPECT_FALSE(ring.pop(out));
  for (int round = 0; round < 10; ++round) {
    EXPECT_TRUE(ring.push(1) && ring.push(2) && ring.push(3));
    EXPECT_FALSE(ring.push(4)) << "full: nothing is overwritten";
    for (int expected : {1, 2, 3}) {
      ASSERT_TRUE(ring.pop(out));
      EXPECT_EQ(out, expected);
    }
    EXPECT_FALSE(ring.pop(out));
  }
}

TEST(Ring, TwoThreadsKeepTheOrderAndCountWhatDidNotFit) {
  struct Item {
    int value = 0;
    double copies[20] = {};  // several cache lines: a torn item would show
  };
  constexpr int kCount = 200000;
  Ring<Item> ring(64);
  std::atomic<bool> done{false};
  int received = 0, refused = 0;
  std::thread reader([&] {
    int last = -1;
    Item item;
    for (bool end = false; !end;) {
      end = done;
      while (ring.pop(item)) {
        EXPECT_GT(item.value, last);
        last = item.value;
        for (double copy : item.copies) EXPECT_EQ(copy, item.value);
        ++received;
      }
    }
  });
  for (int i = 0; i < kCount; ++i) {
    Item item{i, {}};
    for (double& copy : item.copies) copy = i;
    refused += !ring.push(item);
  }
  done = true;
  reader.join();
  EXPECT_EQ(received + refused, kCount);
  EXPECT_GT(received, 0);
}

}  // namespace
}  // namespace kt
