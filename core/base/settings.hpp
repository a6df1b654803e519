#pragma once
// The settings of the engine as plain values with their defaults, for scene files, the command line and code. SI units.
// Keys and ranges are in io/scene/scene.schema.json. Names of backends are plain strings, because the tables that they
// come from belong to other libraries.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Spring and damper between the tool and its proxy on the surface (law penalty).
struct PenaltySettings {
  double stiffness = 200.0;  ///< [N/m] soft tissue shakes from about 300 on
  double damping = 0.0;      ///< [N.s/m] a force that acts a tick late leaves no room for damping
  bool operator==(const PenaltySettings&) const = default;
};

/// A part of the surface with friction of its own.
struct RegionSettings {
  std::array<Vec3, 2> box{Vec3::Zero(), Vec3::Zero()};  ///< two opposite corners [m], of the body at rest
  double mu_static = -1, mu_kinetic = -1;               ///< as in ContactSettings. Below 0 is not given, an error
  bool operator==(const RegionSettings&) const = default;
};

struct ContactSettings {
  std::string law = "coulomb";      ///< name in haptics/contact/contact_solver.def, or penalty
  double mu_static = 0.5;           ///< friction coefficients [-]. "mu" in the file sets both
  double mu_kinetic = 0.5;          ///< at most mu_static
  std::string metric = "implicit";  ///< identity (the paper), mass, implicit
  PenaltySettings penalty;
  double stribeck = 0;                  ///< [m/s] sliding speed over which mu_static falls to mu_kinetic, 0 for at once
  std::vector<RegionSettings> regions;  ///< the last one that holds a triangle's middle wins
  std::string surface = "flat";         ///< the surface that the tool touches, core/contact_surface/contact_surface.hpp
  int surface_levels = 2;               ///< levels of a smooth one. Each splits a triangle in four
  double ridge_deg = 60;                ///< [deg] convex edges of a smooth one that turn by more stay sharp
  bool operator==(const ContactSettings&) const = default;
};

/// The surface does not pass through itself. A mesh of several pieces is several bodies.
struct SelfContactSettings {
  double mu = 0.3;              ///< coefficient of friction [-]
  std::optional<double> reach;  ///< distance from which on surfaces repel [m], by default a fiftieth of the mean edge
  std::optional<double> stiffness;  ///< stiffness of their barrier [N/m], by default the body's at its surface nodes
  double creep = 1e-3;              ///< largest sliding speed of contacts that stick [m/s]
  bool operator==(const SelfContactSettings&) const = default;
};

struct GlobalSettings {
  double rate_hz = 30.0;  ///< 10 in the paper
  std::string integrator = "implicit_euler";
  std::string solver = "automatic";  ///< solver of implicit steps, automatic direct pcg
  double tolerance = 1e-5;           ///< tolerance of pcg, |residual| / |rhs|
  bool early_refresh = true;         ///< up to four times rate_hz while the local models' force is off by more than
                                     ///< local.tolerance when an interval ends, and at the edge of the patch
  bool look_ahead = true;            ///< linearizes where the body will be half-way through the local model's use
  bool definite = true;              ///< implicit_euler has the definite tangent always, else only where it must
  std::optional<SelfContactSettings> self_contact;  ///< with the integrator newton_euler, the file's default then
  bool operator==(const GlobalSettings&) const = default;
};

struct LocalSettings {
  double rate_hz = 1000.0;                  ///< at least the global rate
  std::string reducer = "auto";             ///< or a name in core/local/reducers.def
  int rings = 1;                            ///< rings of triangles around the contact [-]
  double tolerance = 0.05;                  ///< largest certified error of the local model [-]
  double budget_us = 200;                   ///< predicted CPU time of a haptic tick that reducer auto stays within
  std::optional<double> refresh_budget_ms;  ///< CPU time of a refresh that reducer auto stays within, by default 0.8 /
                                            ///< global.rate_hz where ticks do not wait for a refresh, else none
  bool catch_up = true;  ///< a new local model goes on from the old one's motion, replayed to the present. Else it
                         ///< takes over the old one's state
  double blend_ms = 12;  ///< the difference between two local models fades from the force over this time
  /// Cells around the contact finer than the body's, in series with the local model. They "follow" the tool,
  /// stay where it first touched ("set-up"), or are "off". "auto" follows it where that can be and the body's cells are
  /// wider than half the contact.
  std::string refine = "auto";
  double fineness = 1.4;   ///< size of these cells under the tool over the contact radius, at most, 1.35 or more [-]
  int refine_nodes = 900;  ///< most nodes of these cells. Where more are needed the cells are larger
  double passivity_damping = 0;      ///< most that passivity control may add [N s/m]. With 0 the energy is only watched
  std::string integrator = "auto";   ///< exact, implicit_euler, symplectic_euler, or auto for the one that fits
  std::string method = "multirate";  ///< name in haptics/tick/haptic_method.def, this engine or a baseline
  bool operator==(const LocalSettings&) const = default;
};

struct LinkSettings {
  std::string type = "lockstep";
  double latency_ms = 0.0;                ///< from the end of a global step to the local side
  double loss = 0.0;                      ///< share of local models that never arrive [-], in [0, 1]
  std::string charge_refreshes = "none";  ///< lockstep delays a local model by the time of its refresh, none,
                                          ///< measured, predicted, given
  std::optional<double> refresh_ms;       ///< time of each, where given
  double stale_ms = 500;                  ///< network, without a new local model for so long the force goes to zero
  int basis_bits = 16;                    ///< network, bits of each entry of a local model's basis, 8 or 16
  bool operator==(const LinkSettings&) const = default;
};

/// A haptic device outside the program, its frame in the world, and the largest forces that it may get.
struct DeviceSettings {
  std::string name;                 ///< name of a live device in haptics/device/device.def, haply openhaptics ...
  std::string address;              ///< address of haply's service or spnav's socket, empty for the usual one
  std::string id;                   ///< serial number or device id, empty for the first that is found
  std::string library;              ///< file of openhaptics or forcedimension, empty for the vendor's usual names
  std::optional<Vec3> origin;       ///< world position of the device's origin [m]. If unset, the device's pose at
                                    ///< start-up lies over the body's middle
  std::string axes = "XYZ";         ///< the world's x, y and z among the device's axes, a signed permutation, "X-ZY"
  double scale = 1;                 ///< way of the tool / way of the device
  double force_scale = 1;           ///< force at the device / force on the tool
  std::optional<double> max_force;  ///< [N] at the device. Without, 3 N or the device's own limit if that is less
  double max_slew = 200;            ///< [N/s] at the device
  double damping = 0;               ///< damping of the device, as its user has measured it [N s/m], 0 for not known
  std::optional<double> delay_ms;   ///< time from a tick to the force, measured by default
  std::optional<double> coupling;   ///< stiffness between device and tool [N/m], 0 for none, chosen by default
  std::string deadman = "none";     ///< button that has to be held, none, 1 .. 8, any
  double speed = 0.1;               ///< speed of spnav at full deflection [m/s]
  double service_damping = 0;       ///< damping that haply's service adds by itself [-]
  bool operator==(const DeviceSettings&) const = default;
};

struct CollisionSettings {
  std::string backend = "auto";  ///< name in collision/broad/triangle_index.def
  bool operator==(const CollisionSettings&) const = default;
};

}  // namespace kt
