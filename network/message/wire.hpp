#pragma once
// Between the values of the schema and our own. Only for the files of this folder.
#include <flatbuffers/flatbuffers.h>
#include <wire_generated.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "core/base/visible_text.hpp"
#include "network/message/messages.hpp"

namespace kt::wire {

constexpr double kFarthest = 1e6;  ///< [m], as places in a scene

inline D3 to_wire(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Vec3 from_wire(const D3& v) { return {v.x(), v.y(), v.z()}; }
inline F3 to_float(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
inline Vec3 from_wire(const F3& v) { return {v.x(), v.y(), v.z()}; }

/// One by one: the largest of some entries may leave out one that is not a number.
inline bool is_place(const Vec3& v) { return (v.array().abs() <= kFarthest).all(); }
inline bool is_turn(const Quaternion& r) { return std::abs(r.norm() - 1) < 1e-4; }

/// A missing vector counts as empty.
template <class T>
std::size_t size_of(const flatbuffers::Vector<T>* v) {
  return v ? v->size() : 0;
}

template <class T>
std::vector<T> copied(const flatbuffers::Vector<T>* v) {
  return v ? std::vector<T>(v->data(), v->data() + v->size()) : std::vector<T>{};
}

inline VectorX copied_x(const flatbuffers::Vector<double>* v) {
  if (!v) return {};
  return Eigen::Map<const VectorX>(v->data(), static_cast<Eigen::Index>(v->size()));
}

inline std::string text_of(const flatbuffers::String* s) { return s ? s->str() : std::string(); }

/// What the other side says for people to read.
inline std::string line_of(const flatbuffers::String* s, std::size_t most = kLongestLine) {
  return s ? one_line(s->string_view(), most) : std::string();
}

inline Bytes taken(flatbuffers::FlatBufferBuilder& builder) {
  const auto* from = builder.GetBufferPointer();
  return {from, from + builder.GetSize()};
}

/// A measured share; -1: not known. What is no share is not known either.
inline float loss_sent(const std::optional<double>& loss) { return static_cast<float>(loss.value_or(-1)); }
inline std::optional<double> loss_told(float loss) {
  if (!(loss >= 0)) return {};
  return std::min(static_cast<double>(loss), 1.0);
}

/// A verified message, or null.
template <class Table>
const Table* verified(std::span<const std::uint8_t> bytes) {
  flatbuffers::Verifier verifier(bytes.data(), bytes.size(), 8, 10000);
  return verifier.VerifyBuffer<Table>(nullptr) ? flatbuffers::GetRoot<Table>(bytes.data()) : nullptr;
}

}  // namespace kt::wire
