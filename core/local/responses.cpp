#include "core/local/responses.hpp"

#include <Eigen/Cholesky>
#include <numbers>

#include "core/base/error.hpp"
#include "core/base/stages.hpp"
#include "core/linear/sparse_product.hpp"
#include "core/local/far_motions.hpp"

namespace kt {
namespace {

constexpr double kAnswered = 1e-3;  // [-] of a load: a good factor leaves a millionth of it

SparseMatrix symmetric_part(const SparseMatrix& m) { return 0.5 * (m + SparseMatrix(m.transpose())); }

}  // namespace

FreeBody::FreeBody(const TangentModel& tangent)
    : dofs(make_free_dofs(static_cast<int>(tangent.f0.size()) / 3, tangent.fixed_nodes)),
      mass(gather(dofs, tangent.mass)),
      damping(-symmetric_part(gather(dofs, tangent.dfdv))),
      stiffness(-symmetric_part(gather(dofs, tangent.dfdx))),
      force(gather(dofs, VectorX(tangent.f0 - tangent.dfdv * tangent.state.v))),
      velocity(gather(dofs, tangent.state.v)),
      x(tangent.state.x) {}

MatrixX FreeBody::inputs(const SurfacePatch& patch, bool with_rim) const {
  std::vector<int> entries;
  for (const bool in_reach : {true, false})
    for (int i = 0; i < patch.num_vertices(); ++i)
      for (int c = 0; (in_reach || with_rim) && static_cast<bool>(patch.in_reach[i]) == in_reach && c < 3; ++c)
        if (const int k = dofs.to_free[3 * patch.global_node[i] + c]; k >= 0) entries.push_back(k);
  MatrixX out = MatrixX::Zero(force.size(), static_cast<Eigen::Index>(entries.size()));
  for (std::size_t j = 0; j < entries.size(); ++j) out(entries[j], static_cast<Eigen::Index>(j)) = 1;
  return out;
}

SparseMatrix dynamic_stiffness(const FreeBody& body, double s) {
  const SparseMatrix &m = body.mass, &d = body.damping, &k = body.stiffness;
  if (s == 0) return k;
  const auto same_pattern = [&](const SparseMatrix& o) {
    return o.nonZeros() == k.nonZeros() &&
           std::equal(o.innerIndexPtr(), o.innerIndexPtr() + o.nonZeros(), k.innerIndexPtr()) &&
           std::equal(o.outerIndexPtr(), o.outerIndexPtr() + o.cols() + 1, k.outerIndexPtr());
  };
  if (!same_pattern(m) || !same_pattern(d)) return s * s * m + s * d + k;
  SparseMatrix out = k;
  for (Eigen::Index i = 0; i < out.nonZeros(); ++i) out.valuePtr()[i] += s * s * m.valuePtr()[i] + s * d.valuePtr()[i];
  return out;
}

namespace {

/// False: some motion meets no resistance, and rounding alone made the factorization pass.
bool answers(const FreeBody& body, const SparseSolver& solver) {
  const VectorX load = VectorX::Ones(body.stiffness.rows());
  return (body.stiffness * solver.solve(load) - load).norm() <= kAnswered * load.norm();
}

/// K + damping D + mass M.
struct DynamicStiffness {
  double mass = 0, damping = 0;
};

/// What was factored in the end.
DynamicStiffness factor_at(const FreeBody& body, double hz, SparseSolver& solver) {
  // Of a free body: high enough that its swimming does not outweigh, and so hide, how it yields under the tool.
  const Stage stage("factor");
  const double s = 2 * std::numbers::pi * hz, s_free = 2 * std::numbers::pi * 20;
  DynamicStiffness out{s * s, s};
  bool good = solver.factor(dynamic_stiffness(body, s)) && (s > 0 || answers(body, solver));
  if (!good && s == 0) {
    good = solver.factor(SparseMatrix(s_free * s_free * body.mass + body.stiffness));
    out = {s_free * s_free, 0};
  }
  // A body that gives way to some motion does not at a higher rate; the basis need not be exact at this one.
  for (double higher : {5.0, 15.0, 45.0})
    if (!good && higher > hz) {
      const double s_higher = 2 * std::numbers::pi * higher;
      good = solver.factor(dynamic_stiffness(body, s_higher));
      out = {s_higher * s_higher, s_higher};
    }
  if (!good) throw IndefiniteTangent("reducer: the body's stiffness is not positive definite");
  return out;
}

/// Unit forces on some coordinates, then loads on others.
struct Loads {
  std::vector<Eigen::Index> units;
  std::vector<Eigen::Index> rows;  // of the others, which are zero elsewhere
  RowMatrix others;                // (rows x others)
  Eigen::Index cols() const { return static_cast<Eigen::Index>(units.size()) + others.cols(); }
  /// @param out  (free x cols()), zero
  void write_to(RowsRef out) const {
    for (std::size_t k = 0; k < units.size(); ++k) out(units[k], static_cast<Eigen::Index>(k)) = 1;
    for (std::size_t k = 0; k < rows.size(); ++k)
      out.row(rows[k]).tail(others.cols()) = others.row(static_cast<Eigen::Index>(k));
  }
  /// X^T loads.
  MatrixX work_in(const RowMatrix& X) const {
    MatrixX out(X.cols(), cols());
    for (std::size_t k = 0; k < units.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = X.row(units[k]);
    if (others.cols() > 0) out.rightCols(others.cols()) = MatrixX(X(rows, Eigen::all)).transpose() * others;
    return out;
  }
};

/// What is solved at one shift, columns of the answers from `first` on: (K + d D + m M) [of_loads, of_force, slopes] =
/// [loads, force, M or 2 s M + D times of_loads share].
struct ShiftAnswers {
  double s = 0;
  DynamicStiffness solved;
  Loads loads;
  RowMatrix share;  // smooth loads whose slopes are asked for, in terms of these
  Eigen::Index first = 0;
  Eigen::Index first_slope() const { return first + loads.cols() + 1; }
};

/// Columns: those of each shift; the velocity; echoes, three each, each the answer to the mass times the one before.
struct Answers {
  RowMatrix X;
  std::vector<ShiftAnswers> shifts;
  RowMatrix resultant;  // even forces on the patch in terms of the loads at the first shift
  int echoes = 0;
  Eigen::Index first_echo() const { return X.cols() - 3 * echoes; }
};

/// The patch's smooth loads, those on its rim alone, and the coordinates of nodes in reach and on the rim.
struct PatchLoads {
  PatchLoads(const FreeBody& body, const SurfacePatch& patch) : smooth(smooth_loads(body.dofs, body.x, patch)) {
    for (int i = 0; i < patch.num_vertices(); ++i)
      for (int c = 0; c < 3; ++c)
        if (const int k = body.dofs.to_free[3 * patch.global_node[i] + c]; k >= 0)
          (patch.in_reach[static_cast<std::size_t>(i)] ? in_reach : rim).push_back(k);
  }
  /// Each node in reach by itself. The rim, at the first shift only, by smooth loads: a tool that runs onto it must
  /// find it no stiffer, but is about to leave.
  Loads outer(bool with_rim) const {
    if (!with_rim || rim.empty()) return {in_reach, {}, RowMatrix(0, 0)};
    return {in_reach, rim, smooth(rim, Eigen::all)};
  }
  /// The smooth loads in terms of outer(): of what is not pushed at, nothing.
  RowMatrix share(bool with_rim) const {
    const auto units = static_cast<Eigen::Index>(in_reach.size());
    RowMatrix out = RowMatrix::Zero(units + (with_rim && !rim.empty() ? kFarEach : 0), kFarEach);
    out.topRows(units) = smooth(in_reach, Eigen::all);
    out.bottomRows(out.rows() - units).setIdentity();
    return out;
  }
  /// Even forces on the whole patch in terms of outer(true).
  RowMatrix resultant() const {
    RowMatrix out = share(true).leftCols(3);
    return out;
  }
  Loads inner() const {
    std::vector<Eigen::Index> all = in_reach;
    all.insert(all.end(), rim.begin(), rim.end());
    return {{}, all, smooth(all, Eigen::all)};
  }
  FarRows smooth;
  std::vector<Eigen::Index> in_reach, rim;
};

/// Which columns there will be.
Answers plan_answers(const FreeBody& body, const PatchLoads& loads, const std::vector<double>& shifts, int echoes,
                     bool slopes) {
  Answers out;
  out.shifts.resize(shifts.size());
  out.resultant = loads.resultant();
  out.echoes = echoes;
  Eigen::Index columns = 0;
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    ShiftAnswers& a = out.shifts[i];
    const bool outer = i == 0 || i + 1 == shifts.size();
    a.s = 2 * std::numbers::pi * shifts[i];
    a.loads = outer ? loads.outer(i == 0) : loads.inner();
    a.first = columns;
    // What smooth loads move: a combination of what the nodes' loads do, which are columns of the identity.
    if (slopes) a.share = outer ? loads.share(i == 0) : RowMatrix::Identity(kFarEach, kFarEach);
    // At rest the slopes of the even forces are the first echo.
    if (slopes && i == 0 && a.s == 0 && echoes > 0) a.share = a.share.rightCols(kFarEach - 3).eval();
    columns = a.first_slope() + a.share.cols();
  }
  out.X = RowMatrix::Zero(body.force.size(), columns + 1 + 3 * echoes);
  out.X.col(columns) = body.velocity;
  return out;
}

/// The columns of one shift: answers to its loads, then their slopes; at the first, echoes.
void answer_at(ShiftAnswers& a, bool with_echoes, const FreeBody& body, const SymmetricMatrix& mass,
               const SymmetricMatrix& damping, const SparseSolver& solver, Answers& out) {
  RowMatrix& X = out.X;
  const Eigen::Index loads = a.loads.cols(), slopes = a.share.cols();
  a.loads.write_to(X.middleCols(a.first, loads));
  X.col(a.first + loads) = body.force;
  {
    const Stage stage("solve");
    solver.solve_in_place(X.middleCols(a.first, loads + 1));
  }
  const auto moved = [&](const RowMatrix& share) { return tall_product(X.middleCols(a.first, loads), share); };
  const int echoes = with_echoes ? out.echoes : 0;
  RowMatrix next(X.rows(), slopes + (echoes > 0 ? 3 : 0));
  if (slopes > 0) {
    const RowMatrix of_loads = moved(a.share);
    RowMatrix slope = mass.times(of_loads);
    if (a.s > 0) slope = 2 * a.s * slope + damping.times(of_loads);
    next.leftCols(slopes) = slope;
  }
  if (echoes > 0) next.rightCols(3) = mass.times(moved(out.resultant));
  if (next.cols() == 0) return;
  solver.solve_in_place(next);
  if (slopes > 0) X.middleCols(a.first_slope(), slopes) = next.leftCols(slopes);
  for (int e = 0; e < echoes; ++e) {
    RowMatrix echo =
        e == 0 ? RowMatrix(next.rightCols(3)) : mass.times(RowMatrix(X.middleCols(out.first_echo() + 3 * (e - 1), 3)));
    if (e > 0) solver.solve_in_place(echo);
    X.middleCols(out.first_echo() + 3 * e, 3) = echo;
  }
}

Answers answer(const FreeBody& body, const SymmetricMatrix& mass, const SymmetricMatrix& damping,
               const SurfacePatch& patch, const std::vector<double>& shifts, SparseSolver& solver, int echoes,
               bool slopes) {
  Answers out = plan_answers(body, PatchLoads(body, patch), shifts, echoes, slopes);
  // Downwards: the factor that is left behind, at rest, serves for the certificate.
  for (std::size_t i = shifts.size(); i-- > 0;) {
    out.shifts[i].solved = factor_at(body, shifts[i], solver);
    answer_at(out.shifts[i], i == 0, body, mass, damping, solver, out);
  }
  return out;
}

}  // namespace

MatrixX responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts,
                  SparseSolver& solver, int echoes, bool slopes) {
  return answer(body, SymmetricMatrix(body.mass), SymmetricMatrix(body.damping), patch, shifts, solver, echoes, slopes)
      .X;
}

