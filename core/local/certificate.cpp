#include "core/local/certificate.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>

#include "core/base/error.hpp"
#include "core/base/stages.hpp"
#include "core/linear/dense/complex_symmetric.hpp"
#include "core/linear/dense/dense_solvers.hpp"

namespace kt {
namespace {

using Complex = std::complex<double>;

constexpr double kUnbalanced = 1e-5;  // of the load: a thousandth of the least error that is asked for, and less
constexpr int kSetUpSteps = 4;

bool is_movable(const LocalModel& model, int vertex) {
  return SparseMatrix(model.basis.middleRows(3 * vertex, 3)).norm() > 0;
}

/// No edge of the patch's border ends there.
bool is_inside(const SurfacePatch& patch, int vertex) {
  if (patch.embedded) return patch.in_reach[static_cast<std::size_t>(vertex)] != 0;  // a corner of a cell
  for (int t : patch.topology.triangles_of(vertex))
    for (std::size_t e = 0; e < 3; ++e)
      if (patch.topology.across[t][e] == -1 &&
          (patch.triangles[t][e] == vertex || patch.triangles[t][(e + 1) % 3] == vertex))
        return false;
  return true;
}

double worst_of(const std::vector<double>& errors) {
  double worst = 0;
  for (double e : errors)
    if (!std::isnan(e)) worst = std::max(worst, e);
  return worst;
}

}  // namespace

std::vector<int> certified_vertices(const LocalModel& model, const ContactSite& site, int count) {
  std::vector<int> candidates;
  for (const bool only_inside : {true, false}) {
    for (int v = 0; v < model.patch.num_vertices(); ++v)
      if (is_movable(model, v) && (!only_inside || is_inside(model.patch, v))) candidates.push_back(v);
    if (!candidates.empty()) break;
  }
  std::vector<Vec3> centres{site.centre};
  for (const ContactSite& other : site.others) centres.push_back(other.centre);
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < count && chosen.size() < candidates.size()) {
    int best = -1;
    double best_value = -1;
    for (int v : candidates) {
      const Vec3 p = node(model.x0, v);
      double apart = std::numeric_limits<double>::infinity();
      for (int c : chosen) apart = std::min(apart, (p - node(model.x0, c)).norm());
      const double value = chosen.size() < centres.size() ? 1 / (1e-12 + (p - centres[chosen.size()]).norm()) : apart;
      if (value > best_value && apart > 0) {
        best_value = value;
        best = v;
      }
    }
    if (best < 0) break;
    chosen.push_back(best);
  }
  return chosen;
}

BodyCertificate::BodyCertificate(const FreeBody& body, const SurfacePatch& patch, std::vector<int> vertices,
                                 std::span<const double> hz)
    : vertices_(std::move(vertices)), hz_(hz.begin(), hz.end()) {
  for (double f : hz_) {
    std::vector<int> nodes;
    for (int v : vertices_) nodes.push_back(patch.global_node[static_cast<std::size_t>(v)]);
    compliance_.push_back(BodyCompliance(body, f).at(nodes, kUnbalanced));
  }
}

Certificate BodyCertificate::certify(const LocalModel& model) const {
  Certificate out{hz_, {}, 0};
  for (std::size_t f = 0; f < hz_.size(); ++f) {
    const bool has_answer =
        std::ranges::all_of(compliance_[f], [](const ComplexMat3& c) { return c.allFinite() && c.norm() > 0; });
    double worst = has_answer ? 0 : std::numeric_limits<double>::quiet_NaN();
    const std::vector<ComplexMat3> of_model = compliances(model, vertices_, hz_[f]);
    for (std::size_t v = 0; has_answer && v < vertices_.size(); ++v)
      if (const double e = impedance_error(of_model[v], compliance_[f][v]); !(e <= worst))
        worst = std::isfinite(e) ? e : std::numeric_limits<double>::infinity();
    out.error.push_back(worst);
  }
  out.worst = worst_of(out.error);
  return out;
}

