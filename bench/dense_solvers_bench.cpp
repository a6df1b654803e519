// Our own dense solvers against Eigen's and LAPACK's, on matrices as a refresh has them: all eigenpairs of a symmetric
// matrix, and a complex symmetric system with forty right-hand sides. docs/architecture.md#dense-solvers.
#include <benchmark/benchmark.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <complex>
#include <vector>

#include "core/base/parallel.hpp"
#include "core/linear/dense/complex_symmetric.hpp"
#include "core/linear/dense/symmetric_eigen.hpp"

extern "C" {
void dsyevd_(const char* job, const char* part, const int* n, double* a, const int* lda, double* w, double* work,
             const int* lwork, int* iwork, const int* liwork, int* info);
void zsysv_(const char* part, const int* n, const int* columns, std::complex<double>* a, const int* lda, int* pivots,
            std::complex<double>* b, const int* ldb, std::complex<double>* work, const int* lwork, int* info);
}

namespace {

using namespace kt;
using Complex = std::complex<double>;

constexpr int kColumns = 40;

/// Positive definite, of numbers that are the same in every run.
MatrixX definite(int n) {
  MatrixX a(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) a(i, j) = std::sin(0.7 * i * j + 0.3 * i - 0.2 * j);
  return a * a.transpose() / n + MatrixX::Identity(n, n);
}

void eigen_ours(benchmark::State& state) {
  const MatrixX a = definite(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(symmetric_eigen(a));
}
void eigen_eigen(benchmark::State& state) {
  const MatrixX a = definite(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(Eigen::SelfAdjointEigenSolver<MatrixX>(a).eigenvectors().eval());
}
void eigen_lapack(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const MatrixX a = definite(n);
  int lwork = 1 + 6 * n + 2 * n * n, liwork = 3 + 5 * n, info = 0;
  std::vector<double> work(static_cast<std::size_t>(lwork));
  std::vector<int> iwork(static_cast<std::size_t>(liwork));
  for (auto _ : state) {
    MatrixX vectors = a;
    VectorX values(n);
    dsyevd_("V", "L", &n, vectors.data(), &n, values.data(), work.data(), &lwork, iwork.data(), &liwork, &info);
    benchmark::DoNotOptimize(vectors);
  }
}

void complex_ours(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const MatrixX real = definite(n) - 3 * MatrixX::Identity(n, n), imaginary = 0.1 * definite(n);
  const Eigen::MatrixXcd b = Eigen::MatrixXcd::Constant(n, kColumns, Complex(1, 0.5));
  for (auto _ : state) benchmark::DoNotOptimize(ComplexSymmetric(real, imaginary).solve(b));
}
void complex_eigen(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const MatrixX real = definite(n) - 3 * MatrixX::Identity(n, n), imaginary = 0.1 * definite(n);
  const Eigen::MatrixXcd b = Eigen::MatrixXcd::Constant(n, kColumns, Complex(1, 0.5));
  for (auto _ : state) {
    const Eigen::MatrixXcd a = real.cast<Complex>() + Complex(0, 1) * imaginary.cast<Complex>();
    benchmark::DoNotOptimize(Eigen::PartialPivLU<Eigen::MatrixXcd>(a).solve(b).eval());
  }
}
void complex_lapack(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0)), lwork = 64 * n;
  const MatrixX real = definite(n) - 3 * MatrixX::Identity(n, n), imaginary = 0.1 * definite(n);
  std::vector<int> pivots(static_cast<std::size_t>(n));
  std::vector<Complex> work(static_cast<std::size_t>(lwork));
  int info = 0;
  for (auto _ : state) {
    Eigen::MatrixXcd a = real.cast<Complex>() + Complex(0, 1) * imaginary.cast<Complex>();
    Eigen::MatrixXcd b = Eigen::MatrixXcd::Constant(n, kColumns, Complex(1, 0.5));
    zsysv_("L", &n, &kColumns, a.data(), &n, pivots.data(), b.data(), &n, work.data(), &lwork, &info);
    benchmark::DoNotOptimize(b);
  }
}

BENCHMARK(eigen_ours)->Arg(60)->Arg(120)->Arg(240)->Arg(480);
BENCHMARK(eigen_eigen)->Arg(60)->Arg(120)->Arg(240)->Arg(480);
BENCHMARK(eigen_lapack)->Arg(60)->Arg(120)->Arg(240)->Arg(480);
BENCHMARK(complex_ours)->Arg(60)->Arg(120)->Arg(240)->Arg(480);
BENCHMARK(complex_eigen)->Arg(60)->Arg(120)->Arg(240)->Arg(480);
BENCHMARK(complex_lapack)->Arg(60)->Arg(120)->Arg(240)->Arg(480);

}  // namespace
