#pragma once
// A tool dragged over the whole of a closed surface, tick by tick, and what an onlooker counts: contacts lost, impacts
// with what is held already, penetration, jumps of normal and force where the contact crosses an edge.
#include <cmath>
#include <random>

#include "collision/shape/closest_point.hpp"
#include "haptics/tick/contact_check.hpp"
#include "haptics/tick/local_simulation.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {

/// Springs from each node to its place at rest and along each edge: the simplest body whose every part can be pressed
/// and whose contacts feel one another. Quick enough to be back at rest before the tool comes round again.
struct SlidingBody {
  static constexpr double kGround = 300, kAlongEdge = 300;             // [N/m]
  static constexpr double kMass = 1e-4, kDamping = 0.3, kStep = 1e-3;  // of a node [kg], [N s/m]; [s]

  SurfacePatch patch;
  VectorX x;          ///< at rest [m], (3p)
  double size, edge;  ///< largest side of the bounding box, mean edge [m]

  explicit SlidingBody(const Mesh& mesh) {
    const Surface surface = make_surface(mesh);
    patch = make_patch(surface, mesh.x, {node(mesh.x, mesh.triangles[0][0]), 0, 1e3});
    x.resize(3 * patch.num_vertices());
    for (int i = 0; i < patch.num_vertices(); ++i) node(x, i) = node(mesh.x, patch.global_node[i]);
    size = bounds(mesh).size().maxCoeff();
    double sum = 0;
    for (const Triangle& t : patch.triangles)
      for (int c = 0; c < 3; ++c) sum += (node(x, t[c]) - node(x, t[(c + 1) % 3])).norm();
    edge = sum / (3.0 * static_cast<double>(patch.triangles.size()));
  }

  std::unique_ptr<PreparedLocalModel> local_model(const std::string& collision_backend) const {
    const int n = 3 * patch.num_vertices();
    LocalModel m;
    m.patch = patch;
    for (int& t : m.patch.global_triangle) t = static_cast<int>(&t - m.patch.global_triangle.data());
    for (int i = 0; i < n / 3; ++i) m.recovered_node.push_back(m.patch.global_node[i] = i);
    m.x0 = x;
    m.v0 = m.f0 = m.q_rate0 = VectorX::Zero(n);
    const SparseMatrix one = VectorX::Ones(n).asDiagonal().toDenseMatrix().sparseView();
    m.basis = m.lift = m.lift_rate = m.fit = m.fit_rate = one;
    m.mass = kMass * one;
    m.damping = kDamping * one;
    std::vector<Eigen::Triplet<double>> entries;
    for (const Triangle& t : patch.triangles)
      for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 3; ++k) {  // each edge is met twice, once in either direction
          entries.emplace_back(3 * t[c] + k, 3 * t[c] + k, kAlongEdge);
          entries.emplace_back(3 * t[c] + k, 3 * t[(c + 1) % 3] + k, -0.5 * kAlongEdge);
          entries.emplace_back(3 * t[(c + 1) % 3] + k, 3 * t[c] + k, -0.5 * kAlongEdge);
        }
    m.stiffness.resize(n, n);
    m.stiffness.setFromTriplets(entries.begin(), entries.end());
    m.stiffness += kGround * one;
    m.reducer = "whole surface";
    return prepare(std::move(m), LocalScheme::implicit_euler, Metric::implicit, kStep, collision_backend, n / 3,
                   static_cast<int>(patch.triangles.size()));
  }
};

/// The same surface with other numbers for its vertices and triangles, and other first corners.
inline Mesh renumbered(const Mesh& mesh, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<int> place(mesh.num_nodes());
  for (int i = 0; i < mesh.num_nodes(); ++i) place[i] = i;
  for (std::size_t i = place.size(); i > 1; --i) std::swap(place[i - 1], place[random() % i]);
  Mesh out = mesh;
  for (int i = 0; i < mesh.num_nodes(); ++i) node(out.x, place[i]) = node(mesh.x, i);
  for (Triangle& t : out.triangles) {
    const std::size_t first = random() % 3;
    t = {place[t[first]], place[t[(first + 1) % 3]], place[t[(first + 2) % 3]]};
  }
  for (std::size_t i = out.triangles.size(); i > 1; --i) std::swap(out.triangles[i - 1], out.triangles[random() % i]);
  return out;
}

