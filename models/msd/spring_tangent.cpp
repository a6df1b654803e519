#include "models/msd/spring_tangent.hpp"

#include "core/base/parallel.hpp"
#include "core/base/wide.hpp"

namespace kt {
namespace {

typedef double Four __attribute__((vector_size(32)));

/// A spring's blocks are  along u u^T + across I + u turn^T  and  damper u u^T.
struct SpringNumbers {
  double u[4] = {}, turn[4] = {};  // the fourth zero
  double along = 0, across = 0, damper = 0;
};

struct Columns {
  const int *begin, *spring_of, *diagonal;
  const SpringNumbers* springs;
};

/// A block's column is three numbers: written as four, of which the next block then overwrites the last.
KT_WIDE void write_columns(const Columns& columns, int first, int last, double* dfdx, double* dfdv) {
  constexpr double kUnit[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
  for (int j = first; j < last; ++j) {
    const int from = columns.begin[j], count = columns.begin[j + 1] - from;
    for (int c = 0; c < 3; ++c) {
      double* x = dfdx + static_cast<std::ptrdiff_t>(9) * from + static_cast<std::ptrdiff_t>(3) * c * count;
      double* v = dfdv + static_cast<std::ptrdiff_t>(9) * from + static_cast<std::ptrdiff_t>(3) * c * count;
      Four unit, x_sum = {}, v_sum = {};
      __builtin_memcpy(&unit, kUnit[c], sizeof unit);
      for (int k = 0; k < count; ++k) {
        const SpringNumbers& s = columns.springs[columns.spring_of[from + k]];
        Four u;
        __builtin_memcpy(&u, s.u, sizeof u);
        const Four along = u * s.u[c];  // symmetric to the last bit
        const Four of_x = s.along * along + u * s.turn[c] + s.across * unit, of_v = s.damper * along;
        x_sum += of_x;
        v_sum += of_v;
        if (k + 1 < count) {
          __builtin_memcpy(x + 3 * k, &of_x, sizeof of_x);
          __builtin_memcpy(v + 3 * k, &of_v, sizeof of_v);
        } else {
          __builtin_memcpy(x + 3 * k, &of_x, 3 * sizeof(double));
          __builtin_memcpy(v + 3 * k, &of_v, 3 * sizeof(double));
        }
      }
      const int own = 3 * columns.diagonal[j];
      for (int r = 0; r < 3; ++r) {
        x[own + r] = -x_sum[r];
        v[own + r] = -v_sum[r];
      }
    }
  }
}

SpringNumbers numbers_of(const Spring& s, const State& state, TangentKind kind) {
  const Stretch now = stretch(s, state);
  const double tension = s.stiffness * (1 - s.rest_length / now.length);  // per length: the geometric stiffness
  SpringNumbers out;
  out.across = kind == TangentKind::definite ? std::max(0.0, tension) : tension;
  if (kind != TangentKind::definite) {
    const double turning = s.damper / now.length;
    out.across += turning * now.rate;
    Vec3::Map(out.turn) = turning * (now.velocity - now.rate * now.direction);
  }
  out.along = s.stiffness - out.across;
  out.damper = s.damper;
  Vec3::Map(out.u) = now.direction;
  return out;
}

}  // namespace

SpringTangent::SpringTangent(int num_nodes, const std::vector<Spring>& springs) {
  std::vector<std::vector<std::pair<int, int>>> around(static_cast<std::size_t>(num_nodes));  // node, spring
  for (int i = 0; i < num_nodes; ++i) around[i].emplace_back(i, static_cast<int>(springs.size()));
  for (int s = 0; s < static_cast<int>(springs.size()); ++s) {
    around[springs[s].a].emplace_back(springs[s].b, s);
    around[springs[s].b].emplace_back(springs[s].a, s);
  }
  begin_.assign(1, 0);
  std::vector<int> outer{0}, inner;
  for (int j = 0; j < num_nodes; ++j) {
    std::sort(around[j].begin(), around[j].end());
    for (std::size_t k = 0; k < around[j].size(); ++k) {
      if (around[j][k].first == j) diagonal_.push_back(static_cast<int>(k));
      spring_of_.push_back(around[j][k].second);
    }
    begin_.push_back(static_cast<int>(spring_of_.size()));
    for (int c = 0; c < 3; ++c) {
      for (const auto& [i, spring] : around[j]) inner.insert(inner.end(), {3 * i, 3 * i + 1, 3 * i + 2});
      outer.push_back(static_cast<int>(inner.size()));
    }
  }
  const std::vector<double> zeros(inner.size(), 0.0);
  pattern_ = Eigen::Map<const SparseMatrix>(3 * num_nodes, 3 * num_nodes, static_cast<Eigen::Index>(inner.size()),
                                            outer.data(), inner.data(), zeros.data());
}

void SpringTangent::update(const std::vector<Spring>& springs, const State& state, TangentKind kind,
                           Tangent& out) const {
  for (SparseMatrix* matrix : {&out.dfdx, &out.dfdv})
    if (matrix->rows() != pattern_.rows() || matrix->nonZeros() != pattern_.nonZeros() || !matrix->isCompressed())
      *matrix = pattern_;
  thread_local std::vector<SpringNumbers> room;  // as large each time
  std::vector<SpringNumbers>& numbers = room;    // the calling thread's, in all
  numbers.resize(springs.size() + 1);
  numbers.back() = {};
  constexpr int kChunk = 4096;  // springs or nodes a task
  const int count = static_cast<int>(springs.size()), nodes = static_cast<int>(diagonal_.size());
  parallel_for((count + kChunk - 1) / kChunk, [&](int i) {
    for (int s = i * kChunk; s < std::min(count, (i + 1) * kChunk); ++s)
      numbers[s] = numbers_of(springs[s], state, kind);
  });
  const Columns columns{begin_.data(), spring_of_.data(), diagonal_.data(), numbers.data()};
  parallel_for((nodes + kChunk - 1) / kChunk, [&](int i) {
    write_columns(columns, i * kChunk, std::min(nodes, (i + 1) * kChunk), out.dfdx.valuePtr(), out.dfdv.valuePtr());
  });
}

}  // namespace kt
