#pragma once
#include <cstdint>

namespace kt {

/// A number's place in an order that has nothing to do with how things are numbered, the same everywhere.
constexpr std::uint32_t mixed(int number) noexcept {
  auto h = static_cast<std::uint32_t>(number) + 0x9e3779b9u;
  for (int i = 0; i < 2; ++i) h = (h ^ (h >> 16)) * 0x45d9f3bu;
  return h ^ (h >> 16);
}

}  // namespace kt
