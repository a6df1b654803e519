// Local models: towards the hand.
#include "network/message/wire.hpp"

namespace kt {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

flatbuffers::Offset<flatbuffers::Vector<double>> doubles(FlatBufferBuilder& to, const VectorX& v) {
  return to.CreateVector(v.data(), static_cast<std::size_t>(v.size()));
}

Offset<wire::Matrix> write(FlatBufferBuilder& to, const SentMatrix& m) {
  return wire::CreateMatrixDirect(to, m.is_diagonal, &m.values, m.is_sparse() ? &m.first : nullptr,
                                  m.is_sparse() ? &m.row : nullptr);
}

SentMatrix read(const wire::Matrix* m) {
  if (!m) return {};
  return {m->diagonal(), wire::copied(m->values()), wire::copied(m->first()), wire::copied(m->row())};
}

Offset<wire::Basis> write(FlatBufferBuilder& to, const SentBasis& b) {
  std::vector<std::int8_t> small;
  if (b.bits == 8) small.assign(b.value.begin(), b.value.end());
  return wire::CreateBasisDirect(to, b.rows, &b.scale, b.is_dense, b.is_dense ? nullptr : &b.first,
                                 b.is_dense ? nullptr : &b.row, b.bits == 8 ? &small : nullptr,
                                 b.bits == 8 ? nullptr : &b.value);
}

SentBasis read(const wire::Basis* b) {
  if (!b) return {};
  SentBasis out;
  out.rows = b->rows();
  out.scale = wire::copied(b->scale());
  out.is_dense = b->dense();
  out.first = wire::copied(b->first());
  out.row = wire::copied(b->row());
  out.bits = b->small() ? 8 : 16;
  if (b->small())
    out.value.assign(b->small()->begin(), b->small()->end());
  else
    out.value = wire::copied(b->value());
  return out;
}

wire::Site to_wire(const ContactSite& s) {
  return {wire::to_wire(s.centre), wire::to_wire(s.way), s.reach, s.triangle};
}

Offset<wire::Refined> write(FlatBufferBuilder& to, const FineOrigin& origin) {
  const FineZoneOptions& o = origin.options;
  const wire::D3 centre = wire::to_wire(o.centre);
  std::vector<wire::D3> others;
  for (const Vec3& other : o.others) others.push_back(wire::to_wire(other));
  const auto other_vector = to.CreateVectorOfStructs(others);
  const auto x = doubles(to, origin.x), v = doubles(to, origin.v);
  return wire::CreateRefined(to, &centre, other_vector, o.radius, o.reach, o.apart, o.size.edge, o.size.flat,
                             o.size.least_flat, o.size.slope, o.most_nodes, static_cast<std::uint8_t>(origin.kind),
                             origin.fineness, x, v);
}

/// Null: it is none.
std::shared_ptr<const FineOrigin> read(const wire::Refined& r) {
  if (!r.centre() || r.kind() > static_cast<std::uint8_t>(TangentKind::definite)) return nullptr;
  auto out = std::make_shared<FineOrigin>();
  FineZoneOptions& o = out->options;
  o.centre = wire::from_wire(*r.centre());
  if (r.others())
    for (const wire::D3* other : *r.others()) o.others.push_back(wire::from_wire(*other));
  o.radius = r.radius();
  o.reach = r.reach();
  o.apart = r.apart();
  o.size = {.edge = r.edge(), .flat = r.flat(), .least_flat = r.least_flat(), .slope = r.slope()};
  o.most_nodes = r.most_nodes();
  out->kind = static_cast<TangentKind>(r.kind());
  out->fineness = r.fineness();
  out->x = wire::copied_x(r.x());
  out->v = wire::copied_x(r.v());
  return out;
}

}  // namespace

