#pragma once
// Refined cells on the hand's computer. Their compliance R grows with the square of its points, 50 KB at 50 points.
// What it is made from is some 50 nodes of the body, 2.8 KB: those travel, and R is made again. docs/network.md.
#include <optional>
#include <string>

#include "core/contact_surface/rest_surface.hpp"
#include "core/fine/fine_body.hpp"
#include "core/fine/make_fine_patch.hpp"
#include "core/linear/sparse_solver.hpp"

namespace kt {

class RemoteCells {
 public:
  /// Borrows both.
  /// @param nodes            unknown ones of a tool's cells, at most
  /// @param contact_surface  settings' contact.surface
  RemoteCells(const DeformableModel& model, const Surface& surface, int nodes, const std::string& contact_surface);

  /// What is wrong with it: a number that is none, or cells that would take more memory than the scene asks for. Empty:
  /// nothing.
  std::string trouble(const FineOrigin& origin) const;

  /// The same bits as where it comes from, on processors of the same kind; the one before where nothing has changed.
  /// Throws RunError where it does not fit the body.
  std::shared_ptr<const FinePatch> find(const std::shared_ptr<const FineOrigin>& origin);

 private:
  const DeformableModel& model_;
  const Surface& surface_;
  int nodes_;
  RefinableBody refinable_;
  const FineBody& body_ = refinable_.fine;
  std::optional<RestSurface> smooth_;  // none: cells' surfaces are flat
  std::unique_ptr<SparseSolver> solver_;
  FineZone zone_;
  std::shared_ptr<const FinePatch> patch_;
};

}  // namespace kt