/// A way over the undeformed surface, winding so that it comes everywhere, and the tool `depth` deep in it: a point
/// along the blended normal, a sphere with its centre that much nearer than its radius to the nearest place. Turns
/// where it gets stuck in a groove.
class SurfaceWalk {
 public:
  SurfaceWalk(const SlidingBody& body, const ToolShape& tool, double depth)
      : body_(body), tool_(tool), depth_(depth), index_(make_triangle_index("refit_bvh")) {
    index_->build(body.patch.triangles, body.x);
    index_->refit(body.x, body.x);
    candidates_.resize(body.patch.triangles.size());
    const Triangle& t = body.patch.triangles[0];
    const Vec3 middle = (node(body.x, t[0]) + node(body.x, t[1]) + node(body.x, t[2])) / 3;
    normal_ = face_normal(body.patch, body.x, 0);
    at_ = middle + clearance() * normal_;
    heading_ = (node(body.x, t[1]) - node(body.x, t[0])).normalized();
    if (tool_.radius > 0) settle();
  }

  Vec3 tool() const { return tool_.radius > 0 ? at_ : Vec3(at_ - depth_ * normal_); }
  const Vec3& normal() const { return normal_; }

  void advance(double length) {
    way_ += length / body_.size;
    heading_ = Eigen::AngleAxisd(length / body_.size * (0.7 + 1.5 * std::sin(2 * way_)), normal_) * heading_;
    heading_ = (heading_ - heading_.dot(normal_) * normal_).normalized();
    const Vec3 before = at_;
    at_ += length * heading_;
    tool_.radius > 0 ? settle() : put_on_surface();
    if ((at_ - before).norm() < 0.2 * length) heading_ = Eigen::AngleAxisd(2, normal_) * heading_;
  }

 private:
  double clearance() const { return tool_.radius > 0 ? tool_.radius - depth_ : 0; }

  void put_on_surface() {
    const Contact c = track_point_contact(body_.patch, body_.x, at_, triangle_);
    triangle_ = c.triangle;
    constexpr double kFollows = 0.1;  // in a sharp fold the contact's normal jumps, but no hand does
    normal_ = (normal_ + kFollows * (c.normal - normal_)).normalized();
    const Triangle& t = body_.patch.triangles[triangle_];
    at_ = c.bary[0] * node(body_.x, t[0]) + c.bary[1] * node(body_.x, t[1]) + c.bary[2] * node(body_.x, t[2]);
  }

  void settle() {
    for (int i = 0; i < 30; ++i) {
      const int found = index_->candidates({at_, at_}, 2 * tool_.radius, candidates_);
      double nearest_sq = std::numeric_limits<double>::infinity();
      Vec3 nearest = at_;
      for (int k = 0; k < found; ++k) {
        const Triangle& t = body_.patch.triangles[candidates_[k]];
        const auto c = closest_point_on_triangle(at_, node(body_.x, t[0]), node(body_.x, t[1]), node(body_.x, t[2]));
        if (c.distance_sq >= nearest_sq) continue;
        nearest_sq = c.distance_sq;
        nearest = c.point;
      }
      normal_ = (at_ - nearest).normalized();
      const double off = clearance() - std::sqrt(nearest_sq);
      at_ += off * normal_;
      if (std::abs(off) < 1e-6 * depth_) return;
    }
  }

  const SlidingBody& body_;
  ToolShape tool_;
  double depth_, way_ = 0;
  std::unique_ptr<TriangleIndex> index_;
  std::vector<int> candidates_;
  Vec3 at_, normal_, heading_;
  int triangle_ = 0;
};

/// Where the contact that carries most went from one triangle over an edge to the next.
struct EdgeCrossing {
  double dihedral;     ///< angle between the faces at rest [deg], positive where the edge is convex
  double normal_jump;  ///< angle between the contact's normals of the two ticks [deg]
  double force_jump;   ///< change of the force / mean force
};

struct SlidingReport {
  int ticks = 0;
  int lost = 0;                       ///< ticks without contact
  int events = 0;                     ///< impacts while contact was held
  int double_hits = 0;                ///< of these, those that led to no contact away from the held ones
  int exhausted = 0;                  ///< ticks whose flag says that there were too many events
  int deep = 0;                       ///< ticks that end deeper than 1e-9 of the size
  double penetration = 0, hover = 0;  ///< largest, over the ticks in contact; of the mesh's size
  double mean_force = 0;              ///< [N]
  double mean_contacts = 0;
  double steady_jump = 0;  ///< force jump between ticks on one triangle, 99th percentile
  std::vector<EdgeCrossing> crossings;
};

