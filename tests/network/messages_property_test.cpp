// Messages there and back, and whatever else comes from a network.
#include <gtest/gtest.h>

#include <random>

#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/refresher.hpp"
#include "haptics/remote/model_unpacker.hpp"
#include "haptics/setup/built_scene.hpp"
#include "network/message/messages.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

struct Talk {
  explicit Talk(const std::string& surface = "flat") : scene(make(surface)) {
    const Pose at{{0.03, 0.026, 0.038}, Quaternion::Identity()};
    Refresher refresher(scene.model(), scene.surface(), scene.options(), scene.start());
    model = refresher.refresh(0, std::span(&at, 1), {});
    limits = {.tools = 1,
              .triangles = static_cast<int>(scene.surface().triangles.size()),
              .nodes = scene.model().mesh().num_nodes(),
              .facets_per_triangle = 1,
              .h = 1e-3};
    ReportOutbox outbox(16, 1e-3);
    for (int tick = 0; tick < 16; ++tick) {
      LocalReport r;
      r.tick = tick;
      r.model_frame = 0;
      r.tools[0] = {{Vec3(0.01 * tick, 0.2, 0.3), Quaternion(0.5, 0.5, 0.5, 0.5)}, tick % 3 - 1, tick % 2 == 0};
      r.left_patch = tick % 5 == 0;
      r.count = tick % 4;
      for (int i = 0; i < r.count; ++i)
        r.samples[static_cast<std::size_t>(i)] = {.triangle = i,
                                                  .facet = tick % 2 == 0 ? -1 : i,
                                                  .bary = Vec3(0.25, 0.5, 0.25),
                                                  .impulse = Vec3(1e-4 * i, -2e-4, 3e-4),
                                                  .normal = Vec3(0.6, 0, 0.8),
                                                  .point = Vec3(0.1, 0.2, 0.3),
                                                  .sticks = i == 1};
      outbox.add(r);
    }
    reports = {outbox.batch(16), 0.25};
    reports.batch.adopted_frame = 3;
    reports.batch.adopted_tick = 12;
    motion.frame = 0;
    motion.motion = make_local_motion(limits.nodes);
    record_motion(*model, 16, motion.motion);
    round_as_sent(motion.motion);
    motion.recovered = static_cast<int>(model->model.recovered_node.size());
    motion.patch = motion.motion.num_patch;
    motion.reports = reports;
  }
  static BuiltScene make(const std::string& surface) {
    Scene s = small_scene();
    s.link.type = "network";
    s.local.reducer = "krylov";
    s.local.refine = "follow";
    s.contact.surface = surface;
    return BuiltScene(s);
  }
  BuiltScene scene;
  std::unique_ptr<PreparedLocalModel> model;
  WireLimits limits;
  ReportMessage reports;
  MotionMessage motion;
};

void expect_same(const ReportBatch& a, const ReportBatch& b) {
  ASSERT_EQ(a.reports.size(), b.reports.size());
  for (std::size_t i = 0; i < a.reports.size(); ++i) {
    const LocalReport &x = a.reports[i], &y = b.reports[i];
    EXPECT_EQ(x.tick, y.tick);
    EXPECT_EQ(x.left_patch, y.left_patch);
    EXPECT_EQ(x.tools[0].pose.x, y.tools[0].pose.x);
    EXPECT_EQ(x.tools[0].pose.r.coeffs(), y.tools[0].pose.r.coeffs());
    EXPECT_EQ(x.tools[0].triangle, y.tools[0].triangle);
    ASSERT_EQ(x.count, y.count);
    for (std::size_t k = 0; k < static_cast<std::size_t>(x.count); ++k) {
      EXPECT_EQ(x.samples[k].t, y.samples[k].t);
      EXPECT_EQ(x.samples[k].facet, y.samples[k].facet);
      EXPECT_EQ(x.samples[k].bary, y.samples[k].bary);
      EXPECT_EQ(x.samples[k].impulse, y.samples[k].impulse);
      EXPECT_EQ(x.samples[k].normal, y.samples[k].normal);
      EXPECT_EQ(x.samples[k].point, y.samples[k].point);
      EXPECT_EQ(x.samples[k].sticks, y.samples[k].sticks);
    }
  }
  EXPECT_EQ(a.sum, b.sum);
  EXPECT_EQ(a.adopted_frame, b.adopted_frame);
  EXPECT_EQ(a.place[0].contact.triangle, b.place[0].contact.triangle);
}

