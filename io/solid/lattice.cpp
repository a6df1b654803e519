#include "io/solid/lattice.hpp"

#include <bitset>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/finding.hpp"
#include "core/base/parallel.hpp"
#include "io/solid/lattice_grid.hpp"
#include "io/solid/lattice_surface.hpp"
#include "io/surface/winding_number.hpp"

namespace kt {
namespace {

constexpr double kLeastShare = 1e-3;  // of a tetrahedron that holds a vertex: it must not move freely
constexpr int kSamples = 6;           // of a cube along each edge
constexpr int kAllSamples = kSamples * kSamples * kSamples;
using Samples = std::bitset<kAllSamples>;

// ---- how large the cubes are ----

/// Corners of cubes that are touched, or have their middle inside.
int count_nodes(const LatticeGrid& grid, const Mesh& surface, const WindingNumber& winding) {
  const std::vector<char> touched = touched_cubes(grid, surface);
  std::vector<char> is_node(static_cast<std::size_t>(grid.num_nodes()), 0);
  for (int cube = 0; cube < grid.num_cubes(); ++cube) {
    if (!touched[static_cast<std::size_t>(cube)] && !winding.is_inside(grid.middle(cube))) continue;
    const auto [x, y, z] = grid.place_of(cube);
    for (int c = 0; c < 8; ++c)
      is_node[static_cast<std::size_t>(grid.node({x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)}))] = 1;
  }
  return static_cast<int>(std::ranges::count(is_node, 1));
}

/// The largest edge with about as many nodes as are wanted.
double find_edge(const Bounds& box, const Mesh& surface, const WindingNumber& winding, int nodes) {
  constexpr int kTries = 12;
  constexpr double kFinest = 1e-2;  // of the longest extent: a million cubes at most
  double high = box.size().maxCoeff(), low = kFinest * high;
  for (int i = 0; i < kTries; ++i) {
    const double middle = std::sqrt(low * high);
    (count_nodes(make_lattice_grid(box, middle), surface, winding) > nodes ? low : high) = middle;
  }
  return high;
}

// ---- how much of a cube is material ----

/// To which tetrahedra of a cube each sample counts, and how much: on their common faces to all of them alike.
struct SampleShares {
  std::array<std::vector<std::pair<int, double>>, kAllSamples> of;
  std::array<double, 6> all{};
  std::array<Vec3, kAllSamples> place;
  SampleShares() {
    for (int i = 0; i < kAllSamples; ++i) {
      const std::array<int, 3> at{i % kSamples, i / kSamples % kSamples, i / kSamples / kSamples};
      const auto s = static_cast<std::size_t>(i);
      place[s] = (Vec3(at[0], at[1], at[2]).array() + 0.5) / kSamples;
      for (int t = 0; t < 6; ++t) {
        const auto& axes = kKuhnAxes[static_cast<std::size_t>(t)];
        const auto along = [&](int k) { return at[static_cast<std::size_t>(axes[static_cast<std::size_t>(k)])]; };
        if (along(0) >= along(1) && along(1) >= along(2)) of[s].emplace_back(t, 1);
      }
      for (auto& [t, weight] : of[s]) {
        weight /= static_cast<double>(of[s].size());
        all[static_cast<std::size_t>(t)] += weight;
      }
    }
  }
};

struct CutCube {
  std::array<double, 6> share{};
  Samples samples;
  int unsure = 0, pieces = 0;
};

/// Connected pieces of the samples that are inside.
int count_pieces(Samples left) {
  int count = 0;
  std::vector<int> open;
  for (int seed = 0; seed < kAllSamples; ++seed) {
    if (!left[static_cast<std::size_t>(seed)]) continue;
    ++count;
    open.assign(1, seed);
    left.reset(static_cast<std::size_t>(seed));
    while (!open.empty()) {
      const int i = open.back();
      open.pop_back();
      for (const auto& [step, at] : {std::pair{1, i % kSamples}, std::pair{kSamples, i / kSamples % kSamples},
                                     std::pair{kSamples * kSamples, i / kSamples / kSamples}})
        for (const int other : {at > 0 ? i - step : -1, at + 1 < kSamples ? i + step : -1}) {
          if (other < 0 || !left[static_cast<std::size_t>(other)]) continue;
          left.reset(static_cast<std::size_t>(other));
          open.push_back(other);
        }
    }
  }
  return count;
}

/// Two cubes side by side have material, and none goes through their common face: the gap between is joined there.
/// @param axis  along which the second one follows the first
bool are_apart(const Samples& first, const Samples& second, int axis) {
  constexpr std::size_t kSome = kAllSamples / 10;
  if (first.count() < kSome || second.count() < kSome) return false;
  const std::array<int, 3> step{1, kSamples, kSamples * kSamples};
  const int along = step[static_cast<std::size_t>(axis)], a = step[static_cast<std::size_t>((axis + 1) % 3)],
            b = step[static_cast<std::size_t>((axis + 2) % 3)];
  for (int i = 0; i < kSamples; ++i)
    for (int j = 0; j < kSamples; ++j) {
      const int low = i * a + j * b, high = low + (kSamples - 1) * along;
      if (first[static_cast<std::size_t>(high)] && second[static_cast<std::size_t>(low)]) return false;
    }
  return true;
}

CutCube sample(const LatticeGrid& grid, int cube, const SampleShares& shares, const WindingNumber& winding) {
  CutCube out;
  const Vec3 corner = grid.corner(grid.place_of(cube));
  for (std::size_t s = 0; s < kAllSamples; ++s) {
    const double turns = std::abs(winding.at(corner + grid.edge.cwiseProduct(shares.place[s])));
    out.unsure += turns > 0.25 && turns < 0.75;
    if (turns <= 0.5) continue;
    out.samples.set(s);
    for (const auto& [t, weight] : shares.of[s]) out.share[static_cast<std::size_t>(t)] += weight;
  }
  for (std::size_t t = 0; t < 6; ++t) out.share[t] /= shares.all[t];
  out.pieces = count_pieces(out.samples);
  return out;
}

// ---- the lattice ----

class LatticeMaker {
 public:
  LatticeMaker(const LatticeGrid& grid, const Mesh& surface, const WindingNumber& winding, LatticeReport& report)
      : grid_(grid), surface_(surface), share_(static_cast<std::size_t>(grid.num_cubes()), std::array<double, 6>{}) {
    fill(winding, report);
    embed();
    report.volume = volume_;
  }

