#include "view/frame_bytes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace kt {
namespace {

static_assert(std::endian::native == std::endian::little, "pages read little-endian numbers");

class ByteWriter {
 public:
  explicit ByteWriter(std::uint32_t type) { put(type); }
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    out_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put(const Vec3& v) {
    for (int i = 0; i < 3; ++i) put(static_cast<float>(v[i]));
  }
  void put(const Quaternion& r) {
    for (const double part : {r.x(), r.y(), r.z(), r.w()}) put(static_cast<float>(part));
  }
  template <class T>
  void put_all(const std::vector<T>& values) {
    out_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  void count(std::size_t size) { put(static_cast<std::uint32_t>(size)); }
  std::string take() { return std::move(out_); }

 private:
  std::string out_;
};

void put_ticks(ByteWriter& out, std::span<const TickForce> ticks) {
  out.count(ticks.size());
  for (const TickForce& tick : ticks) {
    out.put(tick.f_n);
    out.put(tick.f_t);
    out.put(static_cast<float>(tick.mode));
  }
}

}  // namespace

PackedPositions pack_positions(const VectorX& x, const std::vector<int>& nodes) {
  PackedPositions out;
  Vec3 least = Vec3::Constant(std::numeric_limits<double>::infinity()), most = -least;
  for (const int i : nodes) {
    least = least.cwiseMin(Vec3(node(x, i)));
    most = most.cwiseMax(Vec3(node(x, i)));
  }
  constexpr double kSteps = 65535;
  for (int c = 0; c < 3; ++c) {
    // A step a little larger than needed: rounded to a float it must still reach the far side.
    out.least[static_cast<std::size_t>(c)] = static_cast<float>(least[c]);
    out.step[static_cast<std::size_t>(c)] =
        static_cast<float>(std::max(1e-12, (most[c] - least[c]) / kSteps * (1 + 1e-6)));
  }
  out.x.reserve(3 * nodes.size());
  for (const int i : nodes)
    for (std::size_t c = 0; c < 3; ++c) {
      const double steps = (x[3 * i + static_cast<int>(c)] - out.least[c]) / out.step[c];
      out.x.push_back(static_cast<std::uint16_t>(std::lround(std::clamp(steps, 0.0, kSteps))));
    }
  return out;
}

std::string frame_bytes(const PageFrame& frame) {
  ByteWriter out(1);
  out.put(frame.echo);
  out.put(frame.stamp);
  out.put(frame.t);
  out.count(static_cast<std::size_t>(frame.refreshes));
  out.put(frame.target);
  out.count(frame.tools.size());
  for (const LocalFrame& tool : frame.tools) {
    out.put(tool.pose.x);
    out.put(tool.pose.r);
    out.put(tool.force);
    out.put(tool.normal);
    out.put(tool.point);
    out.put(static_cast<float>(tool.f_n));
    out.put(static_cast<float>(tool.f_t));
    out.put(static_cast<std::uint32_t>(tool.mode));
    out.put(static_cast<std::uint32_t>(tool.flags));
  }
  put_ticks(out, frame.ticks);
  for (const float v : frame.positions->least) out.put(v);
  for (const float v : frame.positions->step) out.put(v);
  out.count(frame.positions->x.size());
  out.put_all(frame.positions->x);
  return out.take();
}

std::string body_bytes(const BodyShape& shape, const VectorX& x_rest) {
  ByteWriter out(2);
  out.count(shape.nodes.size());
  for (const int i : shape.nodes) out.put(Vec3(node(x_rest, i)));
  out.count(shape.triangles.size());
  for (const Triangle& t : shape.triangles)
    for (const int corner : t) out.put(static_cast<std::uint32_t>(corner));
  out.count(shape.fixed.size());
  for (const int i : shape.fixed) out.put(static_cast<std::uint32_t>(i));
  return out.take();
}

std::string refresh_bytes(const RefreshPicture& picture, const BodyShape& shape) {
  ByteWriter out(3);
  out.count(static_cast<std::size_t>(picture.refreshes));
  out.count(picture.triangles.size());
  for (const int t : picture.triangles) out.put(static_cast<std::uint32_t>(t));
  std::vector<std::uint32_t> places;
  std::vector<float> distances;
  for (std::size_t k = 0; k < picture.nodes.size(); ++k)
    if (const int place = shape.place[static_cast<std::size_t>(picture.nodes[k])]; place >= 0) {
      places.push_back(static_cast<std::uint32_t>(place));
      distances.push_back(static_cast<float>(picture.distance[k]));
    }
  out.count(places.size());
  out.put_all(places);
  out.put_all(distances);
  out.count(picture.refined.size());
  for (const SurfacePlace& place : picture.refined) {
    out.put(static_cast<std::uint32_t>(std::max(place.triangle, 0)));
    out.put(static_cast<float>(place.weights[1]));
    out.put(static_cast<float>(place.weights[2]));
  }
  out.count(picture.refined_edges.size());
  for (const auto& [a, b] : picture.refined_edges) {
    out.put(static_cast<std::uint32_t>(a));
    out.put(static_cast<std::uint32_t>(b));
  }
  return out.take();
}

std::string trace_bytes(double h, std::span<const TickForce> ticks) {
  ByteWriter out(4);
  out.put(h);
  put_ticks(out, ticks);
  return out.take();
}

}  // namespace kt
