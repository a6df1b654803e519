#include "collision/held/surface_motion.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "collision/impact/feature_toi.hpp"
#include "core/base/parallel.hpp"

namespace kt {
namespace {

constexpr int kChunk = 512;  // pairs that one thread takes at a time

}  // namespace

double first_meeting(std::span<const SurfacePair> pairs, const VectorX& x_t0, const VectorX& x_t1) {
  const int count = static_cast<int>(pairs.size()), chunks = (count + kChunk - 1) / kChunk;
  std::vector<double> first(static_cast<std::size_t>(chunks), std::numeric_limits<double>::infinity());
  parallel_for(chunks, [&](int chunk) {
    for (const SurfacePair& pair : pairs.subspan(chunk * kChunk, std::min(kChunk, count - chunk * kChunk))) {
      Vec3 t0[4], t1[4];
      for (int i = 0; i < 4; ++i) {
        t0[i] = node(x_t0, pair.nodes[i]);
        t1[i] = node(x_t1, pair.nodes[i]);
      }
      const bool edges = pair.kind == SurfacePair::Kind::edge_edge;
      const ToiResult at =
          edges ? edge_edge_toi(t0, t1, ToiMode::conservative) : vertex_face_toi(t0, t1, ToiMode::conservative);
      if (at.is_contact()) first[chunk] = std::min(first[chunk], at.toi);
      if (at.status == ToiResult::Status::invalid_input) first[chunk] = 0;
    }
  });
  return first.empty() ? std::numeric_limits<double>::infinity() : *std::ranges::min_element(first);
}

}  // namespace kt
