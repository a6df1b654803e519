// Nothing goes through a surface unseen: shots at faces, edges and vertices of resting, moving and deforming surfaces,
// with every broad phase. bench/tunnelling_table shoots more, at more meshes. KT_SHOTS=1000000 shoots more here.
#include <gtest/gtest.h>

#include "tests/io/mesh_samples.hpp"
#include "tests/support/environment.hpp"
#include "tests/support/shooting.hpp"
#include "tests/support/triangle_indices.hpp"

namespace kt {
namespace {

/// The project's meshes with a largest side of 0.1 m, and a sheet of one layer.
std::vector<Mesh> targets() {
  std::vector<Mesh> out{sheet(10, 10, 0.01)};
  for (const std::string& file : own_meshes()) {
    Mesh mesh = load_mesh(file);
    mesh.x *= 0.1 / bounds(mesh).size().maxCoeff();
    out.push_back(std::move(mesh));
  }
  return out;
}

class EveryTriangleIndexUnderFire : public testing::TestWithParam<std::string> {};

TEST_P(EveryTriangleIndexUnderFire, LetsNoShotThroughUnseen) {
  constexpr long kSalvo = 50;
  const std::vector<Mesh> meshes = targets();
  const long salvos = number_from_environment("KT_SHOTS", 4000) / (3 * kSalvo * static_cast<long>(meshes.size())) + 1;
  Sample s{std::mt19937_64(51)};
  ShotCount all;
  for (const Mesh& mesh : meshes) {
    const auto index = make_triangle_index(GetParam());
    index->build(mesh.triangles, mesh.x);
    for (long i = 0; i < 3 * salvos; ++i) {
      const SurfaceTicks surface = random_ticks(s, mesh.triangles, mesh.x, static_cast<SurfaceMotion>(i % 3));
      std::vector<Shot> shots;
      for (long k = 0; k < kSalvo; ++k) shots.push_back(random_shot(s, surface));
      for (const ShotResult& result : shoot(surface, shots, *index)) {
        all.add(result.count);
        const bool is_seen = !result.count.leaks && !result.count.late && !result.count.apart;
        ASSERT_TRUE(is_seen) << "leak " << result.count.leaks << ", late " << result.count.late << ", apart "
                             << result.count.gap << ": " << to_text(result.query);
      }
    }
  }
  std::printf("%ld shots, %ld go through, %ld hits, %ld from behind, %ld start inside, largest gap %.2f of allowed\n",
              all.shots, all.through, all.hits, all.behind, all.inside, all.gap);
  EXPECT_GT(all.through, all.shots / 2);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryTriangleIndexUnderFire, testing::ValuesIn(available_triangle_indices()),
                         [](const auto& backend) { return backend.param; });

}  // namespace
}  // namespace kt
