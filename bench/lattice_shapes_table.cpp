// Bodies in a lattice against fine meshes of ten-node tetrahedra: deflection under a load on their upper end, and the
// first three frequencies, of a bar, a plate thinner than a cube, a tube, and a bar with a slit thinner than a cube.
//   lattice_shapes_table [NODES ...]      (600 1500)
// All are 80 mm high, clamped below and turned about their height, so that cubes are cut along all sides; 10 kPa, nu =
// 0.3, 1000 kg/m^3.
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>
#include <span>

#include "core/contact_surface/contact_surface.hpp"
#include "core/linear/free_dofs.hpp"
#include "haptics/body/body.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/mesh/weld.hpp"

namespace kt {
namespace {

constexpr double kHeight = 0.08;

// ---- shapes ----

template <class Map>
Mesh mapped(Mesh mesh, const Map& map) {
  const Mat3 turn = Eigen::AngleAxisd(0.5, Vec3::UnitZ()).toRotationMatrix();
  for (int i = 0; i < mesh.num_nodes(); ++i) node(mesh.x, i) = turn * map(Vec3(node(mesh.x, i)));
  return mesh;
}

/// Of unit cells along x, y, z.
Mesh box(int x, int y, int z, const Vec3& size) {
  return mapped(kuhn_block(x, y, z, 1),
                [&](const Vec3& p) { return Vec3(p.cwiseProduct(size).cwiseQuotient(Vec3(x, y, z))); });
}

Mesh tube(double outer, double inner) {
  constexpr int kAround = 32, kThrough = 2, kUp = 20;
  Mesh out = mapped(kuhn_block(kThrough, kAround, kUp, 1), [&](const Vec3& p) {
    const double angle = 2 * std::numbers::pi * std::fmod(p.y(), kAround) / kAround;
    const double radius = inner + (outer - inner) * p.x() / kThrough;
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), kHeight * p.z() / kUp);
  });
  join_nodes(out, 0);
  drop_unused_nodes(out);
  out.triangles = boundary_triangles(out.tetrahedra);
  return out;
}

Mesh slit_bar() {
  constexpr int kColumns = 9, kSlit = 4, kUp = 24, kBottom = 6;
  constexpr double kGap = 2e-4, kWide = 0.02;
  Mesh block = kuhn_block(kColumns, 8, kUp, 1);
  std::erase_if(block.tetrahedra, [&](const Tetrahedron& t) {
    return std::ranges::all_of(t, [&](int i) {
      return block.x[3 * i] > kSlit - 0.5 && block.x[3 * i] < kSlit + 1.5 && block.x[3 * i + 2] > kBottom - 0.5;
    });
  });
  block.triangles = boundary_triangles(block.tetrahedra);
  return mapped(std::move(block), [&](const Vec3& p) {
    const double x = p.x() < kSlit + 0.5 ? p.x() : p.x() - 1;
    return Vec3(kWide * x / 8 + (p.x() > kSlit + 0.5 ? kGap : 0), kWide * p.y() / 8, kHeight * p.z() / kUp);
  });
}

// ---- what they do ----

struct Answer {
  double deflection = 0, made_s = 0, factored_ms = 0;
  std::array<double, 3> hz{};
  int nodes = 0;
};

/// Subspace iteration (Bathe 1971).
std::array<double, 3> frequencies(const SparseMatrix& M, const Eigen::SimplicialLDLT<SparseMatrix>& inverse) {
  constexpr int kVectors = 8, kSteps = 20;
  std::mt19937_64 random(7);
  MatrixX x(M.rows(), kVectors);
  for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = std::uniform_real_distribution<>(-1, 1)(random);
  Eigen::VectorXd values;
  for (int step = 0; step < kSteps; ++step) {
    const MatrixX Mx = M * x, y = inverse.solve(Mx);
    const MatrixX stiffness = y.transpose() * Mx, mass = y.transpose() * (M * y);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixX> solver(0.5 * (stiffness + stiffness.transpose()),
                                                                   0.5 * (mass + mass.transpose()));
    values = solver.eigenvalues();
    x = y * solver.eigenvectors();
  }
  std::array<double, 3> out{};
  for (Eigen::Index i = 0; i < 3; ++i) out[static_cast<std::size_t>(i)] = std::sqrt(values[i]) / (2 * std::numbers::pi);
  return out;
}

