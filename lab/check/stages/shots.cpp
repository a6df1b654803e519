// Tunnelling: tools shot at the surface's faces, edges and vertices, judged in 113 bits.
#include "core/base/error.hpp"
#include "lab/check/mesh_work.hpp"
#include "tests/support/shooting.hpp"

namespace kt {
namespace {

const char* name_of(ShotTarget t) { return t == ShotTarget::face ? "face" : t == ShotTarget::edge ? "edge" : "vertex"; }

}  // namespace

void check_shots(MeshWork& work, StageResult& out) {
  const int salvo = work.options.quick ? 10 : 40;
  Sample sample{std::mt19937_64(1)};
  ShotCount all;
  std::map<std::string, long> through;
  std::vector<std::string> names;
  std::vector<std::unique_ptr<TriangleIndex>> indexes;
  std::vector<TriangleIndex*> each;
  for (const BackendInfo& backend : triangle_index_backends()) {
    if (!backend.available) continue;
    names.push_back(backend.name);
    indexes.push_back(make_triangle_index(backend.name));
    indexes.back()->build(work.surface.triangles, work.surface.x);
    each.push_back(indexes.back().get());
  }
  for (const SurfaceMotion motion : {SurfaceMotion::still, SurfaceMotion::rigid, SurfaceMotion::deforming}) {
    const SurfaceTicks surface = random_ticks(sample, work.surface.triangles, work.surface.x, motion);
    std::vector<Shot> shots;
    for (int i = 0; i < salvo; ++i) shots.push_back(random_shot(sample, surface));
    const auto results = shoot(surface, shots, each);
    for (std::size_t k = 0; k < names.size(); ++k)
      for (std::size_t i = 0; i < shots.size(); ++i) {
        const ShotCount& c = results[k][i].count;
        all.add(c);
        through[name_of(shots[i].target)] += c.through;
        if (c.leaks || c.late || c.apart)
          out.lower(Verdict::fail,
                    text(names[k], ": a shot at a ", name_of(shots[i].target), " ",
                         c.leaks  ? "went through unseen"
                         : c.late ? "was reported late"
                                  : "was reported where nothing is",
                         ": ", to_text(results[k][i].query)),
                    work.in_file(shots[i].place));
      }
  }
  out.figures = {{"shots", all.shots}, {"through", all.through}, {"leaks", all.leaks},
                 {"late", all.late},   {"apart", all.apart},     {"gap", all.gap}};
  for (const auto& [target, count] : through) out.figures["through_" + target] = count;
}

}  // namespace kt
