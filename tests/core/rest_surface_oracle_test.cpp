// The smooth surface over refined cells: Loop's over the body at rest, turned with the body.
#include "core/contact_surface/rest_surface.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "core/contact_surface/contact_surface.hpp"
#include "core/contact_surface/subdivision.hpp"
#include "core/fine/fine_size.hpp"
#include "core/fine/make_fine_patch.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

constexpr double kOuter = 0.05;  // radius of the arch [m]

/// A block bent to an arch around the y axis: its top's cells are 10 mm wide and meet at 11 degrees.
Mesh arch(double shift = 0) {
  Mesh out = kuhn_block(10, 6, 2, 0.01);
  for (int i = 0; i < out.num_nodes(); ++i) {
    const Vec3 p = node(out.x, i);
    const double angle = (p.x() - 0.05) / kOuter, r = kOuter - 0.02 + p.z();
    node(out.x, i) =
        Vec3(r * std::sin(angle), p.y() + shift * std::sin(900 * p.x()) * std::cos(700 * p.y()), r * std::cos(angle));
  }
  return out;
}

/// At the vertices of `levels` refinements of the whole surface, Loop's limit of points x + (1 - S) x + (1 - S)^2 x, by
/// triangle and weights.
void expect_on_limit(const Mesh& mesh, int levels, double regular, double irregular) {
  const Surface surface = make_surface(mesh);
  RestSurface rest(surface, mesh.x);
  std::vector<std::array<bool, 3>> sharp;
  for (const auto& c : surface.crease)
    sharp.push_back({c[0] != Crease::none, c[1] != Crease::none, c[2] != Crease::none});
  const Subdivision s = subdivide_loop(surface.triangles, mesh.num_nodes(), sharp, levels);
  const auto limit = [&](int v, const VectorX& of) {
    Vec3 out = Vec3::Zero();
    for (int k = s.first[v]; k < s.first[v + 1]; ++k) out += s.weight[k] * node(of, s.from[k]);
    return out;
  };
  VectorX missed = mesh.x, control = mesh.x;
  for (int i = 0; i < 2; ++i) {
    const VectorX before = missed;
    for (int v = 0; v < mesh.num_nodes(); ++v) node(missed, v) -= limit(v, before);
    control += missed;
  }
  const auto is_regular = [&](const Triangle& t) {
    return std::ranges::all_of(t, [&](int v) { return surface.topology.triangles_of(v).size() == 6; }) &&
           std::ranges::none_of(t, [&](int v) {
             return std::ranges::any_of(surface.topology.triangles_of(v), [&](int around) {
               return std::ranges::any_of(sharp[static_cast<std::size_t>(around)], std::identity());
             });
           });
  };
  const int pieces = 1 << (2 * levels);
  int regulars = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (int piece = 0; piece < pieces; ++piece)
      for (int c = 0; c < 3; ++c) {
        const int v = s.triangles[t * static_cast<std::size_t>(pieces) + static_cast<std::size_t>(piece)]
                                 [static_cast<std::size_t>(c)];
        const Vec3 truth = limit(v, control);
        Vec3 flat = Vec3::Zero();
        const Vec3 bary = weights_in_triangle(piece, levels, Vec3::Unit(c));
        for (int k = 0; k < 3; ++k) flat += bary[k] * node(mesh.x, surface.triangles[t][static_cast<std::size_t>(k)]);
        const bool exact = is_regular(surface.triangles[t]);
        regulars += exact;
        ASSERT_LT((flat + rest.offset(static_cast<int>(t), bary) - truth).norm(), exact ? regular : irregular) << t;
      }
  EXPECT_GT(regulars, 1000);
}

// On a triangle with six neighbours to each vertex Loop's surface is a quartic, so that 15 places of it give all;
// elsewhere they miss 0.2 % of an edge.
TEST(RestSurface, IsLoopsLimit) { expect_on_limit(arch(0.0008), 3, 1e-14, 3e-5); }

TEST(RestSurface, OfAFlatFaceOfEqualCellsIsTheFace) {
  const Mesh mesh = kuhn_block(8, 8, 2, 0.01);
  const Surface surface = make_surface(mesh);
  RestSurface rest(surface, mesh.x);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& v = surface.triangles[t];
    const Vec3 a = node(mesh.x, v[0]), normal = (node(mesh.x, v[1]) - a).cross(node(mesh.x, v[2]) - a).normalized();
    EXPECT_LT(std::abs(rest.offset(static_cast<int>(t), {0.2, 0.3, 0.5}).dot(normal)), 1e-16);
  }
}

TEST(RestSurface, HasOnePlaceForAnEdgeOfTwoTriangles) {
  const Mesh mesh = arch(0.0008);
  const Surface surface = make_surface(mesh);
  RestSurface rest(surface, mesh.x);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const int other = surface.topology.across[t][c];
      if (other < 0) continue;
      const Triangle &a = surface.triangles[t], &b = surface.triangles[static_cast<std::size_t>(other)];
      Vec3 here = Vec3::Zero(), there = Vec3::Zero();
      here[static_cast<Eigen::Index>(c)] = 0.3;
      here[static_cast<Eigen::Index>((c + 1) % 3)] = 0.7;
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t m = 0; m < 3; ++m)
          if (b[m] == a[k]) there[static_cast<Eigen::Index>(m)] = here[static_cast<Eigen::Index>(k)];
      EXPECT_LT((rest.offset(static_cast<int>(t), here) - rest.offset(other, there)).norm(), 1e-15);
    }
}

