#include "core/body/check_model.hpp"
#include "python/bindings.hpp"

namespace kt {
namespace {

/// Indices that are there and finite numbers: scipy's matrices may hold any.
const SparseMatrix& checked(const SparseMatrix& m, const char* what, Eigen::Index n) {
  if (m.rows() != n || m.cols() != n)
    throw RunError(text(what, ": ", m.rows(), " x ", m.cols(), ", must be ", n, " x ", n, ": 3 a node"));
  const int *outer = m.outerIndexPtr(), *inner = m.innerIndexPtr();
  bool is_right = outer[0] == 0 && outer[n] == m.nonZeros();
  for (Eigen::Index j = 0; is_right && j < n; ++j) is_right = outer[j] <= outer[j + 1];
  for (Eigen::Index k = 0; is_right && k < m.nonZeros(); ++k) is_right = inner[k] >= 0 && inner[k] < n;
  if (!is_right) throw RunError(text(what, ": indices of the sparse matrix are out of range"));
  for (Eigen::Index k = 0; k < m.nonZeros(); ++k)
    if (!std::isfinite(m.valuePtr()[k])) throw RunError(text(what, ": a number is not finite"));
  return m;
}

/// In a call of Python: with the interpreter's lock, and nothing that would wait for the body.
class InModel {
 public:
  InModel() { is_in_model() = true; }
  ~InModel() { is_in_model() = false; }
  InModel(const InModel&) = delete;
  InModel& operator=(const InModel&) = delete;

 private:
  const py::gil_scoped_acquire gil_;
};

/// A model whose physics is Python's. What never changes is held here, so that nothing of ours points into Python;
/// force and tangent are called at the body's rate, never in a haptic tick.
class PythonModel final : public DeformableModel {
 public:
  explicit PythonModel(const py::object& own)
      : own_(own), mesh_(own.attr("mesh").cast<Mesh>()), mass_(own.attr("mass").cast<SparseMatrix>()) {
    for (const auto& i : own.attr("fixed")) fixed_.push_back(i.cast<int>());
    std::ranges::sort(fixed_);
    try {
      checked(mass_, "mass", mesh_.x.size());
    } catch (const RunError& e) {
      throw InputError(e.what());
    }
    mass_.makeCompressed();
    const VectorX diagonal = mass_.diagonal();
    if (!(diagonal.minCoeff() > 0)) throw InputError(text("mass: ", diagonal.minCoeff(), " kg, must be above 0"));
    for (const int i : fixed_)
      if (i < 0 || i >= mesh_.num_nodes())
        throw InputError(text("fixed: node ", i, " is outside 0 .. ", mesh_.num_nodes(), " - 1"));
    fixed_.erase(std::unique(fixed_.begin(), fixed_.end()), fixed_.end());
    if (static_cast<int>(fixed_.size()) == mesh_.num_nodes())
      throw InputError("fixed: all nodes are clamped, nothing could be felt but a wall");
    has_tangent_ = py::hasattr(own, "tangent") && !own.attr("tangent").is_none();
  }
  ~PythonModel() override {
    const py::handle own = own_.release();
    if (!Py_IsInitialized()) return;  // too late to free it
    const py::gil_scoped_acquire gil;
    own.dec_ref();
  }

  const Mesh& mesh() const override { return mesh_; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return fixed_; }

  void force(const State& state, VectorX& out) const override {
    call("force", [&] {
      const auto given = py::array::ensure(own_.attr("force")(copy_of(state.x), copy_of(state.v)));
      const auto n = state.x.size();
      const bool is_real = given && std::string_view("fiu").find(given.dtype().kind()) != std::string_view::npos;
      const bool is_flat = is_real && given.ndim() == 1 && given.size() == n;
      const bool is_rows = is_real && given.ndim() == 2 && given.shape(1) == 3 && given.size() == n;
      if (!is_flat && !is_rows)
        throw RunError(text("model.force: must give ", n, " numbers [N], 3 a node: (", n / 3, ", 3)"));
      const auto f = numbers_in<Floats>(given);
      out = Eigen::Map<const VectorX>(f.data(), f.size());
    });
  }

  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    if (!has_tangent_) return DeformableModel::update_tangent(state, kind, out);
    call("tangent", [&] {
      const py::object both = own_.attr("tangent")(copy_of(state.x), copy_of(state.v), kind == TangentKind::definite);
      const auto pair = both.cast<std::pair<SparseMatrix, SparseMatrix>>();
      out.dfdx = checked(pair.first, "model.tangent: dfdx", state.x.size());
      out.dfdv = checked(pair.second, "model.tangent: dfdv", state.x.size());
      out.dfdx.makeCompressed();
      out.dfdv.makeCompressed();
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
    const InModel here;
    bool is_again = false;
    for (;;) try {
        return f();
      } catch (py::error_already_set& e) {
        // Ctrl-C is the program's, not the model's: once more, and Python is interrupted when it is back in its own
        // code.
        if (!std::exchange(is_again, e.matches(PyExc_KeyboardInterrupt)) && is_again) {
          was_interrupted() = true;
          continue;
        }
        throw RunError(text("model.", what, ": ", py::str(e.type().attr("__name__")).cast<std::string>(), ": ",
                            py::str(e.value()).cast<std::string>()));
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
      "Tries a model at rest and in random states. Gives (whether nothing is broken, a line for each finding). Nodes "
      "are "
      "moved by up to the share strain of their shortest edge. An anchored model may depend on its place.");
}

}  // namespace kt