  Mesh mesh() {
    auto embedded = std::make_shared<EmbeddedSurface>();
    Mesh out;
    std::vector<int> number(static_cast<std::size_t>(grid_.num_nodes()), -1);
    for (int cube = 0; cube < grid_.num_cubes(); ++cube)
      for (int t = 0; t < 6; ++t)
        if (share_of(cube, t) > 0)
          for (const int i : corners_of(cube, t)) number[static_cast<std::size_t>(i)] = 0;
    int nodes = 0;
    for (int& n : number)
      if (n == 0) n = nodes++;
    out.x.resize(3 * nodes + surface_.x.size());
    for (int i = 0; i < grid_.num_nodes(); ++i)
      if (const int n = number[static_cast<std::size_t>(i)]; n >= 0) {
        const int wide = grid_.count[0] + 1, high = grid_.count[1] + 1;
        node(out.x, n) = grid_.corner({i % wide, i / wide % high, i / wide / high});
      }
    std::vector<int> cell_number(6 * share_.size(), -1);
    const auto numbered = [&](std::array<int, 4> corners) {
      for (int& i : corners) i = number[static_cast<std::size_t>(i)];
      return corners;
    };
    for (int cube = 0; cube < grid_.num_cubes(); ++cube)
      for (int t = 0; t < 6; ++t)
        if (share_of(cube, t) > 0) {
          cell_number[static_cast<std::size_t>(6 * cube + t)] = static_cast<int>(out.tetrahedra.size());
          out.tetrahedra.push_back(numbered(corners_of(cube, t)));
          embedded->share.push_back(share_of(cube, t));
        }
    out.x.tail(surface_.x.size()) = surface_.x;
    for (const Triangle& t : surface_.triangles) out.triangles.push_back({t[0] + nodes, t[1] + nodes, t[2] + nodes});
    embedded->first = nodes;
    embedded->edge = grid_.edge.mean();
    for (const auto& corners : corners_) embedded->corners.push_back(numbered(corners));
    for (const int c : cell_) embedded->cell.push_back(cell_number[static_cast<std::size_t>(c)]);
    embedded->weights = std::move(weights_);
    embedded->samples = std::move(samples_);
    embedded->group_triangles(out.triangles);
    out.embedded = std::move(embedded);
    return out;
  }

