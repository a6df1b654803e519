#include "core/body/check_model.hpp"
#include "python/bindings.hpp"

namespace kt {
namespace {

/// A model whose physics is Python's. What never changes is held here, so that nothing of ours points into Python;
/// force and tangent are called at the body's rate, never in a haptic tick.
class PythonModel final : public DeformableModel {
 public:
  explicit PythonModel(const py::object& own)
      : own_(own), mesh_(own.attr("mesh").cast<Mesh>()), mass_(own.attr("mass").cast<SparseMatrix>()) {
    for (const auto& i : own.attr("fixed")) fixed_.push_back(i.cast<int>());
    std::ranges::sort(fixed_);
    const auto n = mesh_.x.size();
    if (mass_.rows() != n || mass_.cols() != n)
      throw InputError(text("mass: ", mass_.rows(), " x ", mass_.cols(), ", must be ", n, " x ", n, ": 3 a node"));
    for (const int i : fixed_)
      if (i < 0 || i >= mesh_.num_nodes())
        throw InputError(text("fixed: node ", i, " is outside 0 .. ", mesh_.num_nodes(), " - 1"));
    fixed_.erase(std::unique(fixed_.begin(), fixed_.end()), fixed_.end());
    has_tangent_ = py::hasattr(own, "tangent") && !own.attr("tangent").is_none();
  }
  ~PythonModel() override {
    const py::gil_scoped_acquire gil;
    own_.release().dec_ref();
  }

  const Mesh& mesh() const override { return mesh_; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return fixed_; }

  void force(const State& state, VectorX& out) const override {
    call("force", [&] {
      const auto f = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(
          own_.attr("force")(copy_of(state.x), copy_of(state.v)));
      if (!f || f.size() != state.x.size()) {
        PyErr_Clear();
        throw RunError(text("model.force: must give ", state.x.size(), " numbers [N], 3 a node"));
      }
      out = Eigen::Map<const VectorX>(f.data(), f.size());
    });
  }

  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    if (!has_tangent_) return DeformableModel::update_tangent(state, kind, out);
    call("tangent", [&] {
      const py::object both = own_.attr("tangent")(copy_of(state.x), copy_of(state.v), kind == TangentKind::definite);
      const auto pair = both.cast<std::pair<SparseMatrix, SparseMatrix>>();
      const auto n = state.x.size();
      if (pair.first.rows() != n || pair.first.cols() != n || pair.second.rows() != n || pair.second.cols() != n)
        throw RunError(text("model.tangent: must give two matrices of ", n, " x ", n, ": dfdx and dfdv"));
      out.dfdx = pair.first;
      out.dfdv = pair.second;
    });
  }
  ModelInfo info() const override { return {"python", "", {}}; }

 private:
  static py::array_t<double> copy_of(const VectorX& x) {
    return py::array_t<double>({x.size() / 3, Eigen::Index{3}}, x.data());
  }
  /// With the GIL; what Python raises ends the body's simulation, with its words.
  template <class F>
  void call(const char* what, F&& f) const {
    const py::gil_scoped_acquire gil;
    try {
      f();
    } catch (py::error_already_set& e) {
      throw RunError(text("model.", what, ": ", e.what()));
    } catch (const py::cast_error&) {
      throw RunError(text("model.", what, ": gave something else than scipy's sparse matrices"));
    }
  }

  py::object own_;
  Mesh mesh_;
  SparseMatrix mass_;
  std::vector<int> fixed_;
  bool has_tangent_ = false;
};

}  // namespace

std::unique_ptr<DeformableModel> model_of(const py::object& own) {
  for (const char* needed : {"mesh", "mass", "fixed", "force"})
    if (!py::hasattr(own, needed)) throw InputError(text("model: has no ", needed, "; derive from kilotouch.Model"));
  try {
    return std::make_unique<PythonModel>(own);
  } catch (const py::cast_error&) {
    throw InputError("model: mesh must be a kilotouch.Mesh, mass scipy's sparse (3n x 3n), fixed indices of nodes");
  }
}

void bind_model(py::module_& m) {
  m.def(
      "check_model",
      [](const py::object& own, double strain, bool anchored) {
        const auto model = model_of(own);
        ModelCheckOptions options;
        options.strain = strain;
        options.anchored = anchored;
        const ModelCheck check = check_model(*model, options);
        return py::make_tuple(check.passed(), check.text());
      },
      py::arg("model"), py::arg("strain") = ModelCheckOptions{}.strain, py::arg("anchored") = false,
      "Tries a model at rest and in random states: (whether nothing is broken, a line for each finding). strain: nodes "
      "are moved by up to this share of their shortest edge. anchored: it may depend on where it is.");
}

}  // namespace kt
