#pragma once
// The small bodies that maps are made with, and what they start from.
#include <memory>
#include <string>
#include <vector>

#include "models/model.hpp"

namespace kt {

/// A model, and for finite elements its material.
struct ModelChoice {
  std::string type, material;
  std::string name() const { return material.empty() ? type : material; }
};

/// msd, and fem with every material of the table.
std::vector<ModelChoice> all_models();

/// The mesh, clamped where z is lowest.
std::unique_ptr<DeformableModel> clamped(const ModelChoice& choice, Mesh mesh, ModelOptions options);

/// Small motions in all directions, without symmetry and the same on every machine: entries in [-size, size], zero for
/// fixed nodes.
VectorX shaken_positions(const DeformableModel& model, double size, unsigned seed = 1);

/// A vibration of the linearized body at rest.
struct Vibration {
  double omega = 0;  ///< [rad/s]
  VectorX shape;     ///< (3n), with shape' M shape = 1; zero for fixed nodes
};

/// The slowest vibration; dense, for small bodies.
Vibration slowest_vibration(const DeformableModel& model);

}  // namespace kt
