#pragma once
// Random numbers and places of one test.
#include <random>

#include "core/base/types.hpp"

namespace kt {

struct Sample {
  std::mt19937_64 random;
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  Vec3 cube() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
};

}  // namespace kt
