#pragma once
// A material whose stress and stiffness are written for lanes, and compiled for several vector widths.
#include "models/fem/material.hpp"

namespace kt {

/// What Material::add_lane_stiffness is given.
struct LaneStiffness {
  const LaneMat3& F;
  bool definite;
  std::span<const LaneVec3> g;
  const Lanes& volume;
  std::span<LaneMat3> blocks;
};

/// @tparam M  has stress_of(F) for one F and for lanes, and add_stiffness_to(LaneStiffness)
template <class M>
class LaneMaterial : public Material {
 public:
  Mat3 stress(const Mat3& F) const final { return self().stress_of(F); }
  LaneMat3 lane_stress(const LaneMat3& F) const final {
    LaneMat3 P;
    find_stress(self(), F, P);
    return P;
  }
  void add_lane_stiffness(const LaneMat3& F, bool definite, std::span<const LaneVec3> g, const Lanes& volume,
                          std::span<LaneMat3> blocks) const final {
    add_stiffness(self(), {F, definite, g, volume, blocks});
  }

 private:
  const M& self() const { return static_cast<const M&>(*this); }
  KT_LANES static void find_stress(const M& m, const LaneMat3& F, LaneMat3& P) { P = m.stress_of(F); }
  KT_LANES static void add_stiffness(const M& m, const LaneStiffness& s) { m.add_stiffness_to(s); }
};

}  // namespace kt
