// Figures for people: three digits, the same everywhere.
#include "core/base/numbers.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

TEST(Figures, HaveThreeDigitsAndNoExponentBelowAMillion) {
  EXPECT_EQ(short_number(0.00260561), "0.00261");
  EXPECT_EQ(short_number(8.68538), "8.69");
  EXPECT_EQ(short_number(2380.4), "2380");
  EXPECT_EQ(short_number(44100), "44100");
  EXPECT_EQ(short_number(999.6), "1000");
  EXPECT_EQ(short_number(999.4), "999");
  EXPECT_EQ(short_number(150, 2), "150");
  EXPECT_EQ(short_number(2e6), "2e+06");
  EXPECT_EQ(short_number(8e-5), "0.00008");
  EXPECT_EQ(short_number(-1.2345e-6), "-0.00000123");
  EXPECT_EQ(short_number(1e-7), "1e-07");
  EXPECT_EQ(in_unit(2.2254e-3, "s"), "2.23 ms");
  EXPECT_EQ(in_unit(1.96e-5, "s"), "19.6 us");
  EXPECT_EQ(in_unit(0.9999e-3, "s"), "1 ms");
  EXPECT_EQ(in_unit(-0.08, "m"), "-80 mm");
  EXPECT_EQ(in_unit(1.54e9, "B", 2), "1.5 GB");
  EXPECT_EQ(in_unit(0, "N"), "0 N");
  EXPECT_EQ(in_unit(2e-11, "m"), "0.02 nm");
  EXPECT_EQ(short_number(0.345408, 2), "0.35");
  EXPECT_EQ(in_percent(23.8), "2380 %");
  EXPECT_EQ(in_percent(0.0376), "3.76 %");
  EXPECT_EQ(in_percent(5e-5), "< 0.01 %");
  EXPECT_EQ(in_percent(0), "0 %");
}

TEST(Figures, AreThoseOfWhatIsTold) {
  EXPECT_EQ(told("in ", 12345678, " of ", 8.68538, " mm, ", std::string("twice")), "in 12345678 of 8.69 mm, twice");
}

}  // namespace
}  // namespace kt
