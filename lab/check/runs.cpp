#include "lab/check/runs.hpp"

#include <cmath>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"

namespace kt {
namespace {

constexpr double kInside = 1e-7;  // [m] deeper than this, the tool is in the body (haptics/session/session_run.cpp)
constexpr double kGained = 1e-2;  // of the work that the tool has done at most: energy that may come back as more

nlohmann::ordered_json percentiles(const std::vector<double>& values) {
  return {{"p50", percentile(values, 0.5)}, {"p99", percentile(values, 0.99)}, {"max", percentile(values, 1)}};
}

}  // namespace

SessionResult run_along(CheckBody& body, std::vector<TimedPoint> path, const std::atomic<bool>* stop) {
  body.session->follow(std::move(path));
  SessionOptions options;
  options.stop = stop;
  return body.session->run(options);
}

std::optional<Reference> truth_of(const CheckBody& body, const SessionResult& run, std::size_t ticks,
                                  const std::atomic<bool>* stop) {
  constexpr int kMostNodes = 3000;
  if (body.session->model().mesh().num_own_nodes() > kMostNodes) return {};
  PosePath tool = tool_paths(run)[0];
  tool.resize(std::min(ticks + 1, tool.size()));
  for (const double rate : {2000.0, 4000.0, 8000.0, 16000.0}) try {
      return run_reference(*body.session, {&tool, 1}, {.rate_hz = rate, .stop = stop});
    } catch (const RunError&) {
    }
  return {};
}

std::string Loss::told() const {
  return text("for up to ", ticks, " ticks; ",
              whole_body ? text("the whole nonlinear body leaves for up to ", *whole_body)
                         : std::string("not compared with the whole nonlinear body"));
}

Loss longest_loss(const CheckBody& body, const SessionResult& run, double from, double to,
                  const std::atomic<bool>* stop) {
  const double h = run.tools[0].frames[0].t;
  const auto longest = [&](auto is_free) {
    int most = 0, now = 0;
    for (std::size_t i = 0; i < run.tools[0].frames.size(); ++i) {
      const double t = static_cast<double>(i + 1) * h;
      most = std::max(most, now = t > from && t < to && is_free(i) ? now + 1 : 0);
    }
    return most;
  };
  Loss out{longest([&](std::size_t i) { return run.tools[0].frames[i].mode == ContactMode::free; }), {}};
  if (out.ticks == 0) return out;
  const auto ticks = static_cast<std::size_t>(std::min(to / h + 1, static_cast<double>(run.tools[0].frames.size())));
  if (const auto truth = truth_of(body, run, ticks, stop))
    out.whole_body = longest([&](std::size_t i) { return i < truth->force.size() && truth->force[i].isZero(0); });
  return out;
}

Verdict judge_loss(const Loss& loss) {
  constexpr int kBounce = 20;    // ticks that a body may be in the air: a light one bounces
  constexpr double kLonger = 2;  // than the whole nonlinear body may be: it comes back at another moment
  if (loss.whole_body && loss.ticks <= kLonger * *loss.whole_body) return Verdict::pass;
  return loss.ticks > kBounce ? Verdict::fail : Verdict::degraded;
}

Fall largest_fall(std::span<const double> force) {
  const double largest = *std::ranges::max_element(force);
  Fall out;
  for (std::size_t i = 1; largest > 0 && i < force.size(); ++i)
    if (const double share = (force[i - 1] - force[i]) / largest; share > out.share) out = {share, i};
  return out;
}

Verdict judge_fall(const Fall& fall, const std::optional<Fall>& of_whole_body) {
  constexpr double kRings = 0.05;  // less at a greater depth is not monotone
  constexpr double kFalls = 0.3;   // more than a light body's ringing
  constexpr double kAlike = 0.5;   // of it, at least: the whole body falls, too
  if (fall.share <= kRings) return Verdict::pass;
  const bool is_true = of_whole_body && of_whole_body->share >= kAlike * fall.share;
  return fall.share > kFalls && !is_true ? Verdict::fail : Verdict::degraded;
}

void judge_run(const SessionResult& run, const std::string& name, const Vec3& where, RunExtremes& all,
               StageResult& out) {
  ++all.runs;
  all.ticks += static_cast<int>(run.tools[0].frames.size());
  all.missed += run.tools[0].missed_impacts;
  for (const double d : run.tools[0].penetration) all.penetration = std::max(all.penetration, d);
  if (std::isfinite(run.certified_error)) all.certified_error = std::max(all.certified_error, run.certified_error);
  all.step_us.insert(all.step_us.end(), run.step_us.begin(), run.step_us.end());
  all.refresh_ms.insert(all.refresh_ms.end(), run.refresh.refresh_ms.begin(), run.refresh.refresh_ms.end());
  all.global_ms.insert(all.global_ms.end(), run.refresh.global_ms.begin(), run.refresh.global_ms.end());

  int not_finite = 0, exhausted = 0;
  double work = 0, most = 0, least = 0;
  Vec3 before = run.tools[0].start.x;
  for (const LocalFrame& f : run.tools[0].frames) {
    not_finite += (f.flags & kNotFinite) != 0 || !f.force.allFinite();
    exhausted += (f.flags & kEventsExhausted) != 0;
    work -= f.force.dot(f.pose.x - before);
    before = f.pose.x;
    most = std::max(most, work);
    least = std::min(least, work);
  }
  all.energy_min = std::min(all.energy_min, least);
  const auto deepest = run.tools[0].penetration.empty() ? 0 : *std::ranges::max_element(run.tools[0].penetration);
  if (not_finite > 0) out.lower(Verdict::fail, text(name, ": ", not_finite, " ticks left the finite numbers"), where);
  if (run.tools[0].missed_impacts > 0)
    out.lower(Verdict::fail,
              text(name, ": the tool is inside the body in ", run.tools[0].missed_impacts, " ticks without contact"),
              where);
  if (deepest > kInside) out.lower(Verdict::fail, told(name, ": the tool gets ", deepest, " m into the body"), where);
  if (-least > kGained * most + 1e-9)
    out.lower(Verdict::fail, told(name, ": the tool was given ", -least, " J, having put in at most ", most), where);
  if (exhausted > 0)
    out.lower(Verdict::degraded, text(name, ": more impacts than are resolved in ", exhausted, " ticks"), where);
  all.inverted = std::max(all.inverted, run.refresh.inverted.most);
  if (run.refresh.inverted.last > 0)
    out.lower(Verdict::degraded, text(name, ": ", run.refresh.inverted.last, " tetrahedra stay inside out"), where);
}

void report_runs(const RunExtremes& all, const std::string& model, StageResult& out) {
  auto& f = out.figures[model];
  f["runs"] = all.runs;
  f["ticks"] = all.ticks;
  f["penetration"] = all.penetration;
  f["missed"] = all.missed;
  f["certified_error"] = all.certified_error;
  f["energy_min"] = all.energy_min;
  f["inverted"] = all.inverted;
  out.times[model] = {{"step_us", percentiles(all.step_us)},
                      {"refresh_ms", percentiles(all.refresh_ms)},
                      {"global_ms", percentiles(all.global_ms)}};
}

}  // namespace kt
