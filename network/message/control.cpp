// Control messages.
#include <algorithm>

#include "haptics/options/band_powers.hpp"
#include "network/message/wire.hpp"

namespace kt {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

constexpr std::size_t kLongestWord = 128;  // bytes of a version, of a setting's key or word

template <class Table>
Bytes finished(FlatBufferBuilder& to, wire::Body type, Offset<Table> body) {
  to.Finish(wire::CreateControl(to, type, body.Union()));
  return wire::taken(to);
}

Bytes write(const Hello& m) {
  FlatBufferBuilder to;
  return finished(to, wire::Body::Hello,
                  wire::CreateHelloDirect(to, m.protocol, m.version.c_str(), m.schema, m.session));
}

Bytes write(const Welcome& m) {
  FlatBufferBuilder to;
  std::vector<Offset<wire::File>> files;
  for (const Welcome::File& f : m.files) files.push_back(wire::CreateFileDirect(to, f.name.c_str(), &f.bytes));
  const std::vector<std::uint8_t> key(m.key.begin(), m.key.end());
  return finished(to, wire::Body::Welcome,
                  wire::CreateWelcomeDirect(to, m.session, &key, static_cast<std::uint16_t>(m.port), m.scene.c_str(),
                                            &files, m.body_hash));
}

Bytes write(const Begin& m) {
  FlatBufferBuilder to;
  std::vector<wire::Start> tools;
  for (std::size_t k = 0; k < m.tools.size(); ++k) {
    const Quaternion& r = m.tools[k].r;
    tools.emplace_back(wire::to_wire(m.tools[k].x), wire::D4(r.x(), r.y(), r.z(), r.w()), m.max_speed[k]);
  }
  std::vector<double> changing;
  if (m.motion) changing.assign(m.motion->changing.begin(), m.motion->changing.end());
  return finished(
      to, wire::Body::Begin,
      wire::CreateBeginDirect(to, m.session, &tools, m.motion.has_value(), m.motion ? m.motion->total : 0, &changing));
}

Bytes write(const FirstModel& m) {
  FlatBufferBuilder to;
  return finished(to, wire::Body::First, wire::CreateFirstDirect(to, &m.model));
}

Bytes write(const SetRequest& m) {
  FlatBufferBuilder to;
  return finished(to, wire::Body::Set, wire::CreateSetDirect(to, m.number, m.key.c_str(), m.value, m.word.c_str()));
}

Bytes write(const SetReply& m) {
  FlatBufferBuilder to;
  return finished(to, wire::Body::SetReply, wire::CreateSetReplyDirect(to, m.number, m.trouble.c_str()));
}

enum RecordFlag : std::uint8_t { kDefinite = 1, kAhead = 2, kExact = 4 };

Bytes write(const RecordMessage& m) {
  FlatBufferBuilder to;
  const RefreshRecord& r = m.record;
  std::vector<Offset<wire::Set>> settings;
  for (const SettingChange& s : r.settings)
    settings.push_back(
        wire::CreateSetDirect(to, static_cast<std::uint32_t>(s.tick), s.key.c_str(), s.value, s.word.c_str()));
  std::vector<Offset<wire::Change>> reducers;
  for (const ReducerChange& c : r.reducers)
    reducers.push_back(
        wire::CreateChangeDirect(to, c.tick, c.from.c_str(), c.to.c_str(), c.why.c_str(), c.error, c.force_error));
  const auto flags = static_cast<std::uint8_t>((r.definite_tangent ? kDefinite : 0) | (r.looked_ahead ? kAhead : 0) |
                                               (r.is_exact ? kExact : 0));
  return finished(
      to, wire::Body::Record,
      wire::CreateRecordDirect(to, r.event.linearized_tick, r.event.started_tick, r.event.delay_ticks, &r.event.lost,
                               r.t, r.cpu_ms, r.global_ms.value_or(-1), r.refresh_ms, r.linearize_ms, r.reduce_ms,
                               r.certify_ms, r.prepare_ms, r.linearization_error.value_or(-1), flags, r.coupling,
                               r.inverted, &settings, &reducers));
}

Bytes write(const End&) {
  FlatBufferBuilder to;
  return finished(to, wire::Body::End, wire::CreateEnd(to));
}

Bytes write(const Bye& m) {
  FlatBufferBuilder to;
  return finished(to, wire::Body::Bye, wire::CreateByeDirect(to, m.reason.c_str()));
}

Bytes write(const Ping&) {
  FlatBufferBuilder to;
  return finished(to, wire::Body::Ping, wire::CreatePing(to));
}

std::optional<ControlMessage> read(const wire::Welcome& m) {
  Welcome out;
  out.session = m.session();
  if (wire::size_of(m.key()) != out.key.size()) return {};
  std::copy_n(m.key()->data(), out.key.size(), out.key.begin());
  out.port = m.port();
  out.scene = wire::text_of(m.scene());
  out.body_hash = m.body_hash();
  if (!m.files()) return out;
  for (const wire::File* f : *m.files()) {
    const std::string name = wire::text_of(f->name());
    // A name of ours: it will be a file in a folder of the receiver's choice.
    const bool is_plain = !name.empty() && name.size() < 200 && name[0] != '.' && name.find('/') == std::string::npos &&
                          visible(name) == name;
    if (!is_plain) return {};
    out.files.push_back({name, wire::copied(f->bytes())});
  }
  return out;
}

std::optional<ControlMessage> read(const wire::Begin& m) {
  Begin out;
  out.session = m.session();
  const std::size_t tools = wire::size_of(m.tools());
  if (tools == 0 || tools > static_cast<std::size_t>(kMaxTools)) return {};
  for (const wire::Start* s : *m.tools()) {
    Pose pose;
    pose.x = wire::from_wire(s->place());
    pose.r.coeffs() << s->turn().x(), s->turn().y(), s->turn().z(), s->turn().w();
    if (!wire::is_place(pose.x) || !wire::is_turn(pose.r) || !(s->max_speed() >= 0)) return {};
    out.tools.push_back(pose);
    out.max_speed.push_back(s->max_speed());
  }
  if (!m.has_motion()) return out;
  out.motion.emplace();
  if (wire::size_of(m.motion_changing()) != kBands || !(m.motion_total() >= 0 && m.motion_total() <= 1e12)) return {};
  out.motion->total = m.motion_total();
  for (std::size_t b = 0; b < kBands; ++b) {
    out.motion->changing[b] = m.motion_changing()->Get(static_cast<flatbuffers::uoffset_t>(b));
    if (!(out.motion->changing[b] >= 0 && out.motion->changing[b] <= 1e12)) return {};
  }
  return out;
}

std::optional<ControlMessage> read(const wire::Record& m) {
  RecordMessage out;
  RefreshRecord& r = out.record;
  r.event = {m.linearized_tick(), -1, m.started_tick(), std::max(-1, m.delay_ticks()), wire::copied(m.lost())};
  if (r.event.linearized_tick < 0 || r.event.started_tick < 0 || !std::ranges::is_sorted(r.event.lost)) return {};
  r.t = m.t();
  r.cpu_ms = m.cpu_ms();
  if (m.global_ms() >= 0) r.global_ms = m.global_ms();
  r.refresh_ms = m.refresh_ms();
  r.linearize_ms = m.linearize_ms();
  r.reduce_ms = m.reduce_ms();
  r.certify_ms = m.certify_ms();
  r.prepare_ms = m.prepare_ms();
  if (m.linearization_error() >= 0) r.linearization_error = m.linearization_error();
  r.definite_tangent = (m.flags() & kDefinite) != 0;
  r.looked_ahead = (m.flags() & kAhead) != 0;
  r.is_exact = (m.flags() & kExact) != 0;
  r.coupling = m.coupling();
  r.inverted = m.inverted();
  if (m.settings())
    for (const wire::Set* s : *m.settings())
      r.settings.push_back(
          {static_cast<int>(s->number()), wire::line_of(s->key()), s->value(), wire::line_of(s->word())});
  if (m.reducers())
    for (const wire::Change* c : *m.reducers())
      r.reducers.push_back({c->tick(), wire::line_of(c->from()), wire::line_of(c->to()), wire::line_of(c->why()),
                            c->error(), c->force_error()});
  return out;
}

}  // namespace