Bytes encode(const ModelMessage& message) {
  const SentModel& m = message.model;
  FlatBufferBuilder to(1 << 17);
  std::vector<wire::Site> sites{to_wire(m.site)};
  for (const ContactSite& other : m.site.others) sites.push_back(to_wire(other));
  std::vector<wire::Tool> tools;
  for (std::size_t k = 0; k < kMaxTools; ++k)
    tools.emplace_back(wire::to_wire(m.places[k]), wire::Push(m.overlap[k].start, m.overlap[k].time, m.overlap[k].left),
                       m.tool_radius[k], m.way_out[k], m.sliding[k]);
  std::vector<wire::Anchor> anchors;
  for (const SentAnchor& a : m.anchors)
    anchors.emplace_back(wire::to_wire(a.contact.bary), wire::to_wire(a.contact.normal), wire::to_wire(a.contact.core),
                         wire::to_wire(a.impulse), a.contact.gap, a.contact.toi, a.contact.triangle, a.contact.tool);
  const auto triangles = to.CreateVector(m.triangles), more = to.CreateVector(m.more_nodes);
  const auto x0 = doubles(to, m.x0), f0 = doubles(to, m.f0), rate0 = doubles(to, m.q_rate0), q = doubles(to, m.q),
             q_rate = doubles(to, m.q_rate), du = doubles(to, m.du);
  const auto v0 = to.CreateVector(m.v0);
  const auto basis = write(to, m.basis);
  const auto mass = write(to, m.mass), damping = write(to, m.damping), stiffness = write(to, m.stiffness);
  const auto reducer = to.CreateString(m.reducer);
  const auto site_vector = to.CreateVectorOfStructs(sites);
  const auto tool_vector = to.CreateVectorOfStructs(tools);
  const auto anchor_vector = to.CreateVectorOfStructs(anchors);
  const auto body = to.CreateVector(m.body.at);
  const auto unloaded = to.CreateVector(m.unloaded);
  const wire::D3 low = wire::to_wire(m.body.low), step = wire::to_wire(m.body.step);
  wire::Friction friction;
  Offset<wire::Refined> refined;
  if (m.fine) refined = write(to, *m.fine);
  wire::Material material;
  if (m.material) material = wire::Material(m.material->young, m.material->damping_mass, m.material->damping_stiffness);
  if (m.friction) friction = wire::Friction(m.friction->mu_static, m.friction->mu_kinetic, m.friction->stribeck);

  wire::ModelBuilder out(to);
  out.add_frame(m.frame);
  out.add_linearized_tick(m.linearized_tick);
  out.add_t(m.t);
  out.add_triangles(triangles);
  out.add_more_nodes(more);
  out.add_x0(x0);
  out.add_v0(v0);
  out.add_basis(basis);
  out.add_mass(mass);
  out.add_damping(damping);
  out.add_stiffness(stiffness);
  out.add_f0(f0);
  out.add_q_rate0(rate0);
  out.add_definite_tangent(m.definite_tangent);
  out.add_reducer(reducer);
  out.add_certified_error(m.certified_error);
  out.add_expected_force_error(message.expected_force_error);
  out.add_force_factor(message.force_factor);
  out.add_refresh_ms(message.refresh_ms);
  out.add_scheme(static_cast<std::uint8_t>(m.scheme));
  out.add_sites(site_vector);
  out.add_tools(tool_vector);
  out.add_q(q);
  out.add_q_rate(q_rate);
  out.add_du(du);
  out.add_anchors(anchor_vector);
  out.add_body_low(&low);
  out.add_body_step(&step);
  out.add_body(body);
  out.add_unloaded(unloaded);
  if (m.friction) out.add_friction(&friction);
  if (m.fine) out.add_refined(refined);
  if (m.material) out.add_material(&material);
  out.add_loss(wire::loss_sent(message.loss));
  out.add_body_ms(static_cast<float>(message.body_ms));
  to.Finish(out.Finish());
  return wire::taken(to);
}

std::optional<ModelMessage> decode_model(std::span<const std::uint8_t> bytes) {
  const auto* m = wire::verified<wire::Model>(bytes);
  if (!m || wire::size_of(m->sites()) == 0 || wire::size_of(m->tools()) != static_cast<std::size_t>(kMaxTools) ||
      !m->body_low() || !m->body_step() || m->scheme() > static_cast<std::uint8_t>(LocalScheme::exact) ||
      m->frame() < 0 || m->linearized_tick() < 0)
    return {};
  ModelMessage message;
  message.expected_force_error = m->expected_force_error();
  message.force_factor = m->force_factor();
  message.refresh_ms = m->refresh_ms();
  message.loss = wire::loss_told(m->loss());
  message.body_ms = std::clamp(static_cast<double>(m->body_ms()), 0.0, 1e9);
  SentModel& out = message.model;
  out.frame = m->frame();
  out.linearized_tick = m->linearized_tick();
  out.t = m->t();
  out.triangles = wire::copied(m->triangles());
  out.more_nodes = wire::copied(m->more_nodes());
  out.x0 = wire::copied_x(m->x0());
  out.v0 = wire::copied(m->v0());
  out.basis = read(m->basis());
  out.mass = read(m->mass());
  out.damping = read(m->damping());
  out.stiffness = read(m->stiffness());
  out.f0 = wire::copied_x(m->f0());
  out.q_rate0 = wire::copied_x(m->q_rate0());
  out.definite_tangent = m->definite_tangent();
  out.reducer = wire::line_of(m->reducer());
  out.certified_error = m->certified_error();
  out.scheme = static_cast<LocalScheme>(m->scheme());
  for (const wire::Site* s : *m->sites()) {
    const ContactSite site{wire::from_wire(s->centre()), s->triangle(), s->reach(), {}, wire::from_wire(s->way())};
    if (s == m->sites()->Get(0))
      out.site = site;
    else
      out.site.others.push_back(site);
  }
  for (std::size_t k = 0; k < kMaxTools; ++k) {
    const wire::Tool& tool = *m->tools()->Get(static_cast<flatbuffers::uoffset_t>(k));
    out.places[k] = wire::from_wire(tool.place());
    out.overlap[k] = {tool.push().start(), tool.push().time(), tool.push().left()};
    out.tool_radius[k] = tool.radius();
    out.way_out[k] = tool.way_out();
    out.sliding[k] = tool.sliding();
  }
  out.q = wire::copied_x(m->q());
  out.q_rate = wire::copied_x(m->q_rate());
  out.du = wire::copied_x(m->du());
  if (m->anchors())
    for (const wire::Anchor* a : *m->anchors())
      out.anchors.push_back({{.triangle = a->triangle(),
                              .bary = wire::from_wire(a->bary()),
                              .normal = wire::from_wire(a->normal()),
                              .gap = a->gap(),
                              .toi = a->toi(),
                              .core = wire::from_wire(a->core()),
                              .tool = a->tool()},
                             wire::from_wire(a->impulse())});
  out.body.low = wire::from_wire(*m->body_low());
  out.body.step = wire::from_wire(*m->body_step());
  out.body.at = wire::copied(m->body());
  out.unloaded = wire::copied(m->unloaded());
  if (m->refined() && !(out.fine = read(*m->refined()))) return {};
  if (const wire::Material* s = m->material())
    out.material = LiveMaterial{s->young(), s->damping_mass(), s->damping_stiffness()};
  if (const wire::Friction* f = m->friction()) out.friction = Friction{f->mu_static(), f->mu_kinetic(), f->stribeck()};
  return message;
}

}  // namespace kt