/// @param loads  which places of the upper end
template <class Loads>
Answer answer(const Mesh& mesh, const BodyOptions& options, const Vec3& direction, const Loads& loads) {
  const auto begin = std::chrono::steady_clock::now();
  const Body body(mesh, options);
  Answer out;
  out.made_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const DeformableModel& own = body.model().own();
  out.nodes = own.mesh().num_nodes();
  const FreeDofs dofs = make_free_dofs(out.nodes, own.fixed_nodes());
  const auto start = std::chrono::steady_clock::now();
  const SparseMatrix K = gather(dofs, SparseMatrix(-own.tangent(rest_state(own), TangentKind::exact).dfdx));
  const SparseMatrix M = gather(dofs, own.mass());
  const Eigen::SimplicialLDLT<SparseMatrix> inverse(K);
  out.factored_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();

  const Surface& surface = body.surface();
  const VectorX& rest = body.model().mesh().x;
  const Vec3 third = Vec3::Constant(1.0 / 3);
  VectorX force = VectorX::Zero(rest.size());
  double area = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& v = surface.triangles[t];
    if (!std::ranges::all_of(v, [&](int i) { return loads(Vec3(node(rest, i))); })) continue;
    const Vec3 a = node(rest, v[0]);
    const double its = 0.5 * (node(rest, v[1]) - a).cross(node(rest, v[2]) - a).norm();
    moved_by(surface, {}, static_cast<int>(t), third).add_to(force, its * direction);
    area += its;
  }
  const VectorX load = gather(dofs, force) / area;
  out.deflection = load.dot(VectorX(inverse.solve(load)));
  out.hz = frequencies(M, inverse);
  return out;
}

void print(const char* name, const Mesh& fine, const Vec3& direction, double part, std::span<const int> nodes) {
  BodyOptions options;
  options.object.mesh = name;
  options.object.model.type = "fem";
  options.object.model.material = "linear";
  options.object.model.poisson = 0.3;
  const Mat3 turn = Eigen::AngleAxisd(0.5, Vec3::UnitZ()).toRotationMatrix();
  const Vec3 side = turn * direction;
  const auto loads = [&](const Vec3& place) {
    return place.z() > kHeight - 1e-6 && (part <= 0 || side.dot(place) < part + 1e-6);
  };
  options.object.fixed.below = FixedBelow{"z", 1e-6};
  BodyOptions solid = options;
  solid.object.model.element = "tet10";
  const Answer truth = answer(fine, solid, side, loads);
  Mesh surface = fine;
  surface.tetrahedra.clear();
  for (const int n : nodes)
    for (const char* element : {"tet4", "tet10", "hex8"}) {
      BodyOptions lattice = options;
      lattice.object.body = "lattice";
      lattice.object.lattice = SceneLattice{{}, n};
      lattice.object.model.element = element;
      const Answer its = answer(surface, lattice, side, loads);
      std::printf("| %s | %d | %s, %d | %.2f | %.1f | %.2f | %.2f %.2f %.2f | %.1f %.1f %.1f |\n", name, truth.nodes,
                  element, its.nodes, its.made_s, its.factored_ms, its.deflection / truth.deflection,
                  its.hz[0] / truth.hz[0], its.hz[1] / truth.hz[1], its.hz[2] / truth.hz[2], truth.hz[0], truth.hz[1],
                  truth.hz[2]);
      std::fflush(stdout);
    }
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  std::vector<int> nodes;
  for (int i = 1; i < argc; ++i) nodes.push_back(std::atoi(argv[i]));
  if (nodes.empty()) nodes = {600, 1500};
  std::puts(
      "| shape | nodes of the mesh | of the lattice | made s | tangent and factor, ms | deflection over the mesh's | "
      "frequencies | Hz |");
  std::puts("|---|---|---|---|---|---|---|---|");
  using kt::Vec3;
  kt::print("bar 20 x 20 mm", kt::box(8, 8, 24, Vec3(0.02, 0.02, kt::kHeight)), Vec3::UnitX(), 0, nodes);
  kt::print("plate 4 x 60 mm", kt::box(2, 16, 20, Vec3(0.004, 0.06, kt::kHeight)), Vec3::UnitX(), 0, nodes);
  kt::print("tube 24 mm, wall 4 mm", kt::tube(0.012, 0.008), Vec3::UnitX(), 0, nodes);
  kt::print("bar with a slit of 0.2 mm, one arm", kt::slit_bar(), Vec3::UnitX(), 0.01, nodes);
}