namespace {

/// X^T K X from what was solved: X^T K x = X^T load - d X^T D x - m X^T M x.
MatrixX confined_stiffness(const Answers& answers, const FreeBody& body, const ConfinedMotions& of) {
  const MatrixX &M = of.mass, &D = of.damping;
  MatrixX out(M.rows(), M.cols());
  Eigen::Index column = 0;
  const auto put = [&](const MatrixX& work, const DynamicStiffness& solved) {
    const Eigen::Index k = work.cols();
    out.middleCols(column, k) = work - solved.damping * D.middleCols(column, k) - solved.mass * M.middleCols(column, k);
    column += k;
  };
  const VectorX work_of_force = of.X.transpose() * body.force;
  for (const ShiftAnswers& a : answers.shifts) {
    put(a.loads.work_in(of.X), a.solved);
    put(work_of_force, a.solved);
    if (a.share.cols() == 0) continue;  // slopes that nobody asked for
    const auto seen_by = [&](const MatrixX& matrix) {
      return tall_product(RowMatrix(matrix.middleCols(a.first, a.loads.cols())), a.share);
    };
    put(a.s > 0 ? MatrixX(2 * a.s * seen_by(M) + seen_by(D)) : MatrixX(seen_by(M)), a.solved);
  }
  put(of.X.transpose() * VectorX(body.stiffness * body.velocity), {});
  for (int e = 0; e < answers.echoes; ++e)
    put(e == 0 ? MatrixX(M.leftCols(answers.resultant.rows()) * answers.resultant)
               : MatrixX(M.middleCols(column - 3, 3)),
        answers.shifts.front().solved);
  return 0.5 * (out + out.transpose());
}

}  // namespace

ConfinedMotions confined_responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts,
                                   SparseSolver& solver, int echoes, bool slopes) {
  const SymmetricMatrix mass(body.mass), damping(body.damping);
  Answers answers = answer(body, mass, damping, patch, shifts, solver, echoes, slopes);
  const Stage stage("products");
  ConfinedMotions out{std::move(answers.X), {}, {}, {}};
  const ColumnGroups X(out.X);
  out.mass = symmetric_product(X, mass.times(X));
  out.damping = symmetric_product(X, damping.times(X));
  out.stiffness = confined_stiffness(answers, body, out);
  return out;
}

MatrixX responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts) {
  return responses(body, patch, shifts, *make_sparse_solver(), 0, false);
}

}  // namespace kt