 private:
  double& share_of(int cube, int t) { return share_[static_cast<std::size_t>(cube)][static_cast<std::size_t>(t)]; }
  std::array<int, 4> corners_of(int cube, int t) const {
    const auto at = grid_.place_of(cube);
    std::array<int, 4> out{};
    const auto steps = kuhn_corners(t);
    for (std::size_t c = 0; c < 4; ++c)
      out[c] = grid_.node({at[0] + steps[c][0], at[1] + steps[c][1], at[2] + steps[c][2]});
    return out;
  }

  void fill(const WindingNumber& winding, LatticeReport& report) {
    const std::vector<char> touched = touched_cubes(grid_, surface_);
    const SampleShares shares;
    std::vector<CutCube> cut(touched.size());
    parallel_for(grid_.num_cubes(), [&](int cube) {
      const auto i = static_cast<std::size_t>(cube);
      if (touched[i])
        cut[i] = sample(grid_, cube, shares, winding);
      else if (winding.is_inside(grid_.middle(cube))) {
        cut[i].share.fill(1);
        cut[i].samples.set();
      }
    });
    samples_.origin = grid_.origin;
    samples_.spacing = grid_.edge / kSamples;
    for (std::size_t c = 0; c < 3; ++c) samples_.count[c] = kSamples * grid_.count[c];
    samples_.is_inside.assign(cut.size() * kAllSamples, false);
    int unsure = 0, inside = 0;
    const double volume = grid_.edge.prod() / 6;
    for (std::size_t i = 0; i < cut.size(); ++i) {
      share_[i] = cut[i].share;
      for (const double share : cut[i].share) volume_ += share * volume;
      unsure += cut[i].unsure;
      if (touched[i]) inside += static_cast<int>(cut[i].samples.count());
      keep_samples(static_cast<int>(i), cut[i].samples);
      report.cut_cubes += touched[i] != 0;
      report.joining_cubes += joins(cut, static_cast<int>(i));
    }
    report.unsure = static_cast<double>(unsure) / std::max(1, inside);
  }

  /// Whether a cube, or its face to the next one along an axis, joins what is apart.
  bool joins(const std::vector<CutCube>& cut, int cube) const {
    const CutCube& own = cut[static_cast<std::size_t>(cube)];
    if (own.pieces > 1) return true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      auto next = grid_.place_of(cube);
      if (++next[axis] == grid_.count[axis]) continue;
      if (are_apart(own.samples, cut[static_cast<std::size_t>(grid_.cube(next))].samples, static_cast<int>(axis)))
        return true;
    }
    return false;
  }

  void keep_samples(int cube, const Samples& inside) {
    const auto corner = grid_.place_of(cube);
    for (int s = 0; s < kAllSamples; ++s)
      samples_.is_inside[samples_.index(
          {kSamples * corner[0] + s % kSamples, kSamples * corner[1] + s / kSamples % kSamples,
           kSamples * corner[2] + s / kSamples / kSamples})] = inside[static_cast<std::size_t>(s)];
  }

  /// Each vertex goes with the tetrahedron just below it: on a face between two the one with the material.
  void embed() {
    constexpr double kBelow = 0.02;  // of an edge
    const VectorX normals = node_normals(surface_.x, surface_.triangles);
    for (int v = 0; v < surface_.num_nodes(); ++v) {
      const Vec3 place = node(surface_.x, v), below = place - kBelow * grid_.edge.minCoeff() * node(normals, v);
      const auto at = grid_.holding(below);
      const Vec3 corner = grid_.corner(at);
      const int cube = grid_.cube(at), t = kuhn_holding((below - corner).cwiseQuotient(grid_.edge));
      cell_.push_back(6 * cube + t);
      corners_.push_back(corners_of(cube, t));
      weights_.push_back(kuhn_weights(t, (place - corner).cwiseQuotient(grid_.edge)));
      share_of(cube, t) = std::max(share_of(cube, t), kLeastShare);
    }
  }