namespace {

using Rows = NodeRows<6>;  // real parts of three motions, then their imaginary parts

/// K - w^2 M + i w D of real motions: its real and imaginary parts.
struct Image {
  Image(const NodeBlocks& blocks, double w, const Rows& u) {
    Rows inertia;
    blocks.mass<6>(u, inertia);
    blocks.stiffness_and_damping<6>(u, real, imaginary);
    real -= w * w * inertia;
    imaginary *= w;
  }
  Rows real, imaginary;
};

/// The image of three complex motions.
Rows complex_image(const Image& parts) {
  Rows out(parts.real.rows(), 6);
  out.leftCols<3>() = parts.real.leftCols<3>() - parts.imaginary.rightCols<3>();
  out.rightCols<3>() = parts.real.rightCols<3>() + parts.imaginary.leftCols<3>();
  return out;
}

ComplexMatrix as_complex(const MatrixX& real, const MatrixX& imaginary) {
  ComplexMatrix out(real.rows(), real.cols());
  out.real() = real;
  out.imag() = imaginary;
  return out;
}

ComplexMatrix as_complex(const MatrixX& parts) { return as_complex(parts.leftCols(3), parts.rightCols(3)); }

/// K - w^2 M + i w D of a local model, in factors.
class OwnDynamic {
 public:
  OwnDynamic(const LocalModel& model, double w) {
    const MatrixX real = MatrixX(model.stiffness) - w * w * MatrixX(model.mass), imaginary = w * MatrixX(model.damping);
    if (real == real.transpose() && imaginary == imaginary.transpose())
      symmetric_.emplace(real, imaginary);
    else  // of nodes as they are: what turns with a damper is still there
      any_.emplace(as_complex(real, imaginary));
  }
  ComplexMatrix solve(const ComplexMatrix& b) const { return symmetric_ ? symmetric_->solve(b) : any_->solve(b); }

 private:
  std::optional<ComplexSymmetric> symmetric_;
  std::optional<ComplexLu> any_;
};

/// How the coordinates of a local model move the free nodes of the whole body, and the transpose.
class WholeMotion {
 public:
  WholeMotion(const GradedBody& graded, const LocalModel& model)
      : graded_(graded), model_(model), made_there_(model.reducer == "krylov" || model.reducer == "condensed") {
    const bool known =
        made_there_ ? graded.motions().of_dof(model.dof()) : model.reducer == "wall" || model.reducer == "full";
    if (!known) throw RunError("certificate: the motions of this local model are not known");
  }
  Rows expand(const Rows& q) const {
    const auto& m = graded_.motions();
    if (made_there_) return graded_.expand<6>(m.V * (m.combination * q));
    const MatrixX recovered = model_.basis * q;
    Rows out = Rows::Zero(graded_.all_dofs().size(), 6);
    for_each_free([&](Eigen::Index i, int k) { out.middleRows<3>(k) = recovered.middleRows<3>(3 * i); });
    return out;
  }
  MatrixX contract(const Rows& forces) const {
    const auto& m = graded_.motions();
    if (made_there_) return m.combination.transpose() * (m.V.transpose() * graded_.contract<6>(forces));
    MatrixX recovered = MatrixX::Zero(model_.basis.rows(), 6);
    for_each_free([&](Eigen::Index i, int k) { recovered.middleRows<3>(3 * i) = forces.middleRows<3>(k); });
    return model_.basis.transpose() * recovered;
  }

 private:
  template <class Visit>
  void for_each_free(const Visit& visit) const {
    for (std::size_t i = 0; i < model_.recovered_node.size(); ++i)
      if (const int k = graded_.all_dofs().to_free[3 * model_.recovered_node[i]]; k >= 0)
        visit(static_cast<Eigen::Index>(i), k);
  }
  const GradedBody& graded_;
  const LocalModel& model_;
  bool made_there_;
};

/// (Z^T r)^T (Z^T A Z - (V^T A Z)^T (V^T A V)^-1 V^T A Z)^-1 (Z^T r): r^T A^-1 r where A is confined to the motions Z
/// and the model's own, V, to which r is orthogonal.
class Enrichment {
 public:
  /// Six real motions more.
  void add(const Rows& z, const Image& image, const MatrixX& own_real, const MatrixX& own_imaginary,
           const Rows& residual) {
    const Eigen::Index n = Z_.cols(), m = n + 6;
    Z_.conservativeResize(z.rows(), m);
    Z_.rightCols(6) = z;
    A_.conservativeResize(m, m);
    A_.rightCols(6) = as_complex(Z_.transpose() * image.real, Z_.transpose() * image.imaginary);
    A_.bottomLeftCorner(6, n) = A_.topRightCorner(n, 6).transpose();
    own_.conservativeResize(own_real.rows(), m);
    own_.rightCols(6) = as_complex(own_real, own_imaginary);
    load_.conservativeResize(m, 3);
    load_.bottomRows(6) = as_complex(MatrixX(z.transpose() * residual));
  }
  ComplexMat3 compliance(const OwnDynamic& own_dynamic) const {
    const ComplexMatrix rest = A_ - own_.transpose() * own_dynamic.solve(own_);
    // Motions of one direction and its imaginary part may coincide: least squares of full rank.
    return load_.transpose() * solve_least_squares(rest, load_);
  }
  /// Coefficients of the motions without the model's own.
  ComplexMatrix coefficients() const { return solve_least_squares(A_, load_); }

