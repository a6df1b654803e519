// Times of impact (collision/impact/feature_toi.hpp) of whatever numbers a fuzzer makes up: what must hold without
// knowing the answer, and, of whole numbers, at the eighths of the step, where the answer is exact.
//
//     scripts/fuzz toi_fuzz
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "collision/impact/feature_toi.hpp"
#include "tests/fuzz/exact_touch.hpp"
#include "tests/fuzz/numbers.hpp"

namespace {

using kt::ToiMode;
using kt::ToiResult;
using kt::Vec3;
using kt::fuzz::Numbers;
using kt::fuzz::Whole;

struct Motion {
  bool is_face;
  Vec3 x[8];  ///< at the start, then at the end
};

void require(bool holds, const char* what, const Motion& m) {
  if (!holds) std::fprintf(stderr, "%s, start and end:\n", m.is_face ? "vertex and face" : "two edges");
  kt::fuzz::require(holds, what, m.x);
}

ToiResult toi_of(const Motion& m, ToiMode mode) {
  Vec3 t0[4], t1[4];
  std::copy_n(m.x, 4, t0);
  std::copy_n(m.x + 4, 4, t1);
  return m.is_face ? kt::vertex_face_toi(t0, t1, mode) : kt::edge_edge_toi(t0, t1, mode);
}

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

void check_one(const ToiResult& r, const Motion& m) {
  require(r.toi >= 0 && r.toi <= 1 && r.toi_upper >= r.toi && r.toi_upper <= 1, "0 <= toi <= toi_upper <= 1", m);
  const bool is_valid = r.status != ToiResult::Status::invalid_input;
  double largest = 0;
  bool is_finite = true;
  for (const Vec3& p : m.x) {
    is_finite = is_finite && p.allFinite();
    largest = std::max(largest, p.lpNorm<Eigen::Infinity>());
  }
  const bool in_range = largest == 0 || (largest >= kt::kSmallestExtent && largest <= kt::kLargestCoordinate);
  require(is_valid == (is_finite && in_range), "invalid is what is not finite or out of range", m);
  require(r.is_contact() || !r.is_certain, "only a contact is certain", m);
  if (!r.is_contact()) return;
  require(std::abs(r.normal.norm() - 1) < 1e-9, "the normal is a unit vector", m);
  for (const double w : r.weight) require(w >= 0 && w <= 1, "weights are 0 .. 1", m);
  const double first = m.is_face ? r.weight[0] : r.weight[0] + r.weight[1];
  const double second = r.weight[2] + r.weight[3] + (m.is_face ? r.weight[1] : 0);
  require(std::abs(first - 1) < 1e-12 && std::abs(second - 1) < 1e-12, "weights of each feature sum up to 1", m);
  require(r.status != ToiResult::Status::already_inside || r.toi == 0, "already inside is at 0", m);
}

/// The same motion with its points in another order; all orders that name the same two features.
Motion reordered(const Motion& m, unsigned which) {
  constexpr int kFace[6][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 1, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {0, 3, 2, 1}};
  constexpr int kEdges[8][4] = {{0, 1, 2, 3}, {1, 0, 2, 3}, {0, 1, 3, 2}, {1, 0, 3, 2},
                                {2, 3, 0, 1}, {3, 2, 0, 1}, {2, 3, 1, 0}, {3, 2, 1, 0}};
  const int(&order)[4] = m.is_face ? kFace[which % 6] : kEdges[which % 8];
  Motion out = m;
  for (int i = 0; i < 8; ++i) out.x[i] = m.x[i / 4 * 4 + order[i % 4]];
  return out;
}

void check_order(const ToiResult& here, const Motion& m, ToiMode mode, unsigned which) {
  const ToiResult there = toi_of(reordered(m, which), mode);
  require(here.status == there.status && here.is_certain == there.is_certain && same_bits(here.toi, there.toi) &&
              same_bits(here.toi_upper, there.toi_upper),
          "the order of the points does not matter", m);
  // Which way it points is arbitrary where the motion does not tell.
  require(there.normal == here.normal || there.normal == -here.normal, "nor does it for the normal's line", m);
}

void check_backwards(const ToiResult& here, const Motion& m, ToiMode mode) {
  Motion backwards = m;
  std::rotate(backwards.x, backwards.x + 4, backwards.x + 8);
  const ToiResult back = toi_of(backwards, mode);
  if (!here.is_certain) return;
  require(back.is_contact(), "what certainly touches does so backwards in time", m);
  require(back.toi <= 1 - here.toi, "nor is it late then", m);
}

/// The first eighth of the step at which the features touch, exactly; 9 when at none. Of whole numbers only.
int first_eighth(const Motion& m, int scale) {
  for (int k = 0; k <= 8; ++k) {
    Whole p[4];
    for (int i = 0; i < 4; ++i)
      for (int c = 0; c < 3; ++c)
        p[i][c] = static_cast<std::int64_t>(std::ldexp((8 - k) * m.x[i][c] + k * m.x[i + 4][c], -scale));
    if (m.is_face ? kt::fuzz::point_touches_triangle(p[0], p[1], p[2], p[3])
                  : kt::fuzz::segments_touch(p[0], p[1], p[2], p[3]))
      return k;
  }
  return 9;
}

}  // namespace

/// First byte: which features, and which of the dearer checks. Second: the kind of the numbers.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  const unsigned choice = data[0];
  Numbers numbers({data + 1, size - 1});
  Motion m{(choice & 1) == 0, {}};
  for (Vec3& p : m.x) p = numbers.point();

  const ToiResult conservative = toi_of(m, ToiMode::conservative), exact = toi_of(m, ToiMode::exact);
  for (const ToiResult& r : {conservative, exact}) check_one(r, m);
  require(!exact.is_contact() || conservative.is_contact(), "what exact mode finds the conservative one finds", m);
  require(!conservative.is_certain || exact.is_contact(), "what is certain is found in exact mode", m);
  require(!conservative.is_contact() || !exact.is_contact() || conservative.toi <= exact.toi_upper, "no time is late",
          m);
  const bool in_exact = (choice & 2) != 0;
  check_order(in_exact ? exact : conservative, m, in_exact ? ToiMode::exact : ToiMode::conservative, choice >> 2);
  check_backwards(in_exact ? exact : conservative, m, in_exact ? ToiMode::exact : ToiMode::conservative);
  if (!numbers.is_whole()) return 0;
  if (const int k = first_eighth(m, numbers.scale()); k <= 8)
    for (const ToiResult& r : {conservative, exact}) {
      require(r.is_contact(), "no touch is missed", m);
      require(r.toi <= k / 8.0, "no touch is found late", m);
    }
  return 0;
}
