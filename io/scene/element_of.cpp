// Without the reading of JSON: a body is made without it, too.
#include "io/scene/scene.hpp"

namespace kt {

std::string element_of(const SceneObject& object) {
  constexpr double kLocks = 0.45;  // four-node cells above it (the map poisson of `kilotouch stability`)
  const SceneModel& m = object.model;
  if (m.element != "auto") return m.element;
  return object.body == "lattice" && m.type == "fem" && m.poisson > kLocks ? "tet10" : "tet4";
}

}  // namespace kt