inline double dihedral_angle(const SlidingBody& body, int triangle, int across) {
  const Vec3 a = face_normal(body.patch, body.x, triangle), b = face_normal(body.patch, body.x, across);
  double out = 0;
  for (int v : body.patch.triangles[across])
    if (std::ranges::find(body.patch.triangles[triangle], v) == body.patch.triangles[triangle].end())
      out = a.dot(node(body.x, v) - node(body.x, body.patch.triangles[triangle][0]));
  return std::copysign(std::atan2(a.cross(b).norm(), a.dot(b)), -out) * 180 / std::acos(-1.0);
}

inline double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::acos(-1.0);
}

/// How many of `contacts` lie on triangles that share no vertex with those of `held`.
inline int away_from(const SurfacePatch& patch, const ContactSet& contacts, const ContactSet& held) {
  return static_cast<int>(std::count_if(contacts.begin(), contacts.end(), [&](const Contact& c) {
    return std::none_of(held.begin(), held.end(), [&](const Contact& h) {
      const Triangle& t = patch.triangles[h.triangle];
      return std::ranges::any_of(patch.triangles[c.triangle],
                                 [&](int v) { return std::ranges::find(t, v) != t.end(); });
    });
  }));
}

/// Looks on while a tool is dragged. `visit(frame)` is called after each tick.
template <class Visit>
SlidingReport slide(const SlidingBody& body, const ToolShape& tool, double mu, double depth, double speed, int ticks,
                    Visit visit) {
  LocalSimulation local(tool, SlidingBody::kStep, make_contact_solver("coulomb", {mu, mu}));
  local.adopt(body.local_model("refit_bvh"));
  SurfaceWalk walk(body, tool, depth);
  Vec3 at = walk.tool() + 1.5 * depth * walk.normal();
  const auto go_to = [&](const Vec3& next) {
    const LocalFrame frame = local.step({at, next});
    at = next;
    return frame;
  };
  const Vec3 start = at;
  LocalFrame before;
  constexpr int kPressing = 50;
  for (int i = 1; i <= kPressing; ++i) before = go_to(start + i * (walk.tool() - start) / kPressing);

  SlidingReport out;
  out.ticks = ticks;
  std::vector<double> steady;
  VectorX x = body.x;
  for (int i = 0; i < ticks; ++i) {
    const ContactSet held = local.model().state.anchors;
    walk.advance(speed * SlidingBody::kStep);
    const LocalFrame frame = go_to(walk.tool());
    visit(frame);
    out.lost += frame.mode == ContactMode::free && clear_distance(body.patch, body.x, tool, at) < 0;
    out.exhausted += (frame.flags & kEventsExhausted) != 0;
    out.mean_force += frame.force.norm() / ticks;
    out.mean_contacts += static_cast<double>(frame.contacts) / ticks;
    if (held.count) {
      out.events += frame.events;
      const int away = away_from(body.patch, local.model().state.anchors, held);
      out.double_hits += std::max(0, frame.events - away);
    }
    x = body.x + local.model().state.q;
    const double distance = clear_distance(body.patch, x, tool, at);
    out.penetration = std::max(out.penetration, -distance / body.size);
    constexpr double kDeep = 1e-9;
    out.deep += -distance / body.size > kDeep;
    if (frame.mode != ContactMode::free) out.hover = std::max(out.hover, distance / body.size);
    if (frame.mode != ContactMode::free && before.mode != ContactMode::free) {
      const double jump = (frame.force - before.force).norm();
      const auto& across = body.patch.topology.across[before.triangle];
      if (frame.triangle == before.triangle)
        steady.push_back(jump);
      else if (std::ranges::find(across, frame.triangle) != across.end())
        out.crossings.push_back(
            {dihedral_angle(body, before.triangle, frame.triangle), angle_between(before.normal, frame.normal), jump});
    }
    before = frame;
  }
  for (EdgeCrossing& c : out.crossings) c.force_jump /= out.mean_force;
  if (!steady.empty()) {
    const auto high = steady.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(steady.size() - 1));
    std::nth_element(steady.begin(), high, steady.end());
    out.steady_jump = *high / out.mean_force;
  }
  return out;
}

}  // namespace kt
