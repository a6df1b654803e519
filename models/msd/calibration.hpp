#pragma once
// Spring constants that make a network behave like an isotropic solid; docs/method.md#1-the-body-12.
#include "models/msd/springs.hpp"

namespace kt {

/// How well the network matches. A network of central forces can only reproduce Poisson ratios near 1/4.
struct Calibration {
  double residual = 0;     ///< || C_network - C_solid || / || C_solid ||, 6x6 elasticity tensors
  double young_error = 0;  ///< relative, mean of the three uniaxial tests
  double shear_error = 0;  ///< relative, mean of the three shear tests
};

/// Sets the stiffness of every spring. Two shapes are tried: the linear FEM stiffness along each edge, k = -d^T K_ij d
/// (the least-squares projection, edge by edge), and the volume around the edge by its length squared (Van Gelder
/// 1998). Each is scaled by least squares of the network's own elasticity tensor against the solid's, measured by
/// imposing the six unit strains on the surface nodes and letting the inner nodes relax; the smaller residual wins.
/// @param young [Pa]  @param poisson in (-1, 0.5)
/// @param share  of each tetrahedron, how much of it is material; empty: all
Calibration calibrate_springs(const Mesh& mesh, double young, double poisson, std::vector<Spring>& springs,
                              const std::vector<double>& share = {});

/// Elasticity tensor (6x6, engineering shear strains xx yy zz yz xz xy) [Pa] of a network:
/// energies of the six unit strains imposed on the surface nodes, inner nodes relaxed.
Eigen::Matrix<double, 6, 6> network_elasticity(const Mesh& mesh, const std::vector<Spring>& springs,
                                               const std::vector<double>& share = {});

/// Elasticity tensor of the isotropic solid, the same notation.
Eigen::Matrix<double, 6, 6> isotropic_elasticity(double young, double poisson);

struct IsotropicSolid {
  double young = 0, poisson = 0;  ///< [Pa], [-]
};
/// The one with the same mean stiffness against compression and against shear, over all directions (Voigt's mean).
IsotropicSolid nearest_isotropic(const Eigen::Matrix<double, 6, 6>& elasticity);

}  // namespace kt
