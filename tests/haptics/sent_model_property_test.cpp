// A local model that travels: what the hand's computer makes of it answers as the body's does.
#include <gtest/gtest.h>

#include "core/local/local_dynamics.hpp"
#include "haptics/refresh/refresher.hpp"
#include "haptics/remote/model_unpacker.hpp"
#include "haptics/remote/yield_memory.hpp"
#include "haptics/setup/built_scene.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

/// The local model of a pressed block.
struct Pressed {
  explicit Pressed(const std::string& reducer, const std::string& surface = "flat", const std::string& refine = "off",
                   const std::string& body = "mesh")
      : scene(make(reducer, surface, refine, body)) {
    const TouchOptions& o = scene.options();
    Refresher refresher(scene.model(), scene.surface(), o, scene.start());
    const Pose at{{0.03, 0.026, 0.038}, Quaternion::Identity()};
    model = refresher.refresh(0, std::span(&at, 1), {});
  }
  static BuiltScene make(const std::string& reducer, const std::string& surface, const std::string& refine,
                         const std::string& body) {
    Scene s = small_scene();
    s.object.body = body;
    if (body == "lattice") s.object.model.type = "fem";
    if (body == "lattice") s.local.refine_nodes = 200;  // too few for cells of the size that is wanted
    s.link.type = "network";
    s.local.reducer = reducer;
    s.contact.surface = surface;
    s.local.refine = refine;
    return BuiltScene(s);
  }
  ModelUnpacker unpacker() const { return {scene.model(), scene.surface(), scene.options()}; }
  BuiltScene scene;
  std::unique_ptr<PreparedLocalModel> model;
};

double relative(const MatrixX& a, const MatrixX& b) { return (a - b).norm() / b.norm(); }

TEST(SentModel, ContactAnswersWithinATenThousandthWhateverTheReducer) {
  for (const char* reducer : {"krylov", "condensed", "modal", "wall"}) {
    const Pressed p(reducer);
    ModelUnpacker unpacker = p.unpacker();
    const SentModel sent = pack_model(*p.model, 16);
    ASSERT_EQ(unpacker.trouble(sent), "") << reducer;
    const auto there = unpacker.unpack(sent);
    EXPECT_LT(relative(there->dynamics->metric().C, p.model->dynamics->metric().C), 1e-4) << reducer;
    EXPECT_LT(relative(there->dynamics->inertia().C, p.model->dynamics->inertia().C), 1e-4) << reducer;
    const MatrixX& C = there->dynamics->metric().C;
    EXPECT_LT((C - C.transpose()).norm(), 1e-12 * C.norm()) << reducer;
    EXPECT_EQ(there->surface.facets.global_triangle, p.model->surface.facets.global_triangle) << reducer;
    EXPECT_EQ(there->apron_facet, p.model->apron_facet) << reducer;
    EXPECT_EQ(there->recovered_row, p.model->recovered_row) << reducer;
    const SentModel rough = pack_model(*p.model, 8);
    ASSERT_EQ(unpacker.trouble(rough), "") << reducer;
    const auto roughly = unpacker.unpack(rough);
    EXPECT_LT(relative(roughly->dynamics->metric().C, p.model->dynamics->metric().C), 2e-2) << reducer;
  }
}

