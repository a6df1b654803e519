// Reports and motion: towards the body.
#include "network/message/wire.hpp"

namespace kt {
namespace {

using flatbuffers::FlatBufferBuilder;

wire::Sample to_wire(const TickContact& c) {
  const ImpulseCount n = count_impulse(c.impulse);
  const wire::I3 impulse(static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2]));
  return {c.triangle,
          c.facet,
          wire::to_float(c.bary),
          impulse,
          wire::to_float(c.normal),
          wire::to_float(c.point),
          static_cast<std::uint8_t>(c.tool),
          c.sticks};
}

/// None: a value is out of range.
std::optional<TickContact> from_wire(const wire::Sample& s, double t, const WireLimits& limits) {
  constexpr double kRounding = 1e-5;
  TickContact c;
  c.t = t;
  c.triangle = s.triangle();
  c.facet = s.facet();
  c.bary = wire::from_wire(s.bary());
  c.impulse = impulse_of({s.impulse().x(), s.impulse().y(), s.impulse().z()});
  c.normal = wire::from_wire(s.normal());
  c.point = wire::from_wire(s.point());
  c.sticks = s.sticks();
  c.tool = s.tool();
  if (c.triangle < 0 || c.triangle >= limits.triangles || c.facet < -1 ||
      c.facet / limits.facets_per_triangle >= limits.triangles || c.tool >= limits.tools)
    return {};
  if (!(c.bary.minCoeff() >= -kRounding && c.bary.maxCoeff() <= 1 + kRounding &&
        std::abs(c.bary.sum() - 1) <= kRounding && std::abs(c.normal.norm() - 1) <= 1e-3 && wire::is_place(c.point)))
    return {};
  return c;
}

flatbuffers::Offset<wire::Reports> write(FlatBufferBuilder& to, const ReportMessage& message, int tools) {
  const ReportBatch& batch = message.batch;
  std::vector<wire::Tick> ticks;
  std::vector<wire::ToolTick> tool_ticks;
  std::vector<wire::Sample> samples;
  for (const LocalReport& report : batch.reports) {
    ticks.emplace_back(report.model_frame, static_cast<std::uint8_t>(report.count), report.left_patch);
    for (std::size_t k = 0; k < static_cast<std::size_t>(tools); ++k) {
      const ToolReport& tool = report.tools[k];
      const Eigen::Vector4f turn = tool.pose.r.coeffs().cast<float>();
      tool_ticks.emplace_back(wire::to_wire(tool.pose.x), wire::F4(turn[0], turn[1], turn[2], turn[3]), tool.triangle,
                              tool.sliding);
    }
    for (const TickContact& c : report.contacts()) samples.push_back(to_wire(c));
  }
  std::vector<wire::L3> sums;
  std::vector<wire::Place> places;
  for (std::size_t k = 0; k < static_cast<std::size_t>(tools); ++k) {
    const ImpulseCount& n = batch.sum[k];
    sums.emplace_back(n[0], n[1], n[2]);
    places.emplace_back(to_wire(batch.place[k].contact), batch.place[k].model_frame);
  }
  return wire::CreateReportsDirect(to, batch.reports.empty() ? 0 : batch.first(), &ticks, &tool_ticks, &samples, &sums,
                                   &places, batch.adopted_frame, batch.adopted_tick, wire::loss_sent(message.loss),
                                   message.feedback.newest, message.feedback.came);
}

std::optional<ReportMessage> read(const wire::Reports& m, const WireLimits& limits) {
  constexpr int kLast = 1 << 30;
  const std::size_t count = wire::size_of(m.ticks()), tools = static_cast<std::size_t>(limits.tools);
  if (count == 0 || m.first_tick() < 0 || m.first_tick() > kLast || wire::size_of(m.tools()) != tools * count ||
      wire::size_of(m.sum()) != tools || wire::size_of(m.place()) != tools ||
      !((m.loss() >= 0 && m.loss() <= 1) || m.loss() == -1) || m.adopted_frame() < -1 || m.adopted_tick() < -1)
    return {};
  ReportMessage out;
  out.loss = wire::loss_told(m.loss());
  out.feedback = {m.newest(), m.came()};
  out.batch.adopted_frame = m.adopted_frame();
  out.batch.adopted_tick = m.adopted_tick();
  std::size_t next = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const wire::Tick& tick = *m.ticks()->Get(static_cast<flatbuffers::uoffset_t>(i));
    LocalReport& report = out.batch.reports.emplace_back();
    report.tick = m.first_tick() + static_cast<int>(i);
    report.model_frame = tick.model_frame();
    report.left_patch = tick.left_patch();
    report.count = tick.samples();
    if (report.count > kMaxContacts || next + tick.samples() > wire::size_of(m.samples()) || report.model_frame < -1)
      return {};
    for (int k = 0; k < report.count; ++k) {
      const auto c =
          from_wire(*m.samples()->Get(static_cast<flatbuffers::uoffset_t>(next++)), report.tick * limits.h, limits);
      if (!c) return {};
      report.samples[static_cast<std::size_t>(k)] = *c;
    }
    for (std::size_t k = 0; k < tools; ++k) {
      const wire::ToolTick& tool = *m.tools()->Get(static_cast<flatbuffers::uoffset_t>(tools * i + k));
      const Vec3 place = wire::from_wire(tool.place());
      Quaternion turn;
      turn.coeffs() << tool.turn().x(), tool.turn().y(), tool.turn().z(), tool.turn().w();
      if (!wire::is_place(place) || !wire::is_turn(turn) || tool.triangle() < -1 || tool.triangle() >= limits.triangles)
        return {};
      report.tools[k] = {{place, turn}, tool.triangle(), tool.sliding()};
    }
  }
  if (next != wire::size_of(m.samples())) return {};
  for (std::size_t k = 0; k < tools; ++k) {
    const auto at = static_cast<flatbuffers::uoffset_t>(k);
    out.batch.sum[k] = {m.sum()->Get(at)->x(), m.sum()->Get(at)->y(), m.sum()->Get(at)->z()};
    for (const std::int64_t n : out.batch.sum[k])
      if (n > std::int64_t{1} << 60 || n < -(std::int64_t{1} << 60)) return {};
    const wire::Place& place = *m.place()->Get(at);
    if (place.sample().triangle() < 0) continue;
    const auto c = from_wire(place.sample(), 0, limits);
    if (!c) return {};
    out.batch.place[k] = {*c, place.model_frame()};
  }
  return out;
}

