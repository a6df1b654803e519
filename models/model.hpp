#pragma once
// Makes a deformable model by name. Backends: models.def.
#include <memory>
#include <optional>

#include "core/base/backend.hpp"
#include "core/body/deformable_model.hpp"
#include "models/inclusions.hpp"

namespace kt {

/// Everything that any model may need; a model takes what it knows and rejects what contradicts it. SI units.
struct ModelOptions {
  double young = 1e4;  ///< [Pa]
  double poisson = 0.3;
  double density = 1000;                 ///< [kg/m^3]
  double damping_mass = 0;               ///< Rayleigh: f -= damping_mass M v [1/s]
  double damping_stiffness = 0;          ///< Rayleigh: damping = damping_stiffness * K [s]
  std::optional<double> stiffness = {};  ///< msd: of every spring [N/m]; absent: calibrated from young, poisson
  std::optional<double> damper = {};     ///< msd: of every spring [N s/m]; absent: damping_stiffness * stiffness
  double least_volume = 0.7;  ///< msd: share of its volume at rest below which a tetrahedron is pushed back; 0: never
  std::vector<int> fixed_nodes = {};
  std::string material = "neo_hookean";    ///< fem: models/fem/materials.def
  std::string element = "tet4";            ///< fem: tet4, tet10; hex8 in a lattice
  bool consistent_mass = false;            ///< fem: else lumped to the nodes
  bool rayleigh = false;                   ///< fem: damping_stiffness damps turning too; else the rate of strain only
  Vec3 gravity = Vec3::Zero();             ///< [m/s^2]
  std::vector<Inclusion> inclusions = {};  ///< stiffer or softer balls
};

std::vector<BackendInfo> model_backends();

/// Throws InputError for an unknown name or parameters outside their range. Fixed nodes: any order, repeats allowed.
std::unique_ptr<DeformableModel> make_model(const std::string& type, Mesh mesh, ModelOptions options);

}  // namespace kt
