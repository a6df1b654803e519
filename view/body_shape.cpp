#include "view/body_shape.hpp"

namespace kt {

BodyShape make_body_shape(const Surface& surface, int num_nodes, const std::vector<int>& fixed) {
  BodyShape out;
  out.place.assign(static_cast<std::size_t>(num_nodes), -1);
  for (const Triangle& t : surface.triangles) {
    Triangle own{};
    for (std::size_t c = 0; c < 3; ++c) {
      int& place = out.place[static_cast<std::size_t>(t[c])];
      if (place < 0) {
        place = static_cast<int>(out.nodes.size());
        out.nodes.push_back(t[c]);
      }
      own[c] = place;
    }
    out.triangles.push_back(own);
  }
  for (const int i : fixed)
    if (const int place = out.place[static_cast<std::size_t>(i)]; place >= 0) out.fixed.push_back(place);
  return out;
}

}  // namespace kt
