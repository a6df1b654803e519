// Times of impact of whatever 24 numbers a fuzzer makes up: what must hold without knowing the answer.
//
//     CC=clang CXX=clang++ cmake -B build/fuzz -DKT_BUILD_FUZZERS=ON && cmake --build build/fuzz --target toi_fuzz
//     build/fuzz/tests/fuzz/toi_fuzz -max_total_time=60
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "collision/toi.hpp"

namespace {

using kt::ToiMode;
using kt::ToiResult;
using kt::Vec3;

constexpr int kNumbers = 24;

struct Motion {
  Vec3 t0[4], t1[4];
};

void require(bool holds, const char* what, const Motion& m) {
  if (holds) return;
  std::fprintf(stderr, "not so: %s\n", what);
  for (const auto* ends : {&m.t0, &m.t1})
    for (const Vec3& p : *ends) std::fprintf(stderr, "%a %a %a\n", p[0], p[1], p[2]);
  std::abort();
}

/// First byte: numbers as they are, small whole ones, or such with noise in the last place; and a scale.
Motion motion_from(const std::uint8_t* data, std::size_t size) {
  double x[kNumbers] = {};
  const int kind = data[0] % 3, scale = data[0] / 3 - 42;
  const std::uint8_t* bytes = data + 1;
  const std::size_t left = size - 1;
  for (std::size_t i = 0; i < kNumbers; ++i) {
    if (kind == 0) {
      if (8 * i + 8 <= left) std::memcpy(&x[i], bytes + 8 * i, 8);
      continue;
    }
    if (i >= left) break;
    const int digit = static_cast<std::int8_t>(bytes[i]);
    x[i] = std::ldexp(digit >> 4, scale);
    if (kind == 2 && (digit & 15) < 4) x[i] = std::nextafter(x[i], digit & 1 ? 1e300 : -1e300);
  }
  Motion m;
  for (int i = 0; i < 4; ++i) {
    m.t0[i] = Vec3(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
    m.t1[i] = Vec3(x[12 + 3 * i], x[13 + 3 * i], x[14 + 3 * i]);
  }
  return m;
}

ToiResult toi_of(bool is_face, const Motion& m, ToiMode mode) {
  return is_face ? kt::vertex_face_toi(m.t0, m.t1, mode) : kt::edge_edge_toi(m.t0, m.t1, mode);
}

void check_one(const ToiResult& r, const Motion& m) {
  require(r.toi >= 0 && r.toi <= 1 && r.toi_upper >= r.toi && r.toi_upper <= 1, "0 <= toi <= toi_upper <= 1", m);
  if (!r.is_contact()) return;
  require(std::abs(r.normal.norm() - 1) < 1e-9, "the normal is a unit vector", m);
  for (const double w : r.weight) require(w >= 0 && w <= 1, "weights are 0 .. 1", m);
  require(r.status != ToiResult::Status::already_inside || r.toi == 0, "already inside is at 0", m);
}

void check(bool is_face, const Motion& m) {
  Motion turned = m, backwards;
  for (auto* ends : {&turned.t0, &turned.t1}) std::swap((*ends)[2], (*ends)[3]);
  for (int i = 0; i < 4; ++i) backwards.t0[i] = m.t1[i], backwards.t1[i] = m.t0[i];
  const ToiResult conservative = toi_of(is_face, m, ToiMode::conservative), exact = toi_of(is_face, m, ToiMode::exact);
  for (const ToiResult& r : {conservative, exact}) check_one(r, m);
  require(!exact.is_contact() || conservative.is_contact(), "what exact mode finds the conservative one finds", m);
  require(!conservative.is_certain || exact.is_contact(), "what is certain is found in exact mode", m);
  require(!conservative.is_contact() || !exact.is_contact() || conservative.toi <= exact.toi_upper, "no time is late",
          m);
  for (const ToiMode mode : {ToiMode::conservative, ToiMode::exact}) {
    const ToiResult& here = mode == ToiMode::exact ? exact : conservative;
    const ToiResult there = toi_of(is_face, turned, mode), back = toi_of(is_face, backwards, mode);
    require(here.status == there.status &&
                std::bit_cast<std::uint64_t>(here.toi) == std::bit_cast<std::uint64_t>(there.toi),
            "the order of two vertices does not matter", m);
    require(!here.is_certain || back.is_contact(), "what certainly touches does so backwards in time", m);
    require(!here.is_certain || !back.is_contact() || back.toi <= 1 - here.toi, "nor is it late then", m);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const Motion m = motion_from(data, size);
  check(true, m);
  check(false, m);
  return 0;
}