TEST(SentModel, SparseMatricesTravelAsSuchAndComeWithTheSameBits) {
  const Pressed p("wall");
  const SentModel sent = pack_model(*p.model, 16);
  const auto r = static_cast<std::size_t>(sent.dof());
  ASSERT_TRUE(sent.stiffness.is_sparse());
  EXPECT_LT(sent.stiffness.values.size(), r * (r + 1) / 6);
  ModelUnpacker unpacker = p.unpacker();
  ASSERT_EQ(unpacker.trouble(sent), "");
  const auto there = unpacker.unpack(sent);
  const MatrixX lower = MatrixX(p.model->model.stiffness).triangularView<Eigen::Lower>();
  EXPECT_EQ(MatrixX(MatrixX(there->model.stiffness).triangularView<Eigen::Lower>()), lower);
  EXPECT_EQ(MatrixX(there->model.stiffness), MatrixX(there->model.stiffness.transpose()));
  const std::vector<std::function<void(SentMatrix&)>> wrongs{
      [](SentMatrix& m) { m.first.pop_back(); },
      [](SentMatrix& m) { m.first[0] = 1; },
      [](SentMatrix& m) { m.first[1] = -1; },
      [](SentMatrix& m) { m.first[1] = 1 << 30; },
      [](SentMatrix& m) { ++m.first.back(); },
      [](SentMatrix& m) { m.row.pop_back(); },
      [](SentMatrix& m) { m.values.pop_back(); },
      [](SentMatrix& m) { m.row[0] = -1; },
      [](SentMatrix& m) { m.row.back() = 1 << 20; },
      [](SentMatrix& m) { m.row[1] = m.row[0]; },
      [](SentMatrix& m) { m.row[static_cast<std::size_t>(m.first[4])] = 3; },  // above the diagonal
      [](SentMatrix& m) { m.is_diagonal = true; },
      [](SentMatrix& m) { m.values[0] = std::numeric_limits<double>::quiet_NaN(); },
      [](SentMatrix& m) { m.values[0] = -1; },
  };
  for (std::size_t i = 0; i < wrongs.size(); ++i) {
    SentModel wrong = sent;
    wrongs[i](wrong.stiffness);
    EXPECT_NE(unpacker.trouble(wrong), "") << "number " << i;
  }
}

TEST(SentModel, UnpackedTwiceIsTheSameBits) {
  const Pressed p("krylov", "loop");
  ModelUnpacker unpacker = p.unpacker();
  const SentModel sent = pack_model(*p.model, 16);
  const auto a = unpacker.unpack(sent), b = unpacker.unpack(sent);
  EXPECT_EQ(a->dynamics->metric().C, b->dynamics->metric().C);
  EXPECT_EQ(a->work.x, b->work.x);
  EXPECT_EQ(a->state.q, b->state.q);
}

