// check_model() passes every model of the table and names each fault that is put into one; the default tangent of
// differences against the models' own.
#include "core/body/check_model.hpp"

#include <gtest/gtest.h>

#include "core/body/difference_tangent.hpp"
#include "core/global/integrator.hpp"
#include "models/model.hpp"
#include "tests/support/dense_truth.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kEdge = 0.01;

std::unique_ptr<DeformableModel> block_of(const std::string& type, const std::string& material = "neo_hookean",
                                          const Vec3& gravity = Vec3::Zero()) {
  Mesh mesh = kuhn_block(3, 2, 2, kEdge);
  ModelOptions options{.young = 5e3, .density = 1050, .damping_mass = 1, .damping_stiffness = 2e-3};
  options.fixed_nodes = nodes_below(mesh, 1e-6);
  options.material = material;
  options.gravity = gravity;
  return make_model(type, std::move(mesh), options);
}

/// A neo-Hookean block with something wrong in it.
struct Faulty : DeformableModel {
  explicit Faulty(std::unique_ptr<DeformableModel> right = block_of("fem")) : right_(std::move(right)) {}
  const Mesh& mesh() const override { return right_->mesh(); }
  const SparseMatrix& mass() const override { return right_->mass(); }
  const std::vector<int>& fixed_nodes() const override { return right_->fixed_nodes(); }
  void force(const State& state, VectorX& out) const override { right_->force(state, out); }
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    right_->update_tangent(state, kind, out);
  }
  std::unique_ptr<DeformableModel> right_;
};

/// The same physics by the four functions that a model needs at least.
struct Smallest final : DeformableModel {
  const Mesh& mesh() const override { return right_->mesh(); }
  const SparseMatrix& mass() const override { return right_->mass(); }
  const std::vector<int>& fixed_nodes() const override { return right_->fixed_nodes(); }
  void force(const State& state, VectorX& out) const override { right_->force(state, out); }
  std::unique_ptr<DeformableModel> right_ = block_of("fem");
};

State shaken(const DeformableModel& model, double strain) {
  State s = rest_state(model);
  s.x += strain * kEdge * random_vector(s.x.size(), 1);
  s.v = 0.05 * random_vector(s.x.size(), 2);
  return s;
}

/// Names of what is broken, in order; a name that begins alike only once.
std::vector<std::string> broken(const DeformableModel& model) {
  std::vector<std::string> out;
  for (const ModelFinding& f : check_model(model).findings)
    if (f.verdict == ModelVerdict::broken) {
      const std::string name = f.name.substr(0, f.name.find(" at rest"));
      if (out.empty() || f.name.rfind(out.back(), 0) != 0) out.push_back(name);
    }
  return out;
}

bool has(const std::vector<std::string>& names, const std::string& begin) {
  return std::ranges::any_of(names, [&](const std::string& n) { return n.rfind(begin, 0) == 0; });
}

TEST(CheckModel, PassesEveryModelAndMaterial) {
  for (const auto& [type, material] :
       {std::pair("msd", "neo_hookean"), std::pair("fem", "neo_hookean"), std::pair("fem", "corotational"),
        std::pair("fem", "stvk"), std::pair("fem", "linear")})
    for (const Vec3& gravity : {Vec3(0, 0, 0), Vec3(0, 0, -9.81)}) {
      const ModelCheck check = check_model(*block_of(type, material, gravity));
      EXPECT_TRUE(check.passed()) << type << " " << material << "\n" << check.text();
      EXPECT_GT(check.findings.size(), 20u);
      const bool turns =
          std::ranges::none_of(check.findings, [](const ModelFinding& f) { return f.verdict == ModelVerdict::told; });
      EXPECT_EQ(turns, std::string(material) != "linear") << check.text();
    }
}

TEST(CheckModel, NamesATangentThatIsNotTheDerivative) {
  struct NoGeometricPart final : Faulty {
    void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
      right_->update_tangent(kind == TangentKind::definite ? state : rest_state(*right_), kind, out);
    }
  };
  EXPECT_TRUE(has(broken(NoGeometricPart()), "dfdx deformed"));
  struct WrongSign final : Faulty {
    void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
      right_->update_tangent(state, kind, out);
      out.dfdx = -out.dfdx;
    }
  };
  const auto signs = broken(WrongSign());
  EXPECT_TRUE(has(signs, "dfdx") && has(signs, "definite tangent"));
  struct NoDamping final : Faulty {
    void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
      right_->update_tangent(state, kind, out);
      out.dfdv *= 0;
    }
  };
  EXPECT_TRUE(has(broken(NoDamping()), "dfdv"));
}

TEST(CheckModel, NamesTheTangentThatIsNotDefiniteWhereItHasToBe) {
  struct Exact final : Faulty {
    void update_tangent(const State& state, TangentKind, Tangent& out) const override {
      right_->update_tangent(state, TangentKind::exact, out);
    }
  };
  EXPECT_EQ(broken(Exact()),
            (std::vector<std::string>{"definite tangent deformed and moving", "definite tangent squeezed"}));
}

