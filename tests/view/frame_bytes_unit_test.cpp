#include "view/frame_bytes.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "core/body/mesh.hpp"

namespace kt {
namespace {

/// As page/frame.js reads: one field after another.
struct Reader {
  const std::string& bytes;
  std::size_t at = 0;
  template <class T>
  T take() {
    T out;
    std::memcpy(&out, bytes.data() + at, sizeof out);
    at += sizeof out;
    return out;
  }
  Vec3 vec3() {
    const float x = take<float>(), y = take<float>(), z = take<float>();
    return {x, y, z};
  }
};

Mesh square() {
  Mesh mesh;
  mesh.x.resize(15);
  mesh.x << 9, 9, 9, 0, 0, 0, 0.1, 0, 0, 0.1, 0.1, 0.02, 0, 0.1, 0;  // node 0 lies inside, on no triangle
  mesh.triangles = {{1, 2, 3}, {1, 3, 4}};
  return mesh;
}

Surface surface_of(const Mesh& mesh) {
  Surface out;
  out.triangles = mesh.triangles;
  return out;
}

TEST(BodyShape, HasTheNodesOfTheSurfaceOnly) {
  const BodyShape shape = make_body_shape(surface_of(square()), 5, {1, 4});
  EXPECT_EQ(shape.nodes, (std::vector<int>{1, 2, 3, 4}));
  EXPECT_EQ(shape.place[0], -1);
  EXPECT_EQ(shape.triangles[1], (Triangle{0, 2, 3}));
}

TEST(FrameBytes, PositionsAreWithinHalfAStep) {
  const Mesh mesh = square();
  const BodyShape shape = make_body_shape(surface_of(mesh), 5, {});
  const PackedPositions packed = pack_positions(mesh.x, shape.nodes);
  for (std::size_t k = 0; k < shape.nodes.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) {
      const double shown = packed.least[c] + static_cast<double>(packed.step[c]) * packed.x[3 * k + c];
      const double edge = c < 2 ? 0.1 : 0.02;
      EXPECT_NEAR(shown, mesh.x[3 * shape.nodes[k] + static_cast<int>(c)], 0.51 * edge / 65535 + 1e-8);
    }
}

TEST(FrameBytes, AFrameReadsBack) {
  const Mesh mesh = square();
  const BodyShape shape = make_body_shape(surface_of(mesh), 5, {});
  const PackedPositions packed = pack_positions(mesh.x, shape.nodes);
  LocalFrame tool;
  tool.pose.x = {1, 2, 3};
  tool.force = {0, 0, 0.5};
  tool.normal = {0, 0, 1};
  tool.f_n = 0.5;
  tool.f_t = 0.25;
  tool.mode = ContactMode::frictional_slide;
  tool.flags = kStaleModel;
  const std::vector<TickForce> ticks = {{1, 2, ContactMode::stick}, {3, 4, ContactMode::free}};
  const std::string bytes = frame_bytes({0.125, 42, 99.5, 7, {4, 5, 6}, std::span(&tool, 1), ticks, &packed});
  Reader r{bytes};
  EXPECT_EQ(r.take<std::uint32_t>(), 1u);
  EXPECT_EQ(r.take<std::uint32_t>(), 42u);
  EXPECT_EQ(r.take<double>(), 99.5);
  EXPECT_EQ(r.take<double>(), 0.125);
  EXPECT_EQ(r.take<std::uint32_t>(), 7u);
  EXPECT_EQ(r.vec3(), Vec3(4, 5, 6));
  EXPECT_EQ(r.take<std::uint32_t>(), 1u);  // tools
  EXPECT_EQ(r.vec3(), Vec3(1, 2, 3));
  for (const float part : {0.f, 0.f, 0.f, 1.f}) EXPECT_EQ(r.take<float>(), part);
  EXPECT_EQ(r.vec3(), Vec3(0, 0, 0.5));
  EXPECT_EQ(r.vec3(), Vec3(0, 0, 1));
  r.vec3();
  EXPECT_EQ(r.take<float>(), 0.5f);
  EXPECT_EQ(r.take<float>(), 0.25f);
  EXPECT_EQ(r.take<std::uint32_t>(), 3u);
  EXPECT_EQ(r.take<std::uint32_t>(), static_cast<std::uint32_t>(kStaleModel));
  EXPECT_EQ(r.take<std::uint32_t>(), 2u);  // ticks
  for (const float part : {1.f, 2.f, 1.f, 3.f, 4.f, 0.f}) EXPECT_EQ(r.take<float>(), part);
  r.at += 24;
  EXPECT_EQ(r.take<std::uint32_t>(), 12u);
  EXPECT_EQ(bytes.size() - r.at, 24u);
}

TEST(FrameBytes, ErrorsOfNodesInsideAreLeftOut) {
  const BodyShape shape = make_body_shape(surface_of(square()), 5, {1, 4});
  const std::string bytes =
      refresh_bytes({3, {1}, {0, 4}, {0.5, 0.25}, {{7, {0.5, 0.25, 0.25}}, {7, {0, 1, 0}}}, {{0, 1}}}, shape);
  Reader r{bytes};
  EXPECT_EQ(r.take<std::uint32_t>(), 3u);
  EXPECT_EQ(r.take<std::uint32_t>(), 3u);
  EXPECT_EQ(r.take<std::uint32_t>(), 1u);
  EXPECT_EQ(r.take<std::uint32_t>(), 1u);
  EXPECT_EQ(r.take<std::uint32_t>(), 1u);
  EXPECT_EQ(r.take<std::uint32_t>(), 3u);
  EXPECT_EQ(r.take<float>(), 0.25f);
  EXPECT_EQ(r.take<std::uint32_t>(), 2u);  // of refined cells
  for (const auto& [b, c] : {std::pair(0.25f, 0.25f), {1.f, 0.f}}) {
    EXPECT_EQ(r.take<std::uint32_t>(), 7u);
    EXPECT_EQ(r.take<float>(), b);
    EXPECT_EQ(r.take<float>(), c);
  }
  EXPECT_EQ(r.take<std::uint32_t>(), 1u);
  EXPECT_EQ(r.take<std::uint32_t>(), 0u);
  EXPECT_EQ(r.take<std::uint32_t>(), 1u);
  EXPECT_EQ(r.at, bytes.size());
}

}  // namespace
}  // namespace kt
