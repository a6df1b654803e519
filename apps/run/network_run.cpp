#include "apps/run/network_run.hpp"

#include <iostream>

#include "apps/console/commands.hpp"
#include "core/base/error.hpp"
#include "core/base/percentile.hpp"

#if KT_WITH_NETWORK
#include "network/body_beside.hpp"
#endif

namespace kt {

#if KT_WITH_NETWORK

namespace {

using Json = nlohmann::ordered_json;

Json ages_json(std::vector<double> ms) {
  if (ms.empty()) return nullptr;
  return {{"p50", percentile(ms, 0.5)}, {"p90", percentile(ms, 0.9)}, {"p99", percentile(ms, 0.99)}};
}

Json share_or_null(const std::optional<double>& share) { return share ? Json(*share) : Json(nullptr); }

Json link_json(const HandLinkReport& r) {
  const auto mbit_s = [&](long long bytes) {
    return r.seconds > 0 ? 8e-6 * static_cast<double>(bytes) / r.seconds : 0;
  };
  return {{"model_age_ms", ages_json(r.age_ms)},
          {"model_age_at_body_ms", ages_json(r.body_ms)},
          {"model_age_here_ms", ages_json(r.hand_ms)},
          {"models_sent", r.models_sent},
          {"models_arrived", r.models_arrived},
          {"models_adopted", r.models_adopted},
          {"models_wrong", r.models_wrong},
          {"messages_incomplete", r.port.joined.given_up},
          {"mbit_s", {{"to_hand", mbit_s(r.port.bytes_received)}, {"to_body", mbit_s(r.port.bytes_sent)}}},
          {"loss", {{"to_hand", share_or_null(r.loss_down)}, {"to_body", share_or_null(r.loss_up)}}},
          {"datagrams_refused", r.port.opened.refused()},
          {"reconnections", r.reconnections},
          {"longest_gap_s", r.longest_gap_s},
          {"longest_silence_s", r.longest_silence_s},
          {"longest_own_pause_s", r.longest_own_pause_s},
          {"ended_without_body", !r.without_body.empty()}};
}

}  // namespace

std::string loss_text(const std::optional<double>& loss) { return loss ? in_percent(*loss) : "an unknown share"; }

void print_link(const HandLinkReport& r) {
  const Json j = link_json(r);
  if (r.age_ms.empty()) return;
  std::cout << told("  link          local models ", j["model_age_ms"]["p50"].get<double>(),
                    " ms old when they were taken, p99 ", j["model_age_ms"]["p99"].get<double>(), "; ",
                    r.models_arrived, " of ", r.models_sent, " arrived, ", j["mbit_s"]["to_hand"].get<double>(),
                    " Mbit/s; ", loss_text(r.loss_down), " of datagrams lost\n");
}

void tell_of_link(RunSettings& settings, std::shared_ptr<HandLinkReport> report) {
  settings.complete = [report](Json& summary) { summary["link"] = link_json(*report); };
  settings.found = [report] {
    std::vector<Finding> out;
    if (report->reconnections > 0)
      out.push_back(
          {told("the body's computer was gone ", report->reconnections, " times, for up to ", report->longest_gap_s,
                " s: the body began at rest again, and the run cannot be repeated by kilotouch replay")});
    if (report->longest_own_pause_s > 0)
      out.push_back({told("the hand's computer stood still for up to ", report->longest_own_pause_s,
                          " s (stopped, asleep or too busy): no local model was taken meanwhile, and the force was off "
                          "from link.stale_ms on"),
                     {advise("stop what else runs on the hand's computer, and keep it from sleeping")}});
    if (report->longest_silence_s > 0)
      out.push_back(
          {told("no datagram came over UDP from ", report->data_place, " for up to ", report->longest_silence_s,
                " s, while the control channel went on: the local model stayed as it was, and the force was "
                "off from link.stale_ms on"),
           {advise("let UDP through to and from that port")}});
    if (!report->without_body.empty())
      out.push_back({"the run ended without its body: " + report->without_body, {}, Finding::Weight::failure});
    return out;
  };
}

void put_body_beside(const Scene& scene, RunSettings& settings) {
  if (scene.link.type != "network") return;
  const auto report = std::make_shared<HandLinkReport>();
  const auto say = [](const std::string& line) { std::cerr << "kilotouch: " << line << std::endl; };
  const auto body = std::make_shared<BodyBeside>(scene, KT_VERSION, &stop_requested(), say);
  settings.session.link = [body, link = body->link(report)](BodySide& side, HapticSide& hand,
                                                            const SurfaceFriction& friction, ModelObserver* observer) {
    return link(side, hand, friction, observer);
  };
  tell_of_link(settings, report);
}

#else

void put_body_beside(const Scene& scene, RunSettings&) {
  if (scene.link.type == "network")
    throw InputError("link.type: is network; this program was built without it, configure with -DKT_WITH_NETWORK=ON");
}

#endif

}  // namespace kt
