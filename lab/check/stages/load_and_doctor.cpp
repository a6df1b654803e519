// First stages: what the file holds, and what is wrong with it.
#include <filesystem>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "io/mesh/mesh_io.hpp"
#include "lab/check/mesh_work.hpp"

namespace kt {
namespace {

/// Reports are compared between machines: a message names the file, not the folder that it lies in.
std::string without_folder(std::string message, const std::string& file) {
  const std::string folder = std::filesystem::path(file).parent_path().string();
  if (folder.empty()) return message;
  for (auto at = message.find(folder + "/"); at != std::string::npos; at = message.find(folder + "/"))
    message.erase(at, folder.size() + 1);
  return message;
}

}  // namespace

void check_load(MeshWork& work, StageResult& out) {
  std::vector<std::string> notes;
  try {
    work.input = load_mesh(work.options.mesh, {}, &notes);
  } catch (const InputError& e) {
    out.lower(Verdict::fail, "refused: " + without_folder(e.what(), work.options.mesh));
    return;
  }
  const Bounds box = bounds(work.input);
  const double longest = box.size().maxCoeff();
  out.figures = {{"nodes", work.input.num_nodes()},
                 {"triangles", work.input.triangles.size()},
                 {"tetrahedra", work.input.tetrahedra.size()},
                 {"longest_side", longest}};
  for (const std::string& note : notes)
    out.why += (out.why.empty() ? "" : "; ") + without_folder(note, work.options.mesh);
  if (work.input.triangles.empty()) return out.lower(Verdict::fail, "refused: the mesh has no triangles");
  if (!(longest > 0)) return out.lower(Verdict::fail, "refused: all nodes lie on one point");
  const double scale = kBodySize / longest;
  if (!std::isfinite(scale) || !(scale > 0) || !std::isfinite(longest * longest))
    out.lower(Verdict::fail,
              told("refused: a mesh of size ", longest, " cannot be scaled to a body of ", kBodySize, " m"));
}

void check_doctor(MeshWork& work, StageResult& out) {
  MeshReport& r = work.report;
  r = examine(work.input);
  out.figures = {{"pieces", r.components},
                 {"euler", r.euler},
                 {"closed", r.closed()},
                 {"manifold", r.manifold()},
                 {"self_intersections_checked", r.self_intersections_checked}};
  if (r.genus) out.figures["genus"] = *r.genus;
  const double longest = r.box.size().maxCoeff();
  out.figures["volume_share"] = r.closed() ? r.volume / std::pow(longest, 3) : 0;
  for (const DefectList& d : defects(r)) {
    out.figures[d.key] = d.places->size();
    // Nodes at one place are a seam; whether it matters shows in the open edges.
    if (d.places->empty()) continue;
    const bool stopped = d.key == "self_intersections" && !r.self_intersections_complete;
    out.lower(Verdict::degraded,
              text(stopped ? "at least " : "", d.places->size(), " ", d.title,
                   d.cure.empty() ? "" : "; to join them: ", d.cure),
              d.places->front().at);
  }
}

}  // namespace kt
