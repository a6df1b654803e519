#pragma once
// What keeps a network of springs from turning inside out. Lengths do not tell a tetrahedron from its mirror image, so
// springs let it pass through flat, and stay. One that has lost most of its volume is therefore pushed back by its
// signed volume (Teschner et al. 2004), as stiffly as its edges are along its height (Molino et al. 2003). The others
// feel nothing.
#include "core/body/mesh.hpp"
#include "models/msd/springs.hpp"

namespace kt {

/// Energy c/2 (least - V)^2 while the signed volume V < least.
struct VolumeGuard {
  Tetrahedron nodes{};   ///< right-handed at rest
  double least = 0;      ///< [m^3]
  double stiffness = 0;  ///< c [N/m^5]
};

/// Of every tetrahedron with a volume. `share` of its volume at rest is the least; 0: none at all.
std::vector<VolumeGuard> make_volume_guards(const Mesh& mesh, const std::vector<Spring>& springs, double share);

/// Forces on its four nodes [N] as columns, and their derivative by the nodes' places (12 x 12) [N/m].
struct GuardForce {
  Eigen::Matrix<double, 3, 4> force = Eigen::Matrix<double, 3, 4>::Zero();
  Eigen::Matrix<double, 12, 12> dfdx = Eigen::Matrix<double, 12, 12>::Zero();
};

/// False, and nothing is touched, while the tetrahedron has volume enough.
bool guard_force(const VolumeGuard& guard, const VectorX& x, Eigen::Matrix<double, 3, 4>& force);

/// The derivative too. @param definite  without its part of either sign
bool guard_force(const VolumeGuard& guard, const VectorX& x, bool definite, GuardForce& out);

}  // namespace kt
