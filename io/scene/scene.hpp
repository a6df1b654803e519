#pragma once
// A scene as data, with body, tool and method. Plain structs that mirror the keys of the scene file (docs/scene.md), so
// a setting has one name in the file, on the command line (--set object.model.young=2e4) and in the code. SI units.
// Keys, ranges and fixed word lists live in io/scene/scene.schema.json and nowhere else. Names of backends are plain
// strings here, because the tables they come from belong to other libraries. The session checks them.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/settings.hpp"

namespace kt {

/// Every node in the lowest part of the bounding box along one axis is clamped.
struct FixedBelow {
  std::string axis = "z";  ///< x y z
  double fraction = 0.05;  ///< share of the extent along the axis [-], in [0, 1]
  bool operator==(const FixedBelow&) const = default;
};

/// Clamped nodes. At most one member is set. With none the object floats.
struct SceneFixed {
  std::optional<FixedBelow> below = FixedBelow{};
  std::optional<std::array<Vec3, 2>> box;  ///< two opposite corners [m], world frame, after size or scale
  std::optional<std::vector<int>> nodes;   ///< node indices, from 0
  bool operator==(const SceneFixed&) const = default;
};

/// Fill a surface with tetrahedra.
struct SceneTetrahedralize {
  std::string backend;               ///< empty for the first that is available
  std::optional<double> max_volume;  ///< largest tetrahedron [m^3], by default chosen from the surface's edges
  double quality = 1.4;              ///< radius-edge ratio bound [-]
  std::optional<double> max_edge;    ///< edge of the surface [m]. Longer ones are halved first, none by default
  bool operator==(const SceneTetrahedralize&) const = default;
};

/// Inner layers of masses below a surface, for a mass-spring model without tetrahedra (the paper's network).
struct SceneLayers {
  int count = 1;
  double thickness = 0.01;  ///< distance from one layer to the next [m]
  bool operator==(const SceneLayers&) const = default;
};

/// The cubes of body "lattice". At most one is set.
struct SceneLattice {
  std::optional<double> edge;  ///< longest edge of a cube [m]
  std::optional<int> nodes;    ///< about so many nodes, by default as many as global.rate_hz has time for
  bool operator==(const SceneLattice&) const = default;
};

/// Damping D = mass * M + stiffness * K.
struct SceneDamping {
  double mass = 5.0;                ///< [1/s]
  double stiffness = 2e-3;          ///< [s]
  std::string law = "strain_rate";  ///< law of `stiffness`. strain_rate lets a body turn freely, rayleigh does not
  bool operator==(const SceneDamping&) const = default;
};

/// A ball inside the body, stiffer or softer than the rest.
struct SceneInclusion {
  Vec3 center = Vec3::Zero();  ///< [m], in the body's coordinates after size or scale
  double radius = 0.0;         ///< [m]
  double stiffer = 1.0;        ///< factor of Young's modulus, and of springs' stiffness [-]
  bool operator==(const SceneInclusion&) const = default;
};

struct SceneModel {
  std::string type = "msd";              ///< name in models/models.def
  std::string material = "neo_hookean";  ///< material of a continuum model
  std::string element = "auto";          ///< auto tet4 tet10 hex8, of fem. auto: see lattice_element(), else tet4
  bool consistent_mass = false;          ///< of fem, else lumped to the nodes
  double young = 1e4;                    ///< [Pa]
  double poisson = 0.3;                  ///< [-], in (-1, 0.5)
  double density = 1000.0;               ///< [kg/m^3]
  SceneDamping damping;
  std::optional<double> stiffness;  ///< every spring of msd [N/m], by default calibrated, or the model's own
  std::optional<double> damper;     ///< every spring of msd [N.s/m], by default from damping
  bool calibrate = true;      ///< choose each spring of msd so that the network matches young (false with stiffness)
  double least_volume = 0.7;  ///< share of its volume below which msd pushes a tetrahedron back, [0, 0.95], 0 for never
  std::vector<SceneInclusion> inclusions;  ///< the last one that holds an element wins
  bool operator==(const SceneModel&) const = default;
};

struct SceneObject {
  std::string mesh;             ///< file, relative to the scene file in the file, resolved once loaded
  std::optional<double> size;   ///< longest edge of the bounding box [m]. At most one of size and scale is set;
  std::optional<double> scale;  ///< one mesh unit [m]. Without both the mesh is in metres
  bool repair = false;          ///< repair the surface where that is safe, and list the changes
  std::string body =
      "mesh";  ///< mesh for its own nodes and tetrahedra, lattice for cubes around the surface, io/solid/lattice.hpp
  std::optional<SceneLattice> lattice;
  SceneFixed fixed;
  std::optional<SceneTetrahedralize> tetrahedralize;  ///< by default only where the model cannot do without
  std::optional<SceneLayers> layers;
  Vec3 gravity = Vec3::Zero();  ///< [m/s^2]
  SceneModel model;
  bool operator==(const SceneObject&) const = default;
};

/// A point of a tool path.
struct Waypoint {
  double t = 0.0;                ///< [s], increasing along the path
  Vec3 position = Vec3::Zero();  ///< [m], world frame
  bool operator==(const Waypoint&) const = default;
};

/// Press down on the surface, then drag along it.
struct PressDrag {
  std::optional<std::array<double, 2>>
      at;                         ///< place in the plane across the pressing direction [m], by default the session's
  double depth = 0.004;           ///< below the undeformed surface [m]
  double press_time = 0.2;        ///< [s]
  Vec3 direction{1.0, 0.0, 0.0};  ///< direction of the drag, of any length
  double speed = 0.05;            ///< speed of the drag [m/s]
  std::string ease = "none";      ///< start and turn of the path, none (at once), minimum_jerk
  bool operator==(const PressDrag&) const = default;
};

/// A simulated hand, a mass held by a spring and a damper to a target that moves. The tool answers to the contact
/// force.
struct SceneHand {
  double stiffness = 300.0;  ///< [N/m]
  double damping = 3.0;      ///< [N.s/m]
  double mass = 0.1;         ///< [kg]
  double delay_ms = 0.0;     ///< from the tick to the motors, through bus, driver, amplifier
  std::vector<Waypoint> target;
  bool operator==(const SceneHand&) const = default;
};

/// Motion of the tool. Exactly one member is set in a loaded scene.
struct ScenePath {
  std::optional<PressDrag> press_drag = PressDrag{};
  std::optional<std::vector<Waypoint>> waypoints;
  std::optional<std::string> recording;  ///< file, relative to the scene file in the file, resolved once loaded
  std::optional<SceneHand> hand;
  std::optional<DeviceSettings> device;  ///< held by a person
  bool operator==(const ScenePath&) const = default;
};

struct SceneTool {
  std::string shape = "sphere";  ///< point sphere capsule mesh
  double radius = 0.004;         ///< [m]. A point ignores it. A mesh's triangles are rounded by it
  double length = 0.02;          ///< distance of the centres of a capsule's ends, along z [m]
  std::string mesh;              ///< file of a mesh, relative to the scene file in the file, resolved once loaded
  std::optional<double> size;    ///< longest edge of a mesh's bounding box [m]
  std::optional<double> scale;   ///< unit of a mesh in metres, exclusive with size
  Vec3 turn = Vec3::Zero();      ///< orientation at t = 0, a rotation vector [rad]
  Vec3 spin = Vec3::Zero();      ///< angular velocity about the reference point [rad/s]
  ScenePath path;
  bool operator==(const SceneTool&) const = default;
};

struct Scene {
  std::string title;
  double duration = 1.0;    ///< simulated [s]
  bool is_endless = false;  ///< until it is stopped, "duration" null in the file
  std::uint64_t seed = 1;   ///< seed of everything random, as hand tremor and link loss
  SceneObject object;
  SceneTool tool;
  std::optional<SceneTool> second_tool;  ///< tool of another hand, on the same body at the same time
  ContactSettings contact;
  GlobalSettings global;
  LocalSettings local;
  LinkSettings link;
  CollisionSettings collision;
  bool operator==(const Scene&) const = default;
};

/// The scene that an empty file would give. Its mesh is empty, so the caller names one.
Scene default_scene();

/// The door that a scene has come through, which decides the files and addresses that it may name
/// (io/scene/named_here.hpp).
enum class SceneDoor {
  file,   ///< a file of this computer
  others  ///< a page, another computer, a session
};

/// Reads a scene file (JSON with // and /* */ comments), with settings replaced by "object.model.young=2e4".
/// An override's value is JSON if it parses, else a word. Setting one of several exclusive keys drops the others.
/// Files named in the scene are relative to the scene file, and in an override to the current folder if they are there.
/// Overrides are this computer's own, and may name any library and address.
/// @throws InputError of one line with file, key, value and allowed range.
Scene load_scene(const std::string& path, const std::vector<std::string>& overrides = {},
                 SceneDoor door = SceneDoor::file);

/// The same from text. `name` stands for the file in messages. File names inside are left as they are.
Scene parse_scene(const std::string& json, const std::vector<std::string>& overrides = {},
                  const std::string& name = "scene");

/// Every key with its value, two spaces of indent. parse_scene gives the equal scene back.
std::string to_json(const Scene& scene);

/// Every key that has a value, in the schema's order, "title", "object.model.young", "object.fixed.below.axis" and so
/// on.
std::vector<std::string> known_scene_keys();

/// The draft-07 schema, as text.
const std::string& scene_schema();

}  // namespace kt