  const LatticeGrid& grid_;
  const Mesh& surface_;
  std::vector<std::array<double, 6>> share_;  // of each cube's tetrahedra
  std::vector<std::array<int, 4>> corners_;   // of the lattice, that each vertex goes with
  std::vector<std::array<double, 4>> weights_;
  std::vector<int> cell_;  // its tetrahedron among the six of every cube
  MaterialSamples samples_;
  double volume_ = 0;
};

}  // namespace

std::vector<std::string> LatticeReport::lines() const {
  std::vector<std::string> out{text("object.body lattice: ", nodes, " nodes, ", tetrahedra, " tetrahedra in cubes of ",
                                    short_number(1e3 * edge), " mm, ", short_number(1e6 * volume), " cm3 of material")};
  std::vector<std::string> assumed;
  if (open_edges > 0)
    assumed.push_back(text(open_edges, " open edges closed by winding number, ", short_number(100 * unsure),
                           " % of the volume near the surface unsure"));
  if (turned > 0) assumed.push_back(text(turned, " triangles turned to face outward"));
  if (degenerate > 0) assumed.push_back(text(degenerate, " triangles without area left out"));
  for (std::size_t i = 0; i < assumed.size(); ++i) {
    if (i == 0) out.push_back("object.body lattice: ");
    out.back() += (i > 0 ? ", " : "") + assumed[i];
  }
  if (joining_cubes > 0)
    out.push_back(text("object.body lattice: ", joining_cubes, " of ", cut_cubes,
                       " cubes join pieces of the surface that are apart in them: a gap narrower than ",
                       short_number(1e3 * edge), " mm does not open; lower object.lattice.edge"));
  return out;
}

Mesh make_lattice(const Mesh& surface, const LatticeOptions& options, LatticeReport* report) {
  LatticeReport own;
  LatticeReport& said = report ? *report : own;
  const Mesh clean = clean_surface(surface, said);
  if (clean.triangles.empty()) throw InputError(text(options.name, ": no triangle has an area: there is no body"));
  const Mesh turned = turn_outward(clean, said);
  const WindingNumber winding(turned);
  const Bounds box = bounds(clean);
  constexpr double kEmpty = 0.8;  // of the corners of these cubes, those of tetrahedra with material in them
  const int corners = static_cast<int>(options.nodes / kEmpty);
  const double edge = options.edge > 0 ? options.edge : find_edge(box, turned, winding, corners);
  const Vec3 cubes = (box.size() / edge).cwiseMax(1);
  if (!(cubes.prod() <= 50.0 * kMostLatticeNodes))
    throw InputError(text("object.lattice.edge: ", edge, " m makes ", short_number(cubes.prod()),
                          " cubes of the body's box, at most ", 50 * kMostLatticeNodes, ": enlarge it"));
  const LatticeGrid grid = make_lattice_grid(box, edge);
  const Mesh surface_in_it = with_short_edges(turned, options.longest * grid.edge.minCoeff());
  Mesh out = LatticeMaker(grid, surface_in_it, winding, said).mesh();
  said.nodes = out.num_own_nodes();
  said.tetrahedra = static_cast<int>(out.tetrahedra.size());
  said.edge = grid.edge.mean();
  if (!(said.volume > 0))
    throw InputError(text(options.name,
                          ": the surface holds no material: nowhere does it wind around a place more "
                          "than half a time; object.body lattice needs a surface that closes, nearly"));
  if (said.nodes > kMostLatticeNodes)
    throw InputError(text("object.lattice.edge: ", edge, " m makes ", said.nodes, " nodes, at most ", kMostLatticeNodes,
                          ": enlarge it"));
  return out;
}

}  // namespace kt
