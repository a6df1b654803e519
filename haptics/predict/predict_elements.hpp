#pragma once
// What a mesh and its elements cannot do: keep their volume without locking, be crushed, be thin.
#include <optional>

#include "core/body/deformable_model.hpp"
#include "haptics/predict/predict.hpp"

namespace kt {

/// The body's thinnest extent over its mean edge: how many elements lie across it. 0 without tetrahedra. Of a lattice
/// what is thin all over counts, too: a bowl, a tube.
double cells_across(const Mesh& mesh);

/// How much too stiff a cantilever is, with `cells` across it and Poisson's ratio `distance` below 1/2: laws fitted to
/// the map poisson, to a fifth where they pass 1.5 (docs/stability.md). 4-node tetrahedra bend too little on any coarse
/// mesh, and less the nearer to 1/2; the springs of a network follow the solid's bulk modulus, since nothing else in
/// them can, and then are too stiff in everything else.
double tet4_stiffening(double cells, double distance);
double spring_stiffening(double cells, double distance);

/// The distance at which tet4_stiffening() reaches `factor`; NaN when it is above at any.
double tet4_distance(double cells, double factor);

/// None when the model bends within a factor of 1.5 of what its material says.
std::optional<Prediction> predict_locking(const DeformableModel& model, const std::string& element, double poisson);

/// None when a body of this model (msd, or the name of a material) comes back after being crushed to the share
/// `stretch` of its height (below 0: inside out).
std::optional<Prediction> predict_collapse(const std::string& model, double stretch);

}  // namespace kt