TEST(Messages, ReportsAndMotionComeBackBitForBit) {
  const Talk talk;
  const auto reports = decode_reports(encode(talk.reports, 1), talk.limits);
  ASSERT_TRUE(reports);
  expect_same(reports->batch, talk.reports.batch);
  EXPECT_EQ(reports->loss, 0.25);
  ReportMessage early = talk.reports;
  early.loss.reset();
  EXPECT_FALSE(decode_reports(encode(early, 1), talk.limits).value().loss);
  early.loss = NAN;
  EXPECT_FALSE(decode_reports(encode(early, 1), talk.limits));
  const auto motion = decode_motion(encode(talk.motion, 1), talk.limits);
  ASSERT_TRUE(motion);
  EXPECT_EQ(motion->frame, talk.motion.frame);
  EXPECT_EQ(motion->motion.tick, 16);
  EXPECT_EQ(motion->motion.x, talk.motion.motion.x.head(3 * talk.motion.recovered));
  EXPECT_EQ(motion->motion.du, talk.motion.motion.du.head(3 * talk.motion.patch));
  expect_same(motion->reports.batch, talk.reports.batch);
}

TEST(Messages, AReportOfOneContactFitsADatagram) {
  Talk talk;
  for (LocalReport& r : talk.reports.batch.reports) r.count = 1;
  talk.reports.batch.reports.resize(7);
  EXPECT_LE(encode(talk.reports, 1).size(), 1152u);
}

TEST(Messages, ALocalModelComesBackAndSaysHowManyBytesItHas) {
  const Talk talk;
  const ModelMessage sent{.model = pack_model(*talk.model, 16),
                          .expected_force_error = 0.01,
                          .force_factor = 1.06,
                          .refresh_ms = 12,
                          .loss = 0.25,
                          .body_ms = 3};
  const Bytes bytes = encode(sent);
  std::printf("%d coordinates, %d patch vertices: %zu bytes\n", sent.model.dof(),
              talk.model->model.patch.num_vertices(), bytes.size());
  const auto come = decode_model(bytes);
  ASSERT_TRUE(come);
  EXPECT_EQ(come->expected_force_error, sent.expected_force_error);
  EXPECT_EQ(come->force_factor, sent.force_factor);
  EXPECT_EQ(come->refresh_ms, sent.refresh_ms);
  EXPECT_EQ(come->loss, sent.loss);
  EXPECT_EQ(come->body_ms, sent.body_ms);
  ModelUnpacker unpacker(talk.scene.model(), talk.scene.surface(), talk.scene.options());
  ASSERT_EQ(unpacker.trouble(come->model), "");
  const auto a = unpacker.unpack(sent.model), b = unpacker.unpack(come->model);
  EXPECT_EQ(a->dynamics->metric().C, b->dynamics->metric().C);
  EXPECT_EQ(a->model.x0, b->model.x0);
  EXPECT_EQ(a->body_x, b->body_x);
  EXPECT_EQ(a->state.q, b->state.q);
  EXPECT_EQ(a->way_out, b->way_out);
  ASSERT_TRUE(a->surface.fine && b->surface.fine);
  EXPECT_EQ(a->surface.fine, b->surface.fine) << "what it is made from came bit for bit";
  ModelMessage stiffer = sent;
  stiffer.model.material = LiveMaterial{3e4, 1, 0.002};
  const auto stiffer_come = decode_model(encode(stiffer));
  ASSERT_TRUE(stiffer_come);
  EXPECT_EQ(stiffer_come->model.material, stiffer.model.material);
}

// The hand's computer has the body at rest: it finds the smooth surface over refined cells itself, the same.
TEST(Messages, RefinedCellsHaveTheSameSmoothSurfaceOnBothSides) {
  const Talk talk("loop");
  ModelUnpacker unpacker(talk.scene.model(), talk.scene.surface(), talk.scene.options());
  const SentModel sent = pack_model(*talk.model, 16);
  ASSERT_EQ(unpacker.trouble(sent), "");
  const auto come = unpacker.unpack(sent);
  ASSERT_TRUE(come->surface.fine && talk.model->surface.fine);
  const std::vector<VertexOffset>&here = come->surface.fine->offsets, &there = talk.model->surface.fine->offsets;
  ASSERT_EQ(here.size(), there.size());
  ASSERT_GT(here.size(), 20u);
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_EQ(here[i].vertex, there[i].vertex);
    EXPECT_EQ(here[i].triangle, there[i].triangle);
    EXPECT_EQ(here[i].along, there[i].along);
  }
  EXPECT_LT((come->surface.offset - talk.model->surface.offset).norm(), 1e-9);
}

