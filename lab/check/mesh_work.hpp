#pragma once
// What the stages of a check hand from one to the next.
#include <atomic>
#include <memory>

#include "haptics/session/session.hpp"
#include "io/surface/mesh_doctor.hpp"
#include "lab/check/contact_spots.hpp"
#include "lab/check/verdict.hpp"

namespace kt {

struct CheckOptions {
  std::string mesh;                         ///< file
  std::string body = "lattice";             ///< of surfaces: lattice, or mesh: filled with tetrahedra
  int nodes = 300;                          ///< of a lattice, about
  int budget = 2000;                        ///< triangles of a body that is filled; larger surfaces are decimated first
  double young = 1e5;                       ///< stiffness of the bodies, which are 0.1 m long [Pa]
  bool wrap = true;                         ///< wrap surfaces that no tetrahedra fit into, and no shell
  int fill_holes = 0;                       ///< close holes of at most so many edges
  std::string until = "energy";             ///< the last stage that is wanted
  bool quick = false;                       ///< a few shots and places only: for whole libraries in little time
  double backend_seconds = 30;              ///< limit of each repair and tetrahedralizer
  const std::atomic<bool>* stop = nullptr;  ///< Ctrl-C
};

/// One body, of one model.
struct CheckBody {
  std::string model;  ///< msd, fem
  std::unique_ptr<Session> session;
};

struct MeshWork {
  CheckOptions options;
  Mesh input;           ///< as the file has it
  MeshReport report;    ///< of the input
  Mesh surface;         ///< repaired; longest side kBodySize, about the origin [m]
  MeshReport repaired;  ///< of it
  Vec3 origin = Vec3::Zero();
  double scale = 1;        ///< surface = scale * (file - origin)
  Mesh solid;              ///< of the body: triangles are where it is touched [m]
  double shell = 0;        ///< thickness, when the body is a shell around an open surface [m]; 0: it is solid
  std::vector<int> held;   ///< clamped nodes of the solid
  std::vector<int> still;  ///< nodes of its triangles that these hold
  std::vector<ContactSpot> spots;
  std::vector<CheckBody> bodies;

  Vec3 in_file(const Vec3& p) const { return p / scale + origin; }
};

constexpr double kBodySize = 0.1;  ///< [m] as `kilotouch run MESH`: forces and depths of all meshes compare

/// A stage either fills in its result and its part of the work, or throws: then it has failed.
using CheckStage = void (*)(MeshWork& work, StageResult& out);

void check_load(MeshWork&, StageResult&);  // load_and_doctor.cpp
void check_doctor(MeshWork&, StageResult&);
void check_repair(MeshWork&, StageResult&);        // repair.cpp
void check_queries(MeshWork&, StageResult&);       // queries.cpp
void check_shots(MeshWork&, StageResult&);         // shots.cpp
void check_solid(MeshWork&, StageResult&);         // solid.cpp
void check_models(MeshWork&, StageResult&);        // models.cpp
void check_local_models(MeshWork&, StageResult&);  // local_models.cpp
void check_press(MeshWork&, StageResult&);         // press.cpp
void check_drag(MeshWork&, StageResult&);          // drag.cpp
void check_energy(MeshWork&, StageResult&);        // energy.cpp

}  // namespace kt
