// Poisson's ratio x cells across a cantilever, by element: locking near incompressibility, and what it does to the
// stiffness matrix. A tetrahedron of four nodes has one strain, and near nu = 1/2 it must keep its volume: the mesh has
// fewer free motions left than the body (Hughes 2000, section 4.4). The truth is a mesh of 10-node elements.
#include <array>
#include <cmath>
#include <limits>

#include "core/base/numbers.hpp"
#include "core/body/state.hpp"
#include "core/global/integrator.hpp"
#include "haptics/body/bending.hpp"
#include "haptics/predict/predict_elements.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/map.hpp"
#include "lab/stability/runs/bodies.hpp"
#include "lab/stability/runs/condition.hpp"
#include "lab/stability/runs/rays.hpp"

namespace kt {
namespace {

constexpr double kSide = 0.02, kLength = 0.08;  // [m]
constexpr double kOff = 1.1, kLocked = 1.5;     // reference over computed deflection
constexpr double kLeast = 1e-4, kMost = 0.5;    // 1/2 - nu

struct Element {
  std::string name;
  ModelChoice model;
  std::string element = "tet4";
};

const std::vector<Element> kElements = {
    {"tet4", {"fem", "linear"}}, {"tet10", {"fem", "linear"}, "tet10"}, {"springs (msd)", {"msd", ""}}};

/// A column, clamped below, that its weight pulls aside.
std::unique_ptr<DeformableModel> cantilever(const Element& e, int cells, double poisson) {
  const double h = kSide / cells;
  ModelOptions options{.young = 1e5, .poisson = poisson};
  options.element = e.element;
  options.gravity = Vec3(0.1, 0, 0);  // little: springs must stay in their linear range too
  return clamped(e.model, kuhn_block(cells, cells, static_cast<int>(std::lround(kLength / h)), h), options);
}

/// Mean motion of the free end along the load [m].
double deflection(const DeformableModel& model) {
  State state = rest_state(model);
  make_integrator("quasistatic", {.solver = "direct"})->step(model, VectorX::Zero(state.x.size()), 0, state);
  double sum = 0;
  int nodes = 0;
  for (int i = 0; i < model.mesh().num_nodes(); ++i) {
    if (node(model.mesh().x, i).z() < kLength * (1 - 1e-9)) continue;
    sum += (node(state.x, i) - node(model.mesh().x, i)).x();
    ++nodes;
  }
  return sum / nodes;
}

/// The truth between the ratios that it was computed for: linear in nu, in which it is smooth up to 1/2.
class Reference {
 public:
  explicit Reference(const MapOptions& options) : cells_(options.full ? 6 : 4) {
    tips_.resize(kNu.size());
    StabilityMap none;
    run_rays(
        {.stop = options.stop, .jobs = options.jobs}, static_cast<int>(kNu.size()),
        [&](int i) {
          tips_[static_cast<std::size_t>(i)] = deflection(*cantilever(kElements[1], cells_, kNu[i]));
          return RayResult{};
        },
        none);
  }
  int cells() const { return cells_; }
  double at(double nu) const {
    std::size_t i = 1;
    while (i + 1 < kNu.size() && kNu[i] < nu) ++i;
    const double share = (nu - kNu[i - 1]) / (kNu[i] - kNu[i - 1]);
    return (1 - share) * tips_[i - 1] + share * tips_[i];
  }

 private:
  static constexpr std::array kNu{0.0, 0.2, 0.3, 0.4, 0.45, 0.48, 0.49, 0.495, 0.499, 0.4999};
  int cells_;
  std::vector<double> tips_;
};

RayResult trace(const Element& e, int cells, const Reference& reference) {
  RayResult out;
  const auto locking_beyond = [&](double limit) {
    return [&, limit](double distance) {
      const double nu = 0.5 - distance;
      const auto model = cantilever(e, cells, nu);
      MapPoint p = point_at(e.name, distance, cells, predict_locking(*model, e.element, nu));
      double off = std::numeric_limits<double>::infinity();
      try {
        const double tip = deflection(*model);
        p.value = reference.at(nu) / tip;
        off = tip > 0 ? std::max(p.value, 1 / p.value) : off;
        p.why = told("bends ", 1 / p.value, " times as far as it should, condition number ", condition_number(*model));
        StateHash hash;
        hash.add(tip);
        p.hash = hash.value();
      } catch (const RunError& error) {
        p.value = off;
        p.why = error.what();
      }
      p.verdict = off > kLocked ? MapVerdict::fails : off > kOff ? MapVerdict::degrades : MapVerdict::works;
      out.points.push_back(p);
      return off > limit;
    };
  };
  for (double limit : {kOff, kLocked}) {
    const RayCrossing c = bisect(kMost, kLeast, {.tolerance = 0.05}, locking_beyond(limit));
    const std::string label = limit == kOff ? "10 % too stiff, measured" : "50 % too stiff (locked), measured";
    out.boundaries.push_back({e.name, label, {{c.at(), cells}}, false});
    if (e.name == "tet4")
      out.boundaries.push_back({e.name,
                                limit == kOff ? "rule: 10 % too stiff" : "rule of the warning: 50 % too stiff",
                                {{tet4_distance(cells_across(cantilever(e, cells, 0.3)->mesh()), limit), cells}},
                                true});
  }
  return out;
}

}  // namespace

StabilityMap map_poisson(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "1/2 − ν (ν: Poisson's ratio; incompressible to the left) [-]";
  map.y_name = "cells across the cantilever [-]";
  map.x_log = true;
  const Reference reference(options);
  if (is_stopped(options)) return map;
  const std::vector<int> cells = options.full ? std::vector<int>{1, 2, 3, 4, 6, 8} : std::vector<int>{1, 2, 3, 4, 5};
  const int rays = static_cast<int>(kElements.size() * cells.size());
  run_rays(
      options, rays,
      [&](int i) {
        const auto& e = kElements[static_cast<std::size_t>(i) / cells.size()];
        const int n = cells[static_cast<std::size_t>(i) % cells.size()];
        return e.name == "tet10" && n > reference.cells() - 1 ? RayResult{} : trace(e, n, reference);
      },
      map);
  const auto worst = [&](const std::string& series) {
    double out = 0;
    for (const MapPoint& p : map.points)
      if (p.series == series) out = std::max(out, p.value);
    return out;
  };
  map.claim = told("near incompressibility a body of 4-node elements is up to ", worst("tet4"),
                   " times too stiff, one of 10-node elements up to ", worst("tet10"),
                   " times; springs know no Poisson ratio but their own, near 1/4");
  return map;
}

}  // namespace kt