/// Of the numbers of one value each.
bool are_numbers(const flatbuffers::Vector<float>* v) {
  return !v || std::all_of(v->begin(), v->end(), [](float x) { return std::abs(x) <= wire::kFarthest; });
}

VectorX widened(const flatbuffers::Vector<float>& v) {
  return Eigen::Map<const Eigen::VectorXf>(v.data(), static_cast<Eigen::Index>(v.size())).cast<double>();
}

std::vector<float> narrowed(const VectorX& v, int nodes) {
  std::vector<float> out(static_cast<std::size_t>(3 * nodes));
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(v[static_cast<Eigen::Index>(i)]);
  return out;
}

}  // namespace

Bytes encode(const ReportMessage& message, int tools) {
  FlatBufferBuilder to(2048);
  to.Finish(write(to, message, tools));
  return wire::taken(to);
}

std::optional<ReportMessage> decode_reports(std::span<const std::uint8_t> bytes, const WireLimits& limits) {
  const auto* m = wire::verified<wire::Reports>(bytes);
  if (!m) return {};
  return read(*m, limits);
}

Bytes encode(const MotionMessage& message, int tools) {
  FlatBufferBuilder to(8192);
  const LocalMotion& motion = message.motion;
  const std::vector<float> x = narrowed(motion.x, message.recovered), v = narrowed(motion.v, message.recovered),
                           du = narrowed(motion.du, message.patch);
  std::vector<wire::Push> push;
  for (std::size_t k = 0; k < static_cast<std::size_t>(tools); ++k)
    push.emplace_back(motion.overlap[k].start, motion.overlap[k].time, motion.overlap[k].left);
  const auto reports = write(to, message.reports, tools);
  to.Finish(wire::CreateMotionDirect(to, message.frame, motion.tick, &x, &v, &du, &push, reports));
  return wire::taken(to);
}

std::optional<MotionMessage> decode_motion(std::span<const std::uint8_t> bytes, const WireLimits& limits) {
  const auto* m = wire::verified<wire::Motion>(bytes);
  if (!m || !m->reports()) return {};
  const std::size_t numbers = wire::size_of(m->x()), patch = wire::size_of(m->du()),
                    tools = static_cast<std::size_t>(limits.tools);
  if (numbers == 0 || numbers % 3 != 0 || numbers > 3 * static_cast<std::size_t>(limits.nodes) ||
      wire::size_of(m->v()) != numbers || patch % 3 != 0 || patch > numbers || patch == 0 || !are_numbers(m->x()) ||
      !are_numbers(m->v()) || !are_numbers(m->du()) || wire::size_of(m->push()) != tools || m->frame() < 0)
    return {};
  MotionMessage out;
  auto reports = read(*m->reports(), limits);
  if (!reports || reports->batch.last() + 1 != m->tick()) return {};
  out.reports = std::move(*reports);
  out.frame = m->frame();
  out.recovered = static_cast<int>(numbers / 3);
  out.patch = static_cast<int>(patch / 3);
  out.motion.tick = m->tick();
  out.motion.x = widened(*m->x());
  out.motion.v = widened(*m->v());
  out.motion.du = widened(*m->du());
  for (std::size_t k = 0; k < tools; ++k) {
    const wire::Push& p = *m->push()->Get(static_cast<flatbuffers::uoffset_t>(k));
    if (!(p.start() >= 0 && p.start() <= wire::kFarthest && p.time() >= 0 && p.time() <= wire::kFarthest &&
          p.left() >= 0 && p.left() <= p.time()))
      return {};
    out.motion.overlap[k] = {p.start(), p.time(), p.left()};
  }
  return out;
}

}  // namespace kt
