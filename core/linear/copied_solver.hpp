#pragma once
// A sparse solver as a value: for bodies that are kept as they are while one goes on from them.
#include <utility>

#include "core/linear/sparse_solver.hpp"

namespace kt {

/// What a solver is that can be copied: all of make_sparse_solver() and make_block_solver().
class CopiedSolver {
 public:
  virtual ~CopiedSolver() = default;
  /// With the same analysis and the same factor: it goes on to the same bits.
  virtual std::unique_ptr<SparseSolver> copy() const = 0;
};

inline std::unique_ptr<SparseSolver> copy_of(const SparseSolver& solver) {
  return dynamic_cast<const CopiedSolver&>(solver).copy();
}

class SolverValue {
 public:
  SolverValue(std::unique_ptr<SparseSolver> solver) : solver_(std::move(solver)) {}
  SolverValue(const SolverValue& other) : solver_(copy_of(*other.solver_)) {}
  SolverValue(SolverValue&&) noexcept = default;
  SolverValue& operator=(SolverValue other) noexcept {
    solver_ = std::move(other.solver_);
    return *this;
  }
  ~SolverValue() = default;
  SparseSolver* operator->() const { return solver_.get(); }
  SparseSolver& operator*() const { return *solver_; }

 private:
  std::unique_ptr<SparseSolver> solver_;
};

}  // namespace kt
