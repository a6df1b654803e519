#include "haptics/watch/tick_words.hpp"

#include <algorithm>
#include <utility>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr std::pair<LocalFlag, const char*> kFlagWords[] = {
    {kEventsExhausted, "more impacts in one tick than are resolved"},
    {kLeftPatch, "the contact reached the edge of the local patch"},
    {kLostAnchor, "a refresh brought a patch that does not hold the contact"},
    {kRigidContact, "contact with a clamped part, which cannot give way"},
    {kNotFinite, "the local model left the finite numbers and was reset"},
    {kContactsExhausted, "as many places touched at once as are resolved, 40: those that say most were kept"},
    {kWorkExhausted, "the contact solver stopped at the work limit of a tick, and went on in the next one"},
    {kPushedOut, "the tool was inside the body, which was pushed off it over a time, the force growing slowly"},
    {kStaleModel, "an old local model served, as the body has not followed"},
    {kBodyFailed, "the body's simulation had ended with an error, and its last local model went on"},
    {kNoModel, "there was no local model yet, and nothing was touched"},
    {kBadPose,
     "a pose that was not finite, no rotation, or beyond 1e6 m: the tool's pose was not usable, and it stayed where it "
     "was"},
    {kLateTick, "more time had passed than is caught up with in one call"},
    {kUnrefined,
     "the contact left the refined cells, and the force was that of the cells as they are, which is larger"},
    {kOnApron, "contact outside the local model, on the body around it, where the force is a coarse one"},
};

std::string words_of(LocalFlag flag) {
  const auto* const at = std::ranges::find(kFlagWords, flag, &std::pair<LocalFlag, const char*>::first);
  return at == std::end(kFlagWords) ? told("flag ", static_cast<unsigned>(flag)) : at->second;
}

Finding::Weight weight_of(LocalFlag flag) {
  if (flag == kBodyFailed) return Finding::Weight::failure;
  return flag == kOnApron ? Finding::Weight::note : Finding::Weight::doubt;  // about the body's force: docs/method.md
}

std::string share(const TickCount& ticks) { return told(ticks.count, " of ", ticks.of, " ticks"); }

}  // namespace

std::vector<Cure> smaller_contact() {
  return {advise("take a smaller tool"), advise("press less deep"), advise("take a coarser surface")};
}

Finding flag_finding(LocalFlag flag, const TickCount& ticks, std::size_t tool, std::vector<Cure> cures) {
  constexpr double kStart = 0.005;  // [s]
  if (flag == kPushedOut && ticks.first <= kStart) cures.insert(cures.begin(), advise("begin outside the body"));
  return Finding{told(which(tool), words_of(flag), ": ", share(ticks), ", first at t = ", ticks.first, " s"),
                 std::move(cures), weight_of(flag)}
      .at(tool_key(tool), ticks.count, 0);
}

Finding unsolved_finding(const TickCount& ticks) {
  return Finding{told("the contact forces were not found to within 1 %: ", share(ticks),
                      " (contacts on the same few nodes, or a tool that drives into what is clamped)"),
                 {advise("press less deep"), advise("move the tool more slowly")}}
      .at("contact", ticks.count, 0);
}

Finding depth_finding(double deepest, const TickCount& ticks, std::size_t tool) {
  return Finding{told(which(tool), "the tool was up to ", 1e3 * deepest, " mm inside the body, in ", share(ticks),
                      ": forces there are not to be trusted"),
                 {advise("move the tool more slowly"), advise("press less deep")}}
      .at(tool_key(tool), deepest, LostContact::kNoticeableDepth);
}

std::vector<Finding> lost_contact_findings(const LostContact& lost, long ticks, double h, std::size_t tool,
                                           const std::vector<Cure>& sooner) {
  std::vector<Finding> out;
  if (lost.free_ticks_inside > 0)
    out.push_back(Finding{told(which(tool), "contact was lost: the tool was inside the body without contact in ",
                               share({lost.free_ticks_inside, ticks})),
                          sooner, Finding::Weight::failure}
                      .at(tool_key(tool), lost.free_ticks_inside, 0));
  if (lost.pass_throughs == 0) return out;
  const auto& [tick, distance] = lost.went_through.front();
  out.push_back(Finding{told(which(tool), "the tool went into the body or through it unstopped in ", lost.pass_throughs,
                             lost.pass_throughs == 1 ? " tick" : " ticks", ", first in tick ", tick,
                             " (t = ", (tick + 1) * h, " s), ", distance, " m in that one"),
                        {advise("give the path more time there")},
                        Finding::Weight::failure}
                    .at(tool_key(tool), distance));
  return out;
}

std::optional<Finding> unchecked_finding(const LostContact& lost, long ticks, std::size_t tool) {
  if (lost.unchecked_ticks == 0) return {};
  return Finding{told(which(tool), "contacts were not checked in ", share({lost.unchecked_ticks, ticks}),
                      ": the check fell too far behind")}
      .at(tool_key(tool), lost.unchecked_ticks, 0);
}

std::optional<Finding> inverted_finding(const InvertedTetrahedra& inverted, std::size_t of, std::vector<Cure> cures) {
  if (inverted.most == 0) return {};
  return Finding{told(inverted.most, " of ", of, " tetrahedra turned inside out, first at t = ", inverted.from, " s, ",
                      inverted.last > 0 ? told("and ", inverted.last, " are at the end") : std::string("and came back"),
                      ": forces from then on are not to be trusted"),
                 std::move(cures)}
      .at("object.mesh", inverted.most, 0);
}

Finding indefinite_finding(int refreshes, std::size_t of, std::vector<Cure> cures) {
  return Finding{told("the exact tangent was indefinite at ", refreshes, " of ", of,
                      " refreshes: clamped there, the local model is stiffer than the body"),
                 std::move(cures)}
      .at("object.model", refreshes, 0);
}

Finding crossed_finding(int crossings) {
  return Finding{told("the surface crossed itself, in up to ", crossings,
                      " pairs of triangles after a global step: a fault of this program, please report it")}
      .at("global.self_contact", crossings, 0);
}

Finding pressed_finding(int pairs, double stiffness) {
  return Finding{told("the surface is pressed onto itself until nothing is left between, in up to ", pairs,
                      " pairs of triangles: the barrier of ", stiffness, " N/m is too soft for the force on it"),
                 {set_to("global.self_contact.stiffness", short_number(100 * stiffness)), advise("press less deep"),
                  advise("raise object.model.young")}}
      .at("global.self_contact.stiffness", stiffness);
}

}  // namespace kt
