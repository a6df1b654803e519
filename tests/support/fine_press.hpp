#pragma once
// Presses at rest on a bonded block, by the compliance of the coarse body and that of a fine patch in series with it,
// against rings (axisymmetric_press.hpp). What the patch is worth before it is in a tick.
#include "core/fine/fine_size.hpp"
#include "core/fine/fine_yield.hpp"
#include "models/model.hpp"

namespace kt {

struct PressBlockOptions {
  std::string model = "fem", element = "tet4";
  double cell = 0.005;      ///< [m], of 60 x 60 mm
  double thickness = 0.02;  ///< [m]
  double poisson = 0.3;
  double shaken = 0;  ///< nodes moved by up to this share of a cell, those of the surface within it
};

/// A block bonded below, E = 10 kPa.
class PressBlock {
 public:
  explicit PressBlock(const PressBlockOptions& options);
  const FineBody& body() const { return body_; }
  const DeformableModel& model() const { return *model_; }
  const PressBlockOptions& options() const { return options_; }
  const SparseMatrix& dfdx() const { return dfdx_; }
  /// Compliance of the coarse body along z between points that its nodes move, (k x k) [m/N].   W: (k x n)
  MatrixX compliance_along_z(const SparseMatrix& W) const;

 private:
  PressBlockOptions options_;
  std::unique_ptr<DeformableModel> model_;
  FineBody body_;
  SparseMatrix dfdx_;
  std::unique_ptr<SparseSolver> solver_;
};

struct FinePress {
  double depth = 0.0015;  ///< of a sphere of 8 mm [m]
  double x = 0, y = 0;    ///< from the middle of the top, in cells
  double fineness = 0.7;
  double cells_around = 1.6;  ///< radius of the zone, in cells
  double travel = 0;          ///< [m]
  int most_nodes = 900;
};

FineZoneOptions press_options(const PressBlock& block, const FinePress& press);

struct FinePressed {
  double coarse = 0, fine = 0;  ///< force over the continuum's: of the coarse body alone, and with the patch
  double truth = 0;             ///< the continuum's [N]
  double fineness = 0;          ///< that the cap left: size of the leaves over the contact radius
  int unknown = 0, yielding = 0, inner = 0;
  double least = 0;  ///< see FineYield
};

FinePressed press_fine(const PressBlock& block, const FinePress& press);

}  // namespace kt
