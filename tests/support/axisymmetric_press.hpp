#pragma once
// A rigid sphere pressed without friction into a round linear-elastic layer that is bonded below and free around: an
// oracle that shares nothing with the engine. Rings of eight-node quadrilaterals, in cells that grow from the contact
// outwards; one pressure for each ring of the surface, which is never a pull, and no ring is on the average inside the
// sphere: a small linear complementarity problem, solved by its active set.
// Shapes and rings: Zienkiewicz and Taylor, The Finite Element Method, vol. 1 (axisymmetric stress analysis).

namespace kt {

struct AxisymmetricPress {
  double young = 1e4, poisson = 0.3;      ///< [Pa], [-] < 0.5
  double thickness = 0.02, width = 0.1;   ///< of the layer and its radius [m]
  double radius = 0.008, depth = 0.0015;  ///< of the sphere, and how far its lowest point is below the surface [m]
  int cells = 24;                         ///< in a contact radius sqrt(radius depth)
  bool follows = false;  ///< the body meets the sphere where it has moved to, and is pushed along the sphere's normals;
                         ///< else as Hertz has it: each ring where it was at first, and straight down
};

struct AxisymmetricPressed {
  double force = 0;           ///< on the sphere [N]
  double contact_radius = 0;  ///< outer edge of the last ring that pushes [m]
  double violation = 0;  ///< largest pull or overlap that the active set leaves, over the largest pressure or depth
  double change = 0;     ///< of the force in the last pass, relative; of a press that follows
  int unknowns = 0;
};

/// The body itself is linear: small strains.
AxisymmetricPressed press_axisymmetric(const AxisymmetricPress& press);

}  // namespace kt
