// Messages between the two computers: each is read, or it is none; whatever is read is in range.
//
//     scripts/fuzz wire_fuzz
#include <cstdint>
#include <span>

#include "network/message/messages.hpp"
#include "tests/fuzz/require.hpp"

using kt::fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const kt::WireLimits limits{.tools = 1 + data[0] / 4 % 2, .triangles = 300, .nodes = 200, .facets_per_triangle = 16};
  const std::vector<std::uint8_t> bytes(data + 1, data + size);  // aligned, as a message that was joined
  switch (data[0] % 4) {
    case 0:
      if (const auto r = kt::decode_reports(bytes, limits)) {
        require(!r->batch.reports.empty() && (!r->loss || (*r->loss >= 0 && *r->loss <= 1)), "a batch has reports");
        for (const kt::LocalReport& report : r->batch.reports) {
          require(report.tools[0].pose.is_finite(), "a pose is finite");
          require(report.count >= 0 && report.count <= kt::kMaxContacts, "there is room for the contacts");
          for (const kt::TickContact& c : report.contacts())
            require(c.triangle >= 0 && c.triangle < limits.triangles && c.tool < limits.tools &&
                        c.impulse.allFinite() && c.normal.allFinite() && c.point.allFinite(),
                    "a contact is in range");
        }
      }
      break;
    case 1:
      if (const auto m = kt::decode_motion(bytes, limits)) {
        require(m->motion.x.allFinite() && m->motion.v.allFinite() && m->motion.du.allFinite(), "a motion is finite");
        require(m->recovered <= limits.nodes && m->patch <= m->recovered && m->motion.x.size() == 3 * m->recovered,
                "a motion is of nodes that are there");
      }
      break;
    case 2:
      if (const auto m = kt::decode_model(bytes))
        require(m->model.frame >= 0 && (!m->loss || (*m->loss >= 0 && *m->loss <= 1)), "a model");
      break;
    default:
      if (const auto m = kt::decode_control(bytes)) {
        if (const auto* w = std::get_if<kt::Welcome>(&*m))
          for (const auto& f : w->files)
            require(f.name.find('/') == std::string::npos && !f.name.empty() && f.name[0] != '.', "a file stays here");
        if (const auto* b = std::get_if<kt::Begin>(&*m))
          for (const kt::Pose& pose : b->tools) require(pose.is_finite(), "a pose is finite");
      }
  }
  return 0;
}
