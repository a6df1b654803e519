#pragma once
// The refined cells around the tools, from refresh to refresh: where they are, how small, and how they yield.
#include <limits>
#include <memory>
#include <optional>
#include <span>

#include "core/base/settings.hpp"
#include "core/body/tangent_model.hpp"
#include "core/contact_surface/rest_surface.hpp"
#include "core/fine/fine_size.hpp"
#include "core/fine/make_fine_patch.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/refresh/seen_tool.hpp"

namespace kt {

class FineRefresh {
 public:
  /// Borrows both. Throws InputError where the model tells no material.
  /// @param contact_surface  settings' contact.surface
  FineRefresh(const DeformableModel& model, const Surface& surface, const LocalSettings& local,
              const std::string& contact_surface);

  /// How the cells around the tools yield in the body's state; null: none is near.
  /// @param tangent  of the body's own nodes there, of that kind     @param x  of the whole body
  /// @param patch    around the tools, that they may touch: triangles of the surface
  /// Throws IndefiniteTangent.
  std::shared_ptr<const FinePatch> find(const TangentModel& tangent, TangentKind kind, const VectorX& x,
                                        std::span<const int> patch, std::span<const TouchTool> tools,
                                        std::span<const SeenTool> places);

  /// Of the last find(); null as there.
  const std::shared_ptr<const FinePatch>& found() const noexcept { return patch_; }

  /// When it has to be found anew: now, since it does not serve until the next local model is there; next, for the one
  /// after that; not at all.
  enum class Due { now, next, not_yet };
  Due due(const TangentModel& tangent, TangentKind kind, const VectorX& x, std::span<const int> patch,
          std::span<const TouchTool> tools, std::span<const SeenTool> places, std::span<const SeenTool> later) const;

 private:
  /// Of the middle of a tool's contact, on the body at rest; of one that is long of some places along it.
  struct Way {
    Vec3 from = Vec3::Zero(), to = Vec3::Zero();
    double distance(const Vec3& place) const;
  };
  struct Zone {
    FineZone zone;
    FineZoneOptions options;
    FineContact contact;
    std::vector<Way> ways;    // that it serves for
    std::vector<int> nodes;   // of its cells' corners
    double cell = 0;          // [m]
    double late = 1;          // see SeenTool
    double room = 1;          // cells under a long contact may be so many times as large as under a round one
    bool is_long = false;     // it goes along a capsule
    bool has_room = true;     // a tick holds all places of the contact
    bool is_touched = false;  // every tool has touched since it was made
    bool may_widen = false;   // there were not the nodes for a wide one
  };
  struct Wanted {
    double contact_radius = 0;                                     // [m]
    double tool_radius = std::numeric_limits<double>::infinity();  // of the smallest [m]
    double late = 1;                                               // see SeenTool
    double areas = 0;                        // of all contacts over that of a round one of this radius
    double whole_area = 0, whole_width = 0;  // of long contacts of tools that are pressed in deeply [m^2], half [m]
    bool touches = false, is_long = false;
    bool all_touch = true;
    std::vector<Way> ways;  // of all tools until the next model is in use
  };
  Wanted wanted(const VectorX& x, std::span<const int> patch, std::span<const TouchTool> tools,
                std::span<const SeenTool> places) const;
  static double longest(std::span<const Way> ways);  // [m]
  double ahead_radius(const Wanted& wanted) const;
  bool serves(const Wanted& wanted) const;
  bool is_kept(const Wanted& wanted) const;
  double largest_fineness(double areas) const;
  bool has_room(const Wanted& wanted, double cell, std::size_t tools) const;
  double cell_size(double least, double most, double cell) const;
  FineZone make_wide_zone(double widest, FineZoneOptions& options) const;
  void make_zone(Wanted wanted, std::size_t tools);
  double bend(const VectorX& x) const;
  const Surface& surface_;
  RefinableBody refinable_;
  const FineBody& body_ = refinable_.fine;
  std::optional<RestSurface> smooth_;  // none: cells' surfaces are flat
  double fineness_;
  int most_nodes_;
  bool stays_;  // one zone, where the tools first touched
  bool may_be_wide_;
  std::optional<Zone> zone_;
  double sized_ = std::numeric_limits<double>::infinity();  // that the cells were to have at most [m]
  std::unique_ptr<SparseSolver> solver_;
  std::shared_ptr<const FinePatch> patch_;  // of the zone, in the state that follows
  VectorX x_;                               // of the whole body [m]
  TangentKind kind_ = TangentKind::symmetric;
};

}  // namespace kt
