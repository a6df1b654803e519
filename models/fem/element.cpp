#include "models/fem/element.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"

namespace kt {
namespace {

constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/// Gradients of the barycentric coordinates, (3 x 4) [1/m]. `index` for the message.
Eigen::Matrix<double, 3, 4> barycentric_gradients(const Mesh& mesh, const Tetrahedron& t, std::size_t index) {
  Mat3 edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = node(mesh.x, t[i + 1]) - node(mesh.x, t[0]);
  if (!(edges.determinant() > 0))
    throw InputError(text("fem: tetrahedron ", index, " has volume ", edges.determinant() / 6, " m^3: must be > 0"));
  Eigen::Matrix<double, 3, 4> out;
  out.rightCols<3>() = edges.inverse().transpose();
  out.col(0) = -out.rightCols<3>().rowwise().sum();
  return out;
}

/// Of a place with weights `bary` of the corners.
ElementTable<10>::Point quadratic_point(const Eigen::Matrix<double, 3, 4>& grad, const Eigen::Vector4d& bary,
                                        double volume) {
  ElementTable<10>::Point out;
  out.volume = volume;
  for (int i = 0; i < 4; ++i) out.gradient.col(i) = (4 * bary[i] - 1) * grad.col(i);
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = kEdges[e];
    out.gradient.col(4 + e) = 4 * (bary[i] * grad.col(j) + bary[j] * grad.col(i));
  }
  return out;
}

Eigen::Matrix<double, 10, 1> quadratic_shapes(const Eigen::Vector4d& bary) {
  Eigen::Matrix<double, 10, 1> out;
  for (int i = 0; i < 4; ++i) out[i] = bary[i] * (2 * bary[i] - 1);
  for (int e = 0; e < 6; ++e) out[4 + e] = 4 * bary[kEdges[e][0]] * bary[kEdges[e][1]];
  return out;
}

std::array<int, 2> key(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

/// Nodes that no tetrahedron has as a corner, by the edge in whose middle they are; empty: not every edge has one.
std::map<std::array<int, 2>, int> middles_of(const Mesh& mesh) {
  std::vector<char> is_corner(static_cast<std::size_t>(mesh.num_nodes()), 0);
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const int i : t) is_corner[static_cast<std::size_t>(i)] = 1;
  const auto place = [](const Vec3& p) { return std::array{p.x(), p.y(), p.z()}; };
  std::map<std::array<double, 3>, int> others;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (!is_corner[static_cast<std::size_t>(i)]) others.emplace(place(node(mesh.x, i)), i);
  std::map<std::array<int, 2>, int> out;
  if (others.empty()) return out;
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const auto& [i, j] : kEdges) {
      const auto found = others.find(place(0.5 * (node(mesh.x, t[i]) + node(mesh.x, t[j]))));
      if (found == others.end()) return {};
      out.emplace(key(t[i], t[j]), found->second);
    }
  return out;
}

}  // namespace

ElementTable<4> make_linear_elements(Mesh mesh) {
  ElementTable<4> out;
  out.points_per_element = 1;
  out.mesh = std::move(mesh);
  for (const Tetrahedron& t : out.mesh.tetrahedra) {
    out.points.push_back({barycentric_gradients(out.mesh, t, out.nodes.size()), tetrahedron_volume(out.mesh.x, t)});
    out.nodes.push_back(t);
  }
  return out;
}

ElementTable<10> make_quadratic_elements(const Mesh& mesh) {
  ElementTable<10> out;
  out.mesh = mesh;
  // Ordered: the numbering does not depend on a hash. A mesh that has its middles already, as that of a model which is
  // made again of another material, keeps them.
  std::map<std::array<int, 2>, int> middle = middles_of(mesh);
  const bool has_middles = !middle.empty();
  std::vector<Vec3> added;
  const auto middle_of = [&](int a, int b) {
    const auto [it, is_new] = middle.try_emplace(key(a, b), mesh.num_nodes() + static_cast<int>(added.size()));
    if (is_new) added.push_back(0.5 * (node(mesh.x, a) + node(mesh.x, b)));
    return it->second;
  };

  // Four points, exact for polynomials of degree two.
  constexpr double kNear = 0.58541019662496845, kFar = 0.13819660112501051;
  out.points_per_element = 4;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    const auto grad = barycentric_gradients(mesh, t, out.nodes.size());
    const double volume = tetrahedron_volume(mesh.x, t);
    std::array<int, 10> nodes{t[0], t[1], t[2], t[3]};
    for (int e = 0; e < 6; ++e) nodes[4 + e] = middle_of(t[kEdges[e][0]], t[kEdges[e][1]]);
    out.nodes.push_back(nodes);
    for (int q = 0; q < 4; ++q) {
      Eigen::Vector4d bary = Eigen::Vector4d::Constant(kFar);
      bary[q] = kNear;
      out.points.push_back(quadratic_point(grad, bary, volume / 4));
    }
  }

  if (has_middles) return out;  // its triangles are in quarters
  std::vector<Triangle> faces;
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middle_of(a, b), bc = middle_of(b, c), ca = middle_of(c, a);
    faces.insert(faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  out.mesh.triangles = std::move(faces);
  out.mesh.x.conservativeResize(3 * (mesh.num_nodes() + static_cast<int>(added.size())));
  for (std::size_t i = 0; i < added.size(); ++i) node(out.mesh.x, mesh.num_nodes() + static_cast<int>(i)) = added[i];
  return out;
}

