#pragma once
// The refined cells around the tools, from refresh to refresh: where they are, how small, and how they yield.
#include <memory>
#include <optional>
#include <span>

#include "core/base/settings.hpp"
#include "core/body/tangent_model.hpp"
#include "core/fine/fine_size.hpp"
#include "core/fine/make_fine_patch.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

/// A tool as the refined cells see it.
struct FineTool {
  std::vector<Vec3> core;        ///< some points of it, a radius within its surface [m]
  Vec3 velocity = Vec3::Zero();  ///< [m/s]; along the surface that of the body under it less
  double time = 0;               ///< until the next local model is there [s]
  double late = 1;               ///< time since the last one over the usual interval, 1 to 3, from the schedule alone
  double contact_radius = 0;     ///< measured [m]; 0: not known
  Vec3 normal = Vec3::Zero();    ///< of its contacts by force, from the body towards it, unit; zero: it touches nothing
  std::optional<Vec3>
      touched{};  ///< middle of its contacts by force, on the body at rest [m]; none: it touches nothing
};

/// Radius of the contact of each tool from where its force was distributed over in the last tick [m]: of a ball
/// a^2 = 2.5 times the mean square distance from the middle (Hertz's pressure); 0: of fewer than three contacts.
double measured_contact_radius(std::span<const TickContact> contacts, int tool);

/// Mean normal of the contacts of a tool by force, unit; zero: none pushes.
Vec3 measured_normal(std::span<const TickContact> contacts, int tool);

class FineRefresh {
 public:
  /// Borrows both. Throws InputError where the model tells no material.
  FineRefresh(const DeformableModel& model, const Surface& surface, const LocalSettings& local);

  /// How the cells around the tools yield in the body's state; null: none is near.
  /// @param tangent  of the body's own nodes there, of that kind     @param x  of the whole body
  /// @param patch    around the tools, that they may touch
  /// Throws IndefiniteTangent.
  std::shared_ptr<const FinePatch> find(const TangentModel& tangent, TangentKind kind, const VectorX& x,
                                        const SurfacePatch& patch, std::span<const TouchTool> tools,
                                        std::span<const FineTool> places);

 private:
  struct Zone {
    FineZone zone;
    FineContact contact;
    std::vector<int> nodes;  // of its cells
    double cell = 0;         // [m]
  };
  struct Wanted {
    double contact_radius = 0, travel = 0;  // [m]
    double late = 1;                        // see FineTool
    std::vector<Vec3> from, to;  // of each tool's contact until the next model is in use, on the body at rest
  };
  Wanted wanted(const VectorX& x, const SurfacePatch& patch, std::span<const TouchTool> tools,
                std::span<const FineTool> places) const;
  static FineContact ahead(const Wanted& wanted);
  bool serves(const Wanted& wanted) const;
  void make_zone(const FineContact& contact, double late);
  bool is_bent(const VectorX& x) const;
  const Surface& surface_;
  std::unique_ptr<Refinable> isotropic_;  // of a model that tells nothing but "young" and "poisson"
  FineBody body_;
  double fineness_;
  int most_nodes_;
  std::optional<Zone> zone_;
  double sized_for_ = 0;  // contact radius that the cells' size was chosen for [m]
  std::unique_ptr<SparseSolver> solver_;
  std::shared_ptr<const FinePatch> patch_;  // of the zone, in the state that follows
  VectorX x_;                               // of the whole body [m]
  TangentKind kind_ = TangentKind::symmetric;
};

}  // namespace kt
