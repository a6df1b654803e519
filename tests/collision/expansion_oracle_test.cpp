// Expansions against integers of 128 bits, and against identities that rounding would break.
#include "collision/impact/expansion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace kt {
namespace {

#ifdef __SIZEOF_INT128__
__extension__ typedef __int128 Wide;

Expansion expansion_of(std::int64_t v) {
  const double high = static_cast<double>(v >> 32) * 0x1p32, low = static_cast<double>(v & 0xffffffff);
  return Expansion(high) + Expansion(low);
}
/// Its components taken away one by one.
Wide value_of(const Expansion& e) {
  if (e.size() == 0) return 0;
  const double top = e.estimate();
  return static_cast<Wide>(top) + value_of(e - Expansion(top));
}

TEST(Expansion, SumsAndProductsAreThoseOfIntegers) {
  std::mt19937_64 random(31);
  for (int i = 0; i < 100000; ++i) {
    const int shift = static_cast<int>(random() % 60);
    const auto a = static_cast<std::int64_t>(random()) >> (2 + shift), b = static_cast<std::int64_t>(random()) >> 3;
    const Expansion ea = expansion_of(a), eb = expansion_of(b);
    ASSERT_EQ(value_of(ea), a);
    ASSERT_TRUE(value_of(ea + eb) == Wide(a) + b);
    ASSERT_TRUE(value_of(ea - eb) == Wide(a) - b);
    ASSERT_TRUE(value_of(ea * eb) == Wide(a) * b);
    ASSERT_EQ((ea * eb - eb * ea).size(), 0);
  }
}
#endif

TEST(Expansion, IdentitiesHoldOverAWideRangeOfExponents) {
  std::mt19937_64 random(32);
  const auto number = [&](int range) {
    const double m = std::uniform_real_distribution<double>(-1, 1)(random);
    return std::ldexp(m, std::uniform_int_distribution<int>(-range, range)(random));
  };
  int components = 0;
  for (int i = 0; i < 20000; ++i) {
    const int range = 1 + i % 100;
    const auto term = [&] { return Expansion::difference(number(range), number(range)); };
    const Expansion a = term(), b = term(), c = term();
    const Expansion abc = (a * b) * c, zero = abc - a * (b * c);
    ASSERT_TRUE(abc.fits() && zero.fits());
    ASSERT_EQ(zero.size(), 0);
    ASSERT_EQ(((a + b) * c - a * c - b * c).size(), 0);
    ASSERT_EQ(((a + b) + c - (a + (b + c))).size(), 0);
    ASSERT_EQ((a * 3.0 - a - a - a).size(), 0);
    components = std::max(components, abc.size());
    // One bit more is seen, and its sign is right.
    const double tiny = std::ldexp(1, -900);
    ASSERT_EQ((abc + Expansion(tiny) - abc).estimate(), tiny);
    ASSERT_EQ((abc - Expansion(tiny) - abc).estimate(), -tiny);
  }
  EXPECT_GT(components, 4);
}

TEST(Expansion, WhatDoesNotFitIsMarkedAndStaysMarked) {
  Expansion sum;
  for (int i = 0; i < Expansion::kCapacity; ++i) sum = sum + Expansion(std::ldexp(1, 54 * (i - 17)));
  EXPECT_TRUE(sum.fits());
  EXPECT_EQ(sum.size(), Expansion::kCapacity);
  const Expansion more = sum + Expansion(0x1p-1000);
  EXPECT_FALSE(more.fits());
  EXPECT_FALSE((more * 2.0).fits());
  EXPECT_FALSE((Expansion(1) - more).fits());
  EXPECT_FALSE((Expansion(1) * more).fits());
}

}  // namespace
}  // namespace kt
