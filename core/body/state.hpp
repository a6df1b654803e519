#pragma once
// Whether two states have the same bits.
#include <cstdint>

#include "core/body/mesh.hpp"

namespace kt {

/// FNV-1a over the bits of the values: equal hashes mean equal bits. Feed one value after the other.
class StateHash {
 public:
  void add(const void* bytes, std::size_t count) {
    const auto* b = static_cast<const unsigned char*>(bytes);
    for (std::size_t i = 0; i < count; ++i) value_ = (value_ ^ b[i]) * 1099511628211ull;
  }
  void add(double value) { add(&value, sizeof value); }
  void add(int value) { add(&value, sizeof value); }
  void add(const VectorX& values) { add(values.data(), sizeof(double) * static_cast<std::size_t>(values.size())); }
  void add(const Vec3& values) { add(values.data(), sizeof(double) * 3); }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

}  // namespace kt