TEST(SentModel, WhatDoesNotFitIsNamedAndNothingElse) {
  const Pressed p("krylov");
  const ModelUnpacker unpacker = p.unpacker();
  const SentModel right = pack_model(*p.model, 16);
  ASSERT_EQ(unpacker.trouble(right), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(SentModel&)>> wrongs{
      [](SentModel& m) { m.triangles[0] = -1; },
      [](SentModel& m) { m.triangles.back() = 1 << 20; },
      [](SentModel& m) { std::swap(m.triangles[0], m.triangles[1]); },
      [](SentModel& m) {
        m.more_nodes = {5, 5};
      },
      [](SentModel& m) { m.more_nodes = {1 << 20}; },
      [&](SentModel& m) { m.x0[3] = nan; },
      [](SentModel& m) { m.v0.pop_back(); },
      [](SentModel& m) { m.basis.scale[0] = -1; },
      [](SentModel& m) { m.basis.value.pop_back(); },
      [](SentModel& m) { m.basis.rows = 7; },
      [](SentModel& m) { m.mass.values[0] = 0; },
      [](SentModel& m) { m.mass.values[0] = -1; },
      [](SentModel& m) { m.stiffness.values[0] = -1; },
      [](SentModel& m) { m.damping.values[0] = -1; },
      [](SentModel& m) { m.stiffness.values.pop_back(); },
      [&](SentModel& m) { m.f0[0] = nan; },
      [](SentModel& m) { m.q = VectorX::Zero(3); },
      [&](SentModel& m) { m.q_rate[0] = std::numeric_limits<double>::infinity(); },
      [&](SentModel& m) { m.du[0] = nan; },
      [](SentModel& m) { m.scheme = static_cast<LocalScheme>(9); },
      [](SentModel& m) { m.site.triangle = -5; },
      [&](SentModel& m) { m.site.reach = nan; },
      [&](SentModel& m) { m.places[0].x() = nan; },
      [](SentModel& m) { m.way_out[0] = 1 << 20; },
      [](SentModel& m) { m.overlap[0].left = 3; },
      [](SentModel& m) { m.body.at.pop_back(); },
      [&](SentModel& m) { m.body.low.x() = nan; },
      [](SentModel& m) {
        m.friction = Friction{-1, 0.2, 0};
      },
      [&](SentModel& m) {
        m.friction = Friction{nan, nan, 0};
      },
      [](SentModel& m) { m.f0 = VectorX(); },
      [](SentModel& m) {
        SentAnchor a;
        a.contact.triangle = 0;
        a.contact.bary = Vec3(2, -1, 0);
        a.contact.normal = Vec3::UnitZ();
        m.anchors.push_back(a);
      },
  };
  for (std::size_t i = 0; i < wrongs.size(); ++i) {
    SentModel wrong = right;
    wrongs[i](wrong);
    EXPECT_NE(unpacker.trouble(wrong), "") << "number " << i;
  }
}

/// Refined cells are made on the hand's computer from some nodes' places: R is that of the body's, bit for bit.
TEST(SentModel, RefinedCellsAreMadeAgainWithTheSameBits) {
  for (const auto& [reducer, body] : {std::pair("krylov", "mesh"), {"condensed", "mesh"}, {"krylov", "lattice"}}) {
    const Pressed p(reducer, "flat", "follow", body);
    const FinePatch& here = *p.model->surface.fine;
    ASSERT_GT(here.num_yielding(), body == std::string("lattice") ? 10 : 20);
    EXPECT_EQ(here.apart > 0, body == std::string("lattice"));
    ModelUnpacker unpacker = p.unpacker();
    const SentModel sent = pack_model(*p.model, 16);
    ASSERT_EQ(unpacker.trouble(sent), "") << reducer;
    const auto there = unpacker.unpack(sent);
    ASSERT_TRUE(there->surface.fine);
    EXPECT_EQ(there->surface.fine->R, here.R);
    EXPECT_EQ(there->surface.fine->facets, here.facets);
    EXPECT_EQ(there->surface.fine->corners, here.corners);
    EXPECT_EQ(there->surface.fine->weight, here.weight);
    EXPECT_EQ(there->surface.fine->share, here.share);
    EXPECT_EQ(there->surface.fine->is_place, here.is_place);
    EXPECT_EQ(there->surface.fine->apart, here.apart);
    EXPECT_EQ(there->surface.fine->width, here.width);
    EXPECT_EQ(there->surface.fine->retardation, here.retardation);
    EXPECT_EQ(there->surface.fine->fineness, here.fineness);
    EXPECT_EQ(there->state.yielded.size(), p.model->state.yielded.size());
    EXPECT_EQ(unpacker.unpack(sent)->surface.fine, there->surface.fine) << "nothing has changed";
  }
}

/// What had yielded by the tick of the linearization goes on, by its place; nothing is made up where it is not known.
TEST(SentModel, GoesOnFromWhatHadYielded) {
  const Pressed p("krylov", "flat", "follow");
  ModelUnpacker unpacker = p.unpacker();
  const auto before = unpacker.unpack(pack_model(*p.model, 16)), after = unpacker.unpack(pack_model(*p.model, 16));
  YieldMemory memory;
  memory.add(*before);
  LocalMotion motion = make_local_motion(p.scene.model().mesh().num_nodes());
  for (const int tick : {7, 20}) {
    before->state.yielded.setConstant(1e-4 * tick);
    record_motion(*before, tick, motion);
    memory.note(motion);
  }
  memory.start(*after, 7);
  EXPECT_LT((after->state.yielded.array() - 7e-4).abs().maxCoeff(), 1e-12);
  memory.start(*after, 8);
  EXPECT_EQ(after->state.yielded.norm(), 0);
}

/// Of a body that has been made twice as stiff while it was touched.
TEST(SentModel, RefinedCellsAreOfTheMaterialThatTheModelWasMadeOf) {
  const Pressed p("krylov", "flat", "follow");
  const BodyOptions& body = p.scene.body().options();
  ModelUnpacker unpacker(p.scene.body(), p.scene.options());
  SentModel sent = pack_model(*p.model, 16);
  const SceneModel& material = body.object.model;
  sent.material = LiveMaterial{2 * material.young, material.damping.mass, 3 * material.damping.stiffness};
  ASSERT_EQ(unpacker.trouble(sent), "");
  const auto there = unpacker.unpack(sent);
  const FinePatch& here = *p.model->surface.fine;
  EXPECT_LT(relative(2 * there->surface.fine->R, here.R), 1e-9);
  EXPECT_DOUBLE_EQ(there->surface.fine->retardation, 3 * here.retardation);
  sent.material.reset();
  EXPECT_EQ(unpacker.unpack(sent)->surface.fine->R, here.R);
}

TEST(SentModel, RefinedCellsThatDoNotFitAreNamed) {
  const Pressed p("krylov", "flat", "follow");
  ModelUnpacker unpacker = p.unpacker();
  const SentModel right = pack_model(*p.model, 16);
  ASSERT_EQ(unpacker.trouble(right), "");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(FineOrigin&)>> wrongs{
      [&](FineOrigin& f) { f.options.centre.y() = nan; },
      [&](FineOrigin& f) { f.options.radius = nan; },
      [](FineOrigin& f) { f.options.reach = -1; },
      [](FineOrigin& f) { f.options.reach = 3 * f.options.size.flat; },  // all of a scan
      [&](FineOrigin& f) { f.options.apart = nan; },
      [](FineOrigin& f) { f.options.size.edge = 0; },
      [](FineOrigin& f) { f.options.size.edge = 1e-9; },  // would not fit into memory
      [](FineOrigin& f) { f.options.size.flat = 1; },
      [](FineOrigin& f) { f.options.size.slope = 0; },
      [](FineOrigin& f) { f.options.size.least_flat = -1; },
      [](FineOrigin& f) { f.options.most_nodes = 1 << 20; },
      [](FineOrigin& f) { f.options.most_nodes = 0; },
      [](FineOrigin& f) { f.options.others.assign(50, f.options.centre); },
      [&](FineOrigin& f) { f.fineness = nan; },
      [&](FineOrigin& f) { f.x[2] = nan; },
      [](FineOrigin& f) { f.v[0] = std::numeric_limits<double>::infinity(); },
      [](FineOrigin& f) { f.v = VectorX(); },
  };
  for (std::size_t i = 0; i < wrongs.size(); ++i) {
    SentModel wrong = right;
    auto origin = std::make_shared<FineOrigin>(*right.fine);
    wrongs[i](*origin);
    wrong.fine = origin;
    EXPECT_NE(unpacker.trouble(wrong), "") << "number " << i;
  }
  auto fewer = std::make_shared<FineOrigin>(*right.fine);
  fewer->x = fewer->v = VectorX::Zero(3);
  SentModel wrong = right;
  wrong.fine = fewer;
  EXPECT_THROW(unpacker.unpack(wrong), RunError);
  auto inside_out = std::make_shared<FineOrigin>(*right.fine);
  inside_out->x = -inside_out->x;
  wrong.fine = inside_out;
  try {  // whatever comes of it is finite
    EXPECT_TRUE(unpacker.unpack(wrong)->surface.fine->R.allFinite());
  } catch (const std::runtime_error&) {
  }
  wrong = right;
  wrong.material = LiveMaterial{-1, 0, 0};
  EXPECT_NE(unpacker.trouble(wrong), "");
  const Pressed off("krylov");
  ModelUnpacker without = off.unpacker();
  SentModel with = pack_model(*off.model, 16);
  with.fine = right.fine;
  EXPECT_NE(without.trouble(with), "");
}

TEST(SentModel, MethodsThatNeedTheRefreshesMapsDoNotTravel) {
  Scene s = small_scene();
  s.local.method = "hold";
  const BuiltScene built(s);
  EXPECT_THROW(require_sendable(built.options()), InputError);
}

}  // namespace
}  // namespace kt
