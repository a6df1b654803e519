#pragma once
// Where the contacts will be a little later, were the tool to keep its velocity: for the state that the body is
// linearized at. A local model that is used for an interval is best made of the body in the middle of it.
#include <array>
#include <deque>
#include <span>
#include <vector>

#include "collision/shape/tool_shape.hpp"
#include "core/contact_surface/contact_surface.hpp"
#include "core/global/global_simulation.hpp"
#include "core/global/held_model.hpp"
#include "core/local/reducer.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/refresh/contact_nodes.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

/// The contacts of a tool at the end of the reports, none without any. On refined cells one for all of them; of a long
/// contact one for each of up to four sections.
/// @param nodes    that moved with contacts
/// @param rate_hz  of the ticks
std::vector<ContactHold> last_holds(std::span<const LocalReport> reports, const ContactNodes& nodes, double rate_hz,
                                    const ToolShape& shape, int tool = 0);

/// What ticks did to the body since the last refresh, and where it is held now.
struct LastContacts {
  std::vector<ContactSample> history;
  std::vector<ContactHold> holds;
};
/// @param are_refined  several contacts are held by one, and were in the ticks before: by the nearest
LastContacts last_contacts(std::span<const LocalReport> reports, const ContactNodes& nodes, double rate_hz,
                           std::span<const TouchTool> tools, bool are_refined);

/// The tool's mean velocity [m/s] over the last reports, up to kVelocityTime of them; zero for fewer than two.
Vec3 tool_velocity(std::span<const LocalReport> reports, double rate_hz, int tool = 0);

constexpr double kVelocityTime =
    0.01;  ///< [s] a hand's tremor, about 10 Hz, is followed; the noise of its encoder is not

/// The way of a tool in the next `seconds` [m]: it keeps its velocity, but gets no further than it came that way in as
/// long before. A drag goes on; a swing, or rubbing to and fro, does not lead far away, however fast it is just now.
/// @param velocity  measured [m/s]      @param came  its way in the last `seconds` [m]
Vec3 expected_way(const Vec3& velocity, const Vec3& came, double seconds);

/// Without the part along the contacts' normals, of which the mean by force counts; all of it without contacts.
Vec3 along_surface(const Vec3& way, std::span<const ContactHold> holds);

/// Where tools were at the refreshes of the last second.
class PastPlaces {
 public:
  /// @param t  [s], of the refresh, after all others
  void add(double t, std::span<const Pose> tools);
  /// From where the tool was `seconds` before the last refresh to where it was then [m], linear in between; from the
  /// first place that is known, where that is later.
  Vec3 came(int tool, double seconds) const;

 private:
  struct Place {
    double t = 0;
    std::array<Vec3, kMaxTools> x{Vec3::Zero(), Vec3::Zero()};
  };
  std::deque<Place> places_;  // ascending
};

/// The contacts after the tool has moved by `step` [m]. What sticks goes with it on its triangle. What slides moves
/// over the undeformed surface by as much, to the nearest triangle that faces the tool.
/// @param smoothing  of the surface that the tool touches
/// @param rest       positions of the undeformed body [m], (3n)
std::vector<ContactHold> moved_holds(std::vector<ContactHold> holds, const Surface& surface, const Smoothing& smoothing,
                                     const VectorX& rest, const Vec3& step);

}  // namespace kt