std::uint64_t wire_schema_hash() { return KT_WIRE_SCHEMA_HASH; }

Bytes encode(const ControlMessage& message) {
  return std::visit([](const auto& m) { return write(m); }, message);
}

std::optional<ControlMessage> decode_control(std::span<const std::uint8_t> bytes) {
  const auto* m = wire::verified<wire::Control>(bytes);
  if (!m || !m->body()) return {};
  switch (m->body_type()) {
    case wire::Body::Hello: {
      const wire::Hello& h = *m->body_as_Hello();
      return Hello{h.protocol(), wire::line_of(h.version(), kLongestWord), h.schema(), h.session()};
    }
    case wire::Body::Welcome:
      return read(*m->body_as_Welcome());
    case wire::Body::Begin:
      return read(*m->body_as_Begin());
    case wire::Body::First:
      return FirstModel{wire::copied(m->body_as_First()->model())};
    case wire::Body::Set: {
      const wire::Set& s = *m->body_as_Set();
      if (wire::size_of(s.key()) > kLongestWord || wire::size_of(s.word()) > kLongestWord) return {};
      return SetRequest{s.number(), wire::text_of(s.key()), s.value(), wire::text_of(s.word())};
    }
    case wire::Body::SetReply:
      return SetReply{m->body_as_SetReply()->number(), wire::line_of(m->body_as_SetReply()->trouble())};
    case wire::Body::Record:
      return read(*m->body_as_Record());
    case wire::Body::End:
      return End{};
    case wire::Body::Bye:
      return Bye{wire::line_of(m->body_as_Bye()->reason())};
    case wire::Body::Ping:
      return Ping{};
    case wire::Body::NONE:
      break;
  }
  return {};
}

}  // namespace kt
