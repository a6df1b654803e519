#pragma once
// What one haptic tick gives.
#include <limits>

#include "core/base/types.hpp"
#include "haptics/contact/friction.hpp"

namespace kt {

/// Things that a tick reports besides its force.
enum LocalFlag : unsigned {
  kEventsExhausted = 1,     ///< more impacts in one tick than kMaxEvents
  kLeftPatch = 2,           ///< the contact lies on the edge of the patch: the model is wrong there, a refresh is due
  kLostAnchor = 4,          ///< a refresh brought a patch that does not hold the contact
  kRigidContact = 8,        ///< contact with a part that cannot move: see softest_contact()
  kNotFinite = 16,          ///< the local state left the finite numbers; it was reset and the force is zero
  kContactsExhausted = 32,  ///< kMaxContacts places touch at once, and more may
  kPushedOut = 64,          ///< the tool was inside, and the body is being pushed off it
  kStaleModel = 128,        ///< the body has not followed for long: the local model in use is old
  kBodyFailed = 256,        ///< the body's simulation has ended with an error: the last local model goes on
  kNoModel = 512,           ///< nothing is touched: there is no local model yet
  kBadPose = 1024,          ///< the tool's pose was not finite, or far beyond any body: it stayed where it was
  kLateTick = 2048,         ///< more time had passed than is caught up with in one call
  kGated = 4096,            ///< a device's gate was not fully open: the force that was given is a part of the model's
  kSlewed = 8192,           ///< the force given was held back from changing faster than the device is allowed
  kStalePose = 16384,       ///< the device's pose was too old, or the device was not there
  kOnApron = 32768,    ///< the contact lies outside the local model, on the body around it: the force is a coarse one
  kUnrefined = 65536,  ///< the contact lies beside the refined cells: the force is that of the cells as they are
  kWorkExhausted = 131072,  ///< the tick's work was over before its contacts were solved: `residual` says how far
};

constexpr int kMaxEvents = 8;  ///< impacts resolved within one tick

/// One tick's result. Plain values: it is recorded, sent and compared as it is.
struct LocalFrame {
  double t = 0;                ///< end of the tick [s]
  Pose pose;                   ///< of the tool at t
  Vec3 force = Vec3::Zero();   ///< on the tool [N]
  double f_n = 0, f_t = 0;     ///< its normal and tangential parts [N]
  Vec3 normal = Vec3::Zero();  ///< of the contact that carries most: unit, from the body towards the tool
  Vec3 point = Vec3::Zero();   ///< where that one touches the tool [m]
  Vec3 torque = Vec3::Zero();  ///< on the tool about its reference point, of the contacts' own forces [N m]
  double cone_ratio = 0;       ///< largest |f_t| / f_n over the contacts
  ContactMode mode = ContactMode::free;
  int triangle = -1;  ///< of the body's surface: the contact that carries most
  int facet = -1;     ///< of the contact surface, see ContactSurface::global_facet()
  double toi = 0;     ///< of the first impact in this tick, 0 when already in contact
  double gap = std::numeric_limits<double>::infinity();  ///< smallest of a held contact after the tick [m]; none: inf
  double residual = 0;  ///< largest that the contact solver left in this tick, all tools: ContactSolution::residual
  int model_frame = -1;
  int contacts = 0, events = 0;
  unsigned flags = 0;
};

}  // namespace kt