TEST(Messages, ControlComesBack) {
  Welcome welcome{
      .session = 7, .key = {1, 2, 3}, .port = 7700, .scene = "{}", .files = {{"body.off", {1, 2}}}, .body_hash = 99};
  const auto w = decode_control(encode(welcome));
  ASSERT_TRUE(w && std::holds_alternative<Welcome>(*w));
  EXPECT_EQ(std::get<Welcome>(*w).key, welcome.key);
  EXPECT_EQ(std::get<Welcome>(*w).files[0].bytes, welcome.files[0].bytes);
  for (const char* name : {"", ".", "..", "../x", "a/b", ".hidden"}) {
    welcome.files[0].name = name;
    EXPECT_FALSE(decode_control(encode(welcome))) << name;  // a file elsewhere
  }
  RecordMessage record;
  record.record.event = {33, -1, 33, 61, {20, 21}};
  record.record.settings = {{33, "contact.mu", 0.7, ""}};
  record.record.reducers = {{33, "a", "b", "slow", 0.1, 0.2}};
  record.record.is_exact = true;
  const auto r = decode_control(encode(record));
  ASSERT_TRUE(r);
  const RefreshRecord& come = std::get<RecordMessage>(*r).record;
  EXPECT_EQ(come.event, record.record.event);
  EXPECT_EQ(come.settings, record.record.settings);
  EXPECT_EQ(come.reducers, record.record.reducers);
  EXPECT_TRUE(come.is_exact && !come.looked_ahead && !come.global_ms);
  const auto h = decode_control(encode(Hello{.version = "x"}));
  EXPECT_EQ(std::get<Hello>(*h).schema, wire_schema_hash());
}

void mutate(Bytes& bytes, std::mt19937& random) {
  const int changes = 1 + static_cast<int>(random() % 4);
  for (int i = 0; i < changes && !bytes.empty(); ++i) {
    const std::size_t at =
        random() % 4 == 0 ? random() % std::min<std::size_t>(bytes.size(), 64) : random() % bytes.size();
    switch (random() % 6) {
      case 0:
        bytes[at] ^= static_cast<std::uint8_t>(1u << (random() % 8));
        break;
      case 1:
        bytes[at] = static_cast<std::uint8_t>(random());
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.insert(bytes.end(), random() % 64, static_cast<std::uint8_t>(random()));
        break;
      case 4:  // a number that is none, or huge
        for (std::size_t k = at & ~std::size_t{7}; k < std::min(bytes.size(), (at & ~std::size_t{7}) + 8); ++k)
          bytes[k] = random() % 2 == 0 ? 0xff : 0x7f;
        break;
      default:
        std::swap(bytes[at], bytes[random() % bytes.size()]);
    }
  }
}

/// Whatever is read is in range; nothing ends the program.
void look_at(const Talk& talk, ModelUnpacker& unpacker, const Bytes& bytes, int& read) {
  if (const auto r = decode_reports(bytes, talk.limits)) {
    ++read;
    for (const LocalReport& report : r->batch.reports) {
      ASSERT_TRUE(report.tools[0].pose.is_finite());
      ASSERT_LE(report.count, kMaxContacts);
      for (const TickContact& c : report.contacts()) {
        ASSERT_TRUE(c.impulse.allFinite() && c.point.allFinite() && c.triangle >= 0 &&
                    c.triangle < talk.limits.triangles);
      }
    }
  }
  if (const auto m = decode_motion(bytes, talk.limits)) {
    ++read;
    ASSERT_TRUE(m->motion.x.allFinite() && m->motion.v.allFinite() && m->motion.du.allFinite());
  }
  if (decode_control(bytes)) ++read;
  if (const auto m = decode_model(bytes)) {
    ++read;
    if (unpacker.trouble(m->model).empty()) {
      ASSERT_TRUE(m->model.q.allFinite() && m->model.x0.allFinite());
    }
  }
}

void mutate_many(int count) {
  const Talk talk;
  ModelUnpacker unpacker(talk.scene.model(), talk.scene.surface(), talk.scene.options());
  const std::vector<Bytes> seeds{encode(talk.reports, 1),
                                 encode(talk.motion, 1),
                                 encode(ModelMessage{pack_model(*talk.model, 16), 0, 0, 0}),
                                 encode(Hello{.version = "1"}),
                                 encode(Begin{7, {Pose{}}, {1.0}, BandPowers{}}),
                                 encode(Welcome{.scene = "{}", .files = {{"body.off", {1, 2, 3}}}})};
  std::mt19937 random(36);
  int read = 0;
  for (int i = 0; i < count; ++i) {
    // Local models are a hundred times as large as the rest.
    const std::size_t which = random() % 40 == 0 ? 2 : std::array<std::size_t, 5>{0, 1, 3, 4, 5}[random() % 5];
    Bytes bytes = seeds[which];
    mutate(bytes, random);
    look_at(talk, unpacker, bytes, read);
    if (testing::Test::HasFatalFailure()) return;
  }
  std::printf("%d of %d messages could be read, and were in range\n", read, count);
}

TEST(Messages, MutatedOnesAreReadInRangeOrNotAtAll) { mutate_many(20000); }
TEST(Messages, AMillionMutatedOnesAreReadInRangeOrNotAtAll) { mutate_many(1000000); }

}  // namespace
}  // namespace kt
