// A setting changes a run, or the run says that it does nothing: each key by itself, over models, laws and methods.
#include "haptics/setup/unused_settings.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

constexpr const char* kSettings[] = {"object.gravity=[0,0,-3]",
                                     "object.model.material=stvk",
                                     "object.model.element=tet10",
                                     "object.model.consistent_mass=true",
                                     "object.model.young=1.5e4",
                                     "object.model.poisson=0.2",
                                     "object.model.density=1500",
                                     "object.model.damping.mass=9",
                                     "object.model.damping.stiffness=4e-3",
                                     "object.model.damping.law=rayleigh",
                                     "object.model.damper=0.01",
                                     "object.model.least_volume=0.95",
                                     "tool.radius=0.003",
                                     "tool.length=0.03",
                                     "tool.size=0.01",
                                     "tool.scale=0.5",
                                     "tool.turn=[0.1,0.2,0.3]",
                                     "tool.spin=[1,2,3]",
                                     "contact.mu_static=0.8",
                                     "contact.mu_kinetic=0.3",
                                     "contact.metric=mass",
                                     "contact.penalty.stiffness=150",
                                     "contact.penalty.damping=0.1",
                                     "contact.stribeck=0.02",
                                     "contact.surface_levels=1",
                                     "contact.ridge_deg=10",
                                     R"(contact.regions=[{"box": [[0, 0, 0], [1, 1, 1]], "mu": 0.2}])",
                                     "global.rate_hz=20",
                                     "global.integrator=sdirk2",
                                     "global.look_ahead=false",
                                     "local.rate_hz=500",
                                     "local.rings=2",
                                     "local.budget_us=20",
                                     "local.catch_up=false",
                                     "local.blend_ms=3",
                                     "local.fineness=1",
                                     "local.refine_nodes=300",
                                     "local.passivity_damping=3",
                                     "link.latency_ms=7",
                                     "link.loss=0.5",
                                     "seed=9"};

/// 6 x 4 x 2 cubes of 1 cm, six tetrahedra each (Kuhn): a run takes a tenth of a second.
Mesh small_block() {
  constexpr int kCells[3] = {6, 4, 2};
  constexpr double kEdge = 0.01;  // [m]
  Mesh out;
  const auto number = [&](const std::array<int, 3>& at) {
    return (at[2] * (kCells[1] + 1) + at[1]) * (kCells[0] + 1) + at[0];
  };
  std::vector<double> x;
  std::array<int, 3> at{};
  for (at[2] = 0; at[2] <= kCells[2]; ++at[2])
    for (at[1] = 0; at[1] <= kCells[1]; ++at[1])
      for (at[0] = 0; at[0] <= kCells[0]; ++at[0])
        for (int c = 0; c < 3; ++c) x.push_back(kEdge * at[c]);
  out.x = Eigen::Map<VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
  for (int cell = 0; cell < kCells[0] * kCells[1] * kCells[2]; ++cell) {
    std::array<int, 3> order{0, 1, 2};
    do {
      std::array<int, 3> corner{cell % kCells[0], cell / kCells[0] % kCells[1], cell / (kCells[0] * kCells[1])};
      Tetrahedron t{};
      for (int i = 0; i < 4; ++i) {
        t[i] = number(corner);
        if (i < 3) ++corner[order[i]];
      }
      if (tetrahedron_volume(out.x, t) < 0) std::swap(t[2], t[3]);
      out.tetrahedra.push_back(t);
    } while (std::next_permutation(order.begin(), order.end()));
  }
  out.triangles = boundary_triangles(out.tetrahedra);
  return out;
}

Scene changed(const Scene& base, const std::string& setting) { return parse_scene(to_json(base), {setting}); }

struct Told {
  std::uint64_t hash = 0;
  bool does_nothing = false;  ///< the run says so of the setting
};

Told run(const Scene& scene, const std::string& key) {
  SessionOptions options;
  options.check_contacts = false;
  const SessionResult result = Session(scene, small_block()).run(options);
  const auto names_it = [&](const std::string& w) {
    return w.starts_with(key + " ") && w.find("does nothing") != w.npos;
  };
  return {result.hash, std::ranges::any_of(lines(result.findings), names_it)};
}

void check(const std::string& name, const Scene& base) {
  const std::uint64_t plain = run(base, "").hash;
  for (const std::string setting : kSettings) {
    const std::string key = setting.substr(0, setting.find('='));
    const auto told = [&]() -> std::optional<Told> {
      try {
        return run(changed(base, setting), key);
      } catch (const InputError&) {
        return {};  // refused
      } catch (const RunError&) {
        return {};  // read, and no good
      }
    }();
    if (told) {
      EXPECT_EQ(told->hash == plain, told->does_nothing) << name << ": " << setting;
    }
  }
}

Scene base_scene(const std::string& shape = "sphere") {
  Scene scene = small_scene(shape);
  scene.duration = 0.2;
  scene.tool.path.press_drag->press_time = 0.06;
  scene.global.early_refresh = false;
  return scene;
}

TEST(UnusedSettings, OfSpringsAreTold) {
  check("springs", base_scene());
  Scene given = base_scene();
  given.object.model.stiffness = 2;
  given.object.model.calibrate = false;
  given.object.model.damper = 1e-3;
  check("given springs", given);
}

TEST(UnusedSettings, OfElementsAreTold) {
  Scene scene = base_scene();
  scene.object.model.type = "fem";
  check("elements", scene);
}

TEST(UnusedSettings, OfLawsAndMethodsAreTold) {
  Scene scene = base_scene("point");
  scene.local.reducer = "wall";
  scene.local.integrator = "implicit_euler";
  for (const char* law : {"paper_slide", "paper_stick", "paper_stick_slip"}) {
    scene.contact.law = law;
    check(law, scene);
  }
  for (const char* method : {"hold", "frozen", "penalty"}) {
    scene = base_scene();
    scene.local.method = method;
    check(method, scene);
  }
}

TEST(UnusedSettings, OfADefaultSceneThereAreNone) {
  EXPECT_TRUE(unused_settings(default_scene()).empty());
  Scene scene = default_scene();
  scene.object.model.calibrate = false;
  EXPECT_EQ(unused_settings(scene).size(), 1u) << "springs that are neither given nor calibrated";
  scene = default_scene();
  scene.link.type = "thread";
  scene.link.latency_ms = 5;
  scene.link.loss = 0.1;
  EXPECT_EQ(unused_settings(scene).size(), 2u);
  scene = default_scene();
  scene.global.integrator = "symplectic_euler";
  scene.global.solver = "pcg";
  EXPECT_EQ(unused_settings(scene).at(0).where, "global.solver");
  EXPECT_EQ(unused_settings(scene).at(0).line(),
            "global.solver = pcg does nothing: global.integrator is symplectic_euler; it solves nothing");
}

}  // namespace
}  // namespace kt