ElementTable<4> make_embedded_linear_elements(Mesh cells, const EmbeddedSurface& surface) {
  ElementTable<4> out = make_linear_elements(std::move(cells));
  for (std::size_t e = 0; e < surface.share.size(); ++e) out.points[e].volume *= surface.share[e];
  return out;
}

ElementTable<10> make_embedded_quadratic_elements(Mesh cells, const EmbeddedSurface& surface) {
  ElementTable<10> out;
  out.mesh = std::move(cells);
  out.points_per_element = 4;
  for (std::size_t c = 0; c < out.mesh.tetrahedra.size(); ++c) {
    const Tetrahedron& t = out.mesh.tetrahedra[c];
    const auto grad = barycentric_gradients(out.mesh, t, c);
    const double volume = surface.share[c] * tetrahedron_volume(out.mesh.x, t);
    std::array<int, 10>& nodes = out.nodes.emplace_back();
    std::copy(t.begin(), t.end(), nodes.begin());
    std::copy(surface.middles[c].begin(), surface.middles[c].end(), nodes.begin() + 4);
    Eigen::Matrix<double, 10, 1>& lumped = out.lumped.emplace_back(Eigen::Matrix<double, 10, 1>::Zero());
    for (int q = 0; q < 4; ++q) {
      const Eigen::Vector4d bary = surface.points[c].col(q);
      out.points.push_back(quadratic_point(grad, bary, volume / 4));
      lumped += quadratic_shapes(bary).cwiseAbs2();
    }
    lumped /= lumped.sum();
  }
  return out;
}

ElementTable<8> make_cubes(const ElementTable<4>& tetrahedra, const std::vector<int>& cube) {
  ElementTable<8> out;
  out.mesh = tetrahedra.mesh;
  out.points_per_element = 1;
  for (std::size_t e = 0; e < cube.size();) {
    std::map<int, Vec3> sum;  // of the gradients, by node
    double volume = 0;
    const int its = cube[e];
    for (; e < cube.size() && cube[e] == its; ++e) {
      const auto& point = tetrahedra.points[e];
      for (int a = 0; a < 4; ++a)
        sum.try_emplace(tetrahedra.nodes[e][a], Vec3::Zero()).first->second += point.volume * point.gradient.col(a);
      volume += point.volume;
    }
    KT_ASSERT(sum.size() <= 8);
    std::array<int, 8> nodes;
    nodes.fill(sum.begin()->first);
    ElementTable<8>::Point point{Eigen::Matrix<double, 3, 8>::Zero(), volume};
    for (int a = 0; const auto& [i, gradient] : sum) {
      nodes[static_cast<std::size_t>(a)] = i;
      point.gradient.col(a++) = gradient / volume;
    }
    out.nodes.push_back(nodes);
    out.points.push_back(point);
  }
  return out;
}

std::vector<double> mean_of_cubes(const std::vector<double>& of_tetrahedra, const ElementTable<4>& tetrahedra,
                                  const std::vector<int>& cube) {
  if (of_tetrahedra.empty()) return {};
  std::vector<double> sum(static_cast<std::size_t>(cube.back()) + 1, 0.0), volume = sum;
  for (std::size_t e = 0; e < cube.size(); ++e) {
    sum[cube[e]] += of_tetrahedra[e] * tetrahedra.points[e].volume;
    volume[cube[e]] += tetrahedra.points[e].volume;
  }
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] /= volume[c];
  return sum;
}

std::vector<int> fixed_with_edges(const ElementTable<10>& elements, const std::vector<int>& fixed) {
  std::vector<char> is_fixed(static_cast<std::size_t>(elements.mesh.num_nodes()), 0);
  for (int i : fixed) is_fixed[i] = 1;
  for (const auto& nodes : elements.nodes)
    for (int e = 0; e < 6; ++e)
      if (is_fixed[nodes[kEdges[e][0]]] && is_fixed[nodes[kEdges[e][1]]]) is_fixed[nodes[4 + e]] = 1;
  std::vector<int> out;
  for (int i = 0; i < elements.mesh.num_nodes(); ++i)
    if (is_fixed[i]) out.push_back(i);
  return out;
}

template <>
Eigen::Matrix<double, 4, 4> mass_shares<4>(bool lumped) {
  if (lumped) return Eigen::Matrix4d::Identity() / 4;
  return (Eigen::Matrix4d::Ones() + Eigen::Matrix4d::Identity()) / 20;
}

template <>
Eigen::Matrix<double, 10, 10> mass_shares<10>(bool lumped) {
  // Exact integrals of the products of shape functions, times 420 / volume.
  using Shares = Eigen::Matrix<double, 10, 10>;
  const auto holds = [](int edge, int vertex) { return kEdges[edge][0] == vertex || kEdges[edge][1] == vertex; };
  Shares m;
  for (int a = 0; a < 10; ++a)
    for (int b = 0; b < 10; ++b) {
      if (a < 4 && b < 4) {
        m(a, b) = a == b ? 6 : 1;
      } else if (a < 4 || b < 4) {
        m(a, b) = holds(std::max(a, b) - 4, std::min(a, b)) ? -4 : -6;
      } else {
        const int shared = holds(b - 4, kEdges[a - 4][0]) + holds(b - 4, kEdges[a - 4][1]);
        m(a, b) = shared == 2 ? 32 : shared == 1 ? 16 : 8;
      }
    }
  m /= 420;
  if (!lumped) return m;
  return Shares(m.diagonal().asDiagonal()) / m.trace();
}

}  // namespace kt