struct RefinedArch {
  RefinedArch() : mesh(arch()) {
    ModelOptions options{.material = "linear"};
    for (int i = 0; i < mesh.num_nodes(); ++i)
      if (node(mesh.x, i).z() < 0.02) options.fixed_nodes.push_back(i);
    model = make_model("fem", mesh, options);
    surface = make_surface(mesh);
    const FineBody body = make_fine_body(*model, *told_by(*model));
    const FineZone zone = make_fine_zone(body, fine_options(body, {Vec3(0.002, 0.031, kOuter), 0.0035}, 1.4));
    const State rest = rest_state(*model);
    const auto solver = make_block_solver();
    fine = make_fine_patch(body, zone, surface.triangles,
                           find_yield(body, zone, {rest}, model->tangent(rest, TangentKind::symmetric).dfdx, *solver));
    RestSurface(surface, mesh.x).raise(*fine);
    patch = make_patch(surface, mesh.x, {Vec3(0.002, 0.031, kOuter), 0, 0.04});
    for (const int i : patch.global_node) {
      x.conservativeResize(x.size() + 3);
      x.tail<3>() = node(mesh.x, i);
    }
  }
  /// Vertices of refined facets away from their edge, in a body that is where x has it.
  VectorX placed(const VectorX& at, bool smooth) const {
    ContactSurface s = make_contact_surface(patch, {}, fine);
    if (smooth) turn_offsets(patch, at, s);
    VectorX moving = VectorX::Zero(3 * static_cast<Eigen::Index>(s.num_moving())),
            out(3 * static_cast<Eigen::Index>(s.facets.num_vertices()));
    moving.head(at.size()) = at;
    s.place(moving, out);
    return out;
  }
  Mesh mesh;
  std::unique_ptr<DeformableModel> model;
  Surface surface;
  std::shared_ptr<FinePatch> fine;
  SurfacePatch patch;
  VectorX x;  // of the patch's vertices
};

TEST(RestSurface, PassesByTheNodes) {
  const Mesh mesh = arch();
  const Surface surface = make_surface(mesh);
  RestSurface rest(surface, mesh.x);
  double at_nodes = 0, at_edges = 0;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const bool is_inner = std::ranges::all_of(surface.triangles[t], [&](int v) {
      const Vec3 p = node(mesh.x, v);
      return std::hypot(p.x(), p.z()) > kOuter - 1e-6 && std::abs(p.x()) < 0.7 * kOuter &&
             std::abs(p.y() - 0.03) < 0.015;
    });
    if (!is_inner) continue;
    at_nodes = std::max(at_nodes, rest.offset(static_cast<int>(t), Vec3::UnitX()).norm());
    at_edges = std::max(at_edges, rest.offset(static_cast<int>(t), {0.5, 0.5, 0}).norm());
  }
  EXPECT_GT(at_edges, 1e-4);
  EXPECT_LT(at_nodes, 0.05 * at_edges);
}

// An arch of radius 50 mm whose triangles are up to 0.25 mm inside it: the smooth surface is the arch, to a twentieth
// of that.
TEST(RestSurface, RefinedVerticesLieOnIt) {
  const RefinedArch b;
  const ContactSurface s = make_contact_surface(b.patch, {}, b.fine);
  ContactSurface raised = s;
  turn_offsets(b.patch, b.x, raised);
  const VectorX flat = b.placed(b.x, false), smooth = b.placed(b.x, true);
  const auto spread = [&](const VectorX& at) {
    double least = kOuter, most = 0;
    for (int v = s.num_nodes; v < s.facets.num_vertices(); ++v) {
      if (raised.offset.segment<3>(3 * v).norm() == 0) continue;  // at the edge
      const double r = std::hypot(at[3 * v], at[3 * v + 2]);
      least = std::min(least, r);
      most = std::max(most, r);
    }
    return most - least;
  };
  EXPECT_GT(spread(flat), 2e-4);
  EXPECT_LT(spread(smooth), 1e-5);
}

TEST(RestSurface, TurnsWithTheBody) {
  const RefinedArch b;
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const VectorX before = b.placed(b.x, true);
  VectorX x = b.x;
  for (Eigen::Index i = 0; i < x.size(); i += 3) x.segment<3>(i) = turn * b.x.segment<3>(i) + Vec3(0.1, 0, 0.2);
  const VectorX after = b.placed(x, true);
  for (Eigen::Index i = 0; i < after.size(); i += 3)
    EXPECT_LT((after.segment<3>(i) - (turn * before.segment<3>(i) + Vec3(0.1, 0, 0.2))).norm(), 1e-15);
}

}  // namespace
}  // namespace kt
