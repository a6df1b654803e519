#include "apps/outputs/run_outputs.hpp"

#include <filesystem>

#include "apps/outputs/run_tables.hpp"
#include "apps/outputs/session_file.hpp"
#include "apps/outputs/view_json.hpp"
#include "haptics/study/contact_events.hpp"
#include "haptics/study/indentation.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/vtu.hpp"

namespace kt {

void write_run(const std::string& dir, const Session& session, const SessionResult& result,
               const nlohmann::ordered_json& summary, const BodyFilm* film) {
  make_folder(dir);
  const Indentation indentation(session.model().mesh().triangles, session.start().x);
  write_file_whole(dir + "/scene.json", to_json(session.scene()) + "\n");
  write_trace(dir + "/trace.csv", result.tools[0], result.step_us, indentation);
  write_events(dir + "/events.csv", find_contact_events(result.tools[0].frames));
  write_file_whole(dir + "/summary.json", json_text(summary, 2) + "\n");
  write_file_whole(dir + "/view.json", json_text(view_json(session, result, film)));
  write_recording(dir + "/recording.csv", result.tools[0]);
  for (const char* name : {"/trace_2.csv", "/events_2.csv", "/recording_2.csv"})
    std::filesystem::remove(dir + name);  // an earlier run's
  if (result.tools.size() > 1) {
    const ToolRun& second = result.tools[1];
    write_trace(dir + "/trace_2.csv", second, result.step_us, indentation);
    write_events(dir + "/events_2.csv", find_contact_events(second.frames));
    write_recording(dir + "/recording_2.csv", second);
  }
  write_file_whole(dir + "/session.json", json_text(session_json(session, result), 2) + "\n");
}

void write_states(const std::string& dir, const Session& session, const SessionResult& result) {
  PvdSeries series(dir + "/states.pvd");
  const Mesh& mesh = session.model().mesh();
  for (const Snapshot& s : result.snapshots) series.add(s.t, mesh, s.x, {{"displacement", s.x - mesh.x}});
}

}  // namespace kt