TEST(CheckModel, NamesForcesThatMoveTheBody) {
  struct Pushed final : Faulty {  // each node is drawn back to its place
    void force(const State& state, VectorX& out) const override {
      right_->force(state, out);
      out -= 10 * (state.x - mesh().x);
    }
    void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
      right_->update_tangent(state, kind, out);
      SparseMatrix identity(out.dfdx.rows(), out.dfdx.cols());
      identity.setIdentity();
      out.dfdx -= 10 * identity;
    }
  };
  const auto names = broken(Pushed());
  EXPECT_TRUE(has(names, "momentum") && has(names, "forces elsewhere"));
  EXPECT_TRUE(check_model(Pushed(), {.anchored = true}).passed());
}

TEST(CheckModel, NamesEnergyOutOfNothing) {
  struct Follower final : Faulty {  // a force across each displacement
    void force(const State& state, VectorX& out) const override {
      right_->force(state, out);
      for (int i = 0; i + 1 < mesh().num_nodes(); i += 2) {
        const Vec3 across = 2 * Vec3(0, 0, 1).cross(Vec3(node(state.x, i) - node(state.x, i + 1)));
        node(out, i) += across;
        node(out, i + 1) -= across;
      }
    }
    void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
      difference_tangent(*this, state, kind, out);
    }
  };
  EXPECT_EQ(broken(Follower()), std::vector<std::string>{"springs give back"});
  struct Pushes final : Faulty {
    void force(const State& state, VectorX& out) const override {
      State still = state;
      still.v.setZero();
      VectorX springs;
      right_->force(still, springs);
      right_->force(state, out);
      out = 2 * springs - out;
    }
    void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
      difference_tangent(*this, state, kind, out);
    }
  };
  EXPECT_TRUE(has(broken(Pushes()), "dampers take"));
}

TEST(CheckModel, EndsAtWrongSizesAndNamesThem) {
  struct Short final : Faulty {
    void force(const State& state, VectorX& out) const override {
      right_->force(state, out);
      out.conservativeResize(out.size() - 3);
    }
  };
  EXPECT_EQ(broken(Short()), std::vector<std::string>{"size of the force"});
  struct NotFinite final : Faulty {
    void force(const State& state, VectorX& out) const override {
      right_->force(state, out);
      if (state.x != mesh().x) out[0] = std::numeric_limits<double>::quiet_NaN();
    }
  };
  EXPECT_EQ(broken(NotFinite()), std::vector<std::string>{"force deformed and moving"});
  struct Unsorted final : Faulty {
    const std::vector<int>& fixed_nodes() const override { return nodes_; }
    std::vector<int> nodes_{3, 1};
  };
  EXPECT_EQ(broken(Unsorted()), std::vector<std::string>{"fixed nodes"});
  struct Weightless final : Faulty {
    const SparseMatrix& mass() const override { return mass_; }
    SparseMatrix mass_ = 0 * right_->mass();
  };
  EXPECT_EQ(broken(Weightless()), std::vector<std::string>{"mass"});
}

TEST(DifferenceTangent, IsTheModelsOwn) {
  for (const char* type : {"msd", "fem"}) {
    const auto model = block_of(type);
    for (double strain : {0.0, 0.1}) {
      const State s = shaken(*model, strain);
      const Tangent own = model->tangent(s, TangentKind::exact);
      Tangent found;
      difference_tangent(*model, s, TangentKind::exact, found);
      EXPECT_LE(relative_error(found.dfdx, own.dfdx), 1e-7) << type << strain;
      EXPECT_LE(relative_error(found.dfdv, own.dfdv), 1e-7) << type << strain;
    }
  }
}

TEST(DifferenceTangent, IsDefiniteWithinAFactorOfFourOfWhatItTakes) {
  const auto model = block_of("fem", "stvk");
  State s = shaken(*model, 0.1);
  s.x *= 0.6;
  Tangent exact, definite;
  difference_tangent(*model, s, TangentKind::symmetric, exact);
  difference_tangent(*model, s, TangentKind::definite, definite);
  const double least = symmetric_eigenvalues(-MatrixX(exact.dfdx))[0];
  const VectorX values = symmetric_eigenvalues(-MatrixX(definite.dfdx));
  ASSERT_LT(least, -1e-3 * values.maxCoeff());  // a case that needs it
  EXPECT_GE(values[0], 0);
  EXPECT_LE(values[0] - least, -4 * least);
}

TEST(DifferenceTangent, StepsTheSmallestModelAsItsOwnTangentDoes) {
  const Smallest smallest;
  EXPECT_TRUE(check_model(smallest).passed()) << check_model(smallest).text();
  State a = shaken(*smallest.right_, 0.05), b = a;
  for (int i = 0; i < 5; ++i) {
    make_integrator("newton_euler")->step(smallest, VectorX::Zero(a.x.size()), 1e-2, a);
    make_integrator("newton_euler")->step(*smallest.right_, VectorX::Zero(b.x.size()), 1e-2, b);
  }
  EXPECT_LE((a.x - b.x).lpNorm<Eigen::Infinity>(), 1e-9 * kEdge);  // the same equation, solved with another matrix
}

}  // namespace
}  // namespace kt
