// Pieces of a body that nothing holds, or that can turn about what holds them, and nodes that lie in one place without
// being shared: files of layered bodies that were meshed one by one.
#include <algorithm>

#include "core/body/pieces.hpp"
#include "haptics/predict/predict.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {
namespace {

std::string place(const Vec3& p) { return told("(", p.x(), ", ", p.y(), ", ", p.z(), ")"); }

std::string nodes(std::size_t n) { return told(n, n == 1 ? " node" : " nodes"); }

Bounds bounds_of(const Mesh& body, const std::vector<int>& nodes) {
  Mesh part;
  part.x.resize(3 * static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i) node(part.x, static_cast<int>(i)) = node(body.x, nodes[i]);
  return bounds(part);
}

}  // namespace

/// With self-contact, pieces may lie on one another, apart or at rest: that is what it is for.
void predict_pieces(const BuiltScene& built, std::vector<Prediction>& out) {
  constexpr double kSamePlace = 1e-6;  // of the body's size
  constexpr int kFace = 3;             // fewer are points or edges where repair has parted a body that only met there
  const Mesh& body = built.model().mesh();
  const double size = bounds(body).size().maxCoeff();
  const auto seam = coincident_nodes(body, kSamePlace * size);
  const std::string weld = told("kilotouch mesh repair ", built.scene().object.mesh, " --weld TOL -o OUT joins them");
  if (static_cast<int>(seam.size()) >= kFace && !body.embedded)
    out.push_back({"pieces", Finding{told("object.mesh: at ", seam.size(),
                                          " places nodes coincide and are not shared, the first at ",
                                          place(node(body.x, seam[0][0])), " m: the body opens there"),
                                     {advise("where it should not, " + weld)}}
                                 .at("object.mesh", static_cast<double>(seam.size()), 0)});
  if (still_nodes(built.model()).empty() || built.scene().global.self_contact) return;

  int count = 0;
  const std::vector<int> piece = pieces_of(body, count);
  std::vector<std::vector<int>> of_piece(static_cast<std::size_t>(count)), held(of_piece.size());
  for (int i = 0; i < body.num_nodes(); ++i)
    if (piece[i] >= 0) of_piece[piece[i]].push_back(i);
  for (const int i : built.model().fixed_nodes())
    if (piece[i] >= 0) held[piece[i]].push_back(i);
  for (int p = 0; p < count; ++p) {
    const bool is_sheet = body.tetrahedra.empty();  // may hang from an edge
    if (is_sheet ? !held[p].empty() : holds_still(body, held[p], bounds_of(body, held[p]).size().norm())) continue;
    const Bounds box = bounds_of(body, of_piece[p]);
    const std::string which =
        told(count == 1 ? "the body" : told("a piece of ", nodes(of_piece[p].size()), " of ", body.num_own_nodes()),
             ", from ", place(box.min), " to ", place(box.max), " m, is held ",
             held[p].empty() ? "by nothing and drifts off"
                             : told("at ", nodes(held[p].size()), " only, on one line, and turns about it"),
             " when it is touched");
    const bool is_seam = std::ranges::any_of(seam, [&](const std::vector<int>& group) {
      return std::ranges::any_of(group, [&](int i) { return piece[i] == p; });
    });
    Finding found =
        Finding{"object.fixed: " + which, {advise("clamp some of it"), advise("leave it out of the mesh")}}.at(
            "object.fixed");
    if (is_seam) found.cures.push_back(advise("as nodes of it coincide with others: " + weld));
    out.push_back({"pieces", std::move(found)});
  }
}

}  // namespace kt
