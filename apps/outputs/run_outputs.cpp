#include "apps/outputs/run_outputs.hpp"

#include <algorithm>

#include "apps/outputs/run_tables.hpp"
#include "apps/outputs/session_file.hpp"
#include "apps/outputs/view_json.hpp"
#include "core/base/error.hpp"
#include "haptics/session/contact_events.hpp"
#include "haptics/session/indentation.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/format/vtu.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {

std::vector<std::string> run_output_names() {
  return {"scene.json",    "trace.csv",   "events.csv",   "summary.json",    "view.json",
          "recording.csv", "trace_2.csv", "events_2.csv", "recording_2.csv", "reference.csv",
          "session.json",  "states.pvd",  "force.png",    "mesh.png",        "report.html",
          "force.svg",     "force.pdf",   "mesh.svg",     "mesh.pdf"};
}

/// Those of an earlier run's meshes that this one does not write.
static void drop_others(const std::vector<HeldFile>& held, ResultFiles& files) {
  const std::vector<std::string> extensions = readable_mesh_extensions();
  for (const char* stem : {"body", "tool", "second_tool"})
    for (const std::string& extension : extensions) {
      const std::string name = stem + extension;
      if (std::ranges::find(held, name, &HeldFile::name) == held.end()) files.drop(text(kHeldFiles, '/', name));
    }
}

void write_run(const std::string& dir, const Session& session, const SessionResult& result,
               const nlohmann::ordered_json& summary, const BodyFilm* film) {
  make_folder(dir);
  const Indentation indentation(session.model().mesh().triangles, session.start().x);
  ResultFiles files(dir);
  files.add("scene.json", scene_text(session.scene()) + "\n");
  files.add("summary.json", json_text(summary, 2) + "\n");
  files.add("view.json", json_text(view_json(session, result, film)));
  for (std::size_t k = 0; k < kMaxTools; ++k) {
    const std::string end = k == 0 ? ".csv" : "_2.csv";
    if (k >= result.tools.size()) {
      for (const char* name : {"trace", "events", "recording"}) files.drop(name + end);  // an earlier run's
      continue;
    }
    const ToolRun& tool = result.tools[k];
    write_trace(files, "trace" + end, tool, result.step_us, indentation);
    write_events(files, "events" + end, find_contact_events(tool.frames));
    write_recording(files, "recording" + end, tool);
  }
  const std::vector<HeldFile> held = held_files(session);
  if (!held.empty()) make_inner_folder(dir + '/' + kHeldFiles);
  for (const HeldFile& file : held) files.add(text(kHeldFiles, '/', file.name), file.content);
  drop_others(held, files);
  files.add("session.json", json_text(session_json(session, result), 2) + "\n");
  files.commit();
}

void write_states(const std::string& dir, const Session& session, const SessionResult& result) {
  PvdSeries series(dir + "/states.pvd");
  const Mesh& mesh = session.model().mesh();
  for (const Snapshot& s : result.snapshots) series.add(s.t, mesh, s.x, {{"displacement", s.x - mesh.x}});
}

}  // namespace kt