 private:
  MatrixX Z_;
  ComplexMatrix A_, own_, load_;
};

/// At a vertex.
struct Compliances {
  ComplexMat3 model, body;
};

/// What all vertices share at one frequency: the model's dynamic stiffness in factors, and the preconditioner.
class Estimator {
 public:
  /// Throws IndefiniteTangent.
  Estimator(const GradedBody& graded, const LocalModel& model, double hz)
      : graded_(graded),
        model_(model),
        w_(2 * std::numbers::pi * hz),
        motion_(graded, model),
        own_dynamic_(model, w_),
        precondition_(graded, w_) {}

  Compliances at(int vertex, int steps) const {
    const MatrixX inputs = MatrixX(model_.basis.middleRows(3 * vertex, 3)).transpose();
    const ComplexMatrix q = own_dynamic_.solve(inputs.cast<Complex>());
    Rows coordinates(q.rows(), 6);
    coordinates << q.real(), q.imag();

    Rows residual = -complex_image(Image(graded_.blocks(), w_, motion_.expand(coordinates)));
    const int row = graded_.all_dofs().to_free[3 * model_.patch.global_node[vertex]];
    for (int c = 0; c < 3; ++c) residual(row + c, c) += 1;
    const Rows first = residual;
    Enrichment enrichment;
    std::vector<Image> images;
    for (int step = 0; step < steps; ++step) {
      if (step > 0) residual = rest_of(first, enrichment.coefficients(), images);
      const Rows z = precondition_.apply(residual);
      images.emplace_back(graded_.blocks(), w_, z);
      enrichment.add(z, images.back(), motion_.contract(images.back().real), motion_.contract(images.back().imaginary),
                     first);
    }
    const ComplexMat3 of_model = inputs.transpose() * q;
    return {of_model, of_model + enrichment.compliance(own_dynamic_)};
  }

 private:
  /// Of the first residual without the images' part.
  static Rows rest_of(Rows residual, const ComplexMatrix& y, const std::vector<Image>& images) {
    for (std::size_t k = 0; k < images.size(); ++k) {
      const MatrixX re = y.middleRows(6 * static_cast<Eigen::Index>(k), 6).real();
      const MatrixX im = y.middleRows(6 * static_cast<Eigen::Index>(k), 6).imag();
      residual.leftCols<3>() -= images[k].real * re - images[k].imaginary * im;
      residual.rightCols<3>() -= images[k].real * im + images[k].imaginary * re;
    }
    return residual;
  }
  const GradedBody& graded_;
  const LocalModel& model_;
  double w_;
  WholeMotion motion_;
  OwnDynamic own_dynamic_;
  GradedBody::Preconditioner precondition_;
};

}  // namespace

double estimate_error(const GradedBody& graded, const LocalModel& model, int vertex, double hz, int steps) {
  const Compliances found = Estimator(graded, model, hz).at(vertex, steps);
  return impedance_error(found.model, found.body);
}

BodyCertificate::BodyCertificate(const GradedBody& graded, const LocalModel& best, std::vector<int> vertices,
                                 std::span<const double> hz)
    : vertices_(std::move(vertices)), hz_(hz.begin(), hz.end()) {
  for (double f : hz_) {
    compliance_.emplace_back();
    if (vertices_.empty()) continue;  // all is clamped
    const Estimator estimator(graded, best, f);
    for (int v : vertices_) compliance_.back().push_back(estimator.at(v, kSetUpSteps).body);
  }
}

RunningCertificate::RunningCertificate(std::vector<double> hz) {
  latest_.error.assign(hz.size(), std::numeric_limits<double>::quiet_NaN());
  latest_.hz = std::move(hz);
}

const Certificate& RunningCertificate::sample(const GradedBody& graded, const LocalModel& model,
                                              const ContactSite& site) {
  const Stage stage("certify");
  const std::vector<int> vertices = certified_vertices(model, site);
  if (vertices.empty() || latest_.hz.empty()) return latest_;
  const std::size_t f = calls_ % latest_.hz.size(), v = calls_ / latest_.hz.size() % vertices.size();
  try {
    latest_.error[f] = estimate_error(graded, model, vertices[v], latest_.hz[f]);
  } catch (const IndefiniteTangent&) {  // of a body that is giving way: no reason to stop a hand
    latest_.error[f] = std::numeric_limits<double>::quiet_NaN();
  }
  latest_.worst = worst_of(latest_.error);
  ++calls_;
  return latest_;
}

}  // namespace kt
