// Stable neo-Hookean flesh: Smith, de Goes, Kim, "Stable Neo-Hookean Flesh Simulation", ACM TOG 37(2), 2018.
//   energy = mu/2 (I_C - 3) + lambda/2 (J - alpha)^2 - mu/2 log(I_C + 1),    I_C = |F|^2, J = det F
// No logarithm of J and no inverse of F: finite for flat and inverted elements. alpha makes the rest state free of
// stress; mu and lambda are those of the paper's section 3.4, so that small strains agree with Hooke's law.
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <array>
#include <cmath>

#include "models/fem/material.hpp"

namespace kt {
namespace {

class NeoHookean final : public Material {
 public:
  explicit NeoHookean(const Lame& lame)
      : mu_(4.0 / 3.0 * lame.mu), lambda_(lame.lambda + 5.0 / 6.0 * lame.mu), alpha_(1 + 0.75 * mu_ / lambda_) {
    rest_ = density(3, 1);
  }
  double energy(const Mat3& F) const override { return density(F.squaredNorm(), F.determinant()) - rest_; }
  Mat3 stress(const Mat3& F) const override {
    return mu_ * (1 - 1 / (F.squaredNorm() + 1)) * F + lambda_ * (F.determinant() - alpha_) * cofactor(F);
  }
  Mat9 tangent(const Mat3& F) const override {
    const Parts p = parts(F);
    Mat9 out = p.c * cofactor_tangent(F);
    out.diagonal().array() += p.a;
    out += (p.b * flat(F)) * flat(F).transpose() + (lambda_ * flat(p.cofactor)) * flat(p.cofactor).transpose();
    return out;
  }
  /// a (g_a.g_b) I + b (F g_a)(F g_b)^T + lambda (C g_a)(C g_b)^T - c [F (g_a x g_b)]x with C the cofactors and a, b, c
  /// as in Parts. What is indefinite is lifted direction by direction: dP += -e D D^T for each eigenvalue e < 0.
  void add_stiffness(const Mat3& F, bool definite, const Gradients& g, double volume,
                     Eigen::Ref<MatrixX> stiffness) const override {
    const Parts p = parts(F);
    std::array<Lift, 9> lift;
    int lifts = 0;
    if (definite && !is_definite(p, F)) lifts = find_lifts(p, F, lift);
    for (Eigen::Index b = 0; b < g.cols(); ++b) {
      const Vec3 gb = volume * g.col(b);
      const Vec3 fb = p.b * (F * gb), cb = lambda_ * (p.cofactor * gb);
      for (Eigen::Index a = 0; a <= b; ++a) {
        const Vec3 ga = g.col(a);
        Mat3 block = (F * ga) * fb.transpose() + (p.cofactor * ga) * cb.transpose();
        block -= cross_matrix(p.c * (F * ga.cross(gb)));
        block.diagonal().array() += p.a * ga.dot(gb);
        for (int i = 0; i < lifts; ++i)
          block += (lift[i].by * (lift[i].direction * ga)) * (lift[i].direction * gb).transpose();
        stiffness.block<3, 3>(3 * a, 3 * b) += block;
        if (a != b) stiffness.block<3, 3>(3 * b, 3 * a) += block.transpose();
      }
    }
  }

 private:
  /// dP/dF = a I + b F F^T + lambda C C^T + c d2J/dF2, all as vectors of nine.
  struct Parts {
    Mat3 cofactor;
    double J, I, a, b, c;
  };
  Parts parts(const Mat3& F) const {
    Parts p;
    p.cofactor = cofactor(F);
    p.J = F.col(0).dot(p.cofactor.col(0));
    p.I = F.squaredNorm();
    p.a = mu_ * (1 - 1 / (p.I + 1));
    p.b = 2 * mu_ / ((p.I + 1) * (p.I + 1));
    p.c = lambda_ * (p.J - alpha_);
    return p;
  }

  /// In the frame of the principal stretches s the tangent splits (Smith et al., section 4): six eigenvalues a +- c
  /// s_i, none negative when a^2 I - c^2 F^T F has no negative minor; and a 3 x 3 block of the stretches, judged by its
  /// elementary symmetric functions, which are polynomials in the invariants of F.
  bool is_definite(const Parts& p, const Mat3& F) const {
    constexpr double kRoundoff = 1e-12;
    const Mat3 twist = p.a * p.a * (1 + kRoundoff) * Mat3::Identity() - p.c * p.c * (F.transpose() * F);
    if (!(twist(0, 0) >= 0 && twist.topLeftCorner<2, 2>().determinant() >= 0 && twist.determinant() >= 0)) return false;
    const double a = p.a, b = p.b, L = lambda_, k = L * p.J + p.c;  // off the diagonal: b s_i s_j + k s_k
    const double I1 = p.I, I2 = p.cofactor.squaredNorm(), J = p.J, J2 = J * J;
    const double q2 = I1 * I1 - 2 * I2, m2 = I2 * I2 - 2 * I1 * J2;  // sums of s_i^4, of (s_j s_k)^4
    const double e1 = 3 * a + b * I1 + L * I2;
    const double diagonal2 = 3 * a * a + b * b * q2 + L * L * m2 + 2 * a * b * I1 + 2 * a * L * I2 + 6 * b * L * J2;
    const double off2 = b * b * I2 + 6 * b * k * J + k * k * I1;
    const double e2 = 0.5 * (e1 * e1 - diagonal2) - off2;
    const double diagonals = a * a * a + a * a * (b * I1 + L * I2) +
                             a * (b * b * I2 + L * L * I1 * J2 + b * L * (I1 * I2 - 3 * J2)) + b * b * b * J2 +
                             b * b * L * m2 + b * L * L * J2 * q2 + L * L * L * J2 * J2;
    const double offs = J * (b * b * b * J + b * b * k * I1 + k * k * k) + b * k * k * I2;
    const double mixed = a * off2 + b * (3 * b * b * J2 + 2 * b * k * J * I1 + k * k * q2) +
                         L * (b * b * m2 + 2 * b * k * J * I2 + 3 * k * k * J2);
    return e1 >= 0 && e2 >= 0 && diagonals + 2 * offs - mixed >= 0;
  }

  struct Lift {
    double by = 0;   ///< minus the negative eigenvalue
    Mat3 direction;  ///< its eigenvector, of length 1
  };
  int find_lifts(const Parts& p, const Mat3& F, std::array<Lift, 9>& out) const {
    const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Mat3 &U = svd.matrixU(), &V = svd.matrixV();
    // Reflections in U or V cancel in what follows when s_3 takes the sign of J and C is made of s.
    Vec3 s = svd.singularValues();
    const double parity = U.determinant() * V.determinant();
    int count = 0;
    const auto lift = [&](double eigenvalue, const Mat3& inner) {
      if (eigenvalue < 0) out[count++] = {-eigenvalue, U * inner * V.transpose()};
    };
    Mat3 stretch;
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      Mat3 inner = Mat3::Zero();
      inner(i, j) = inner(j, i) = std::sqrt(0.5);
      lift(p.a - p.c * parity * s[k], inner);
      inner(j, i) *= -1;
      lift(p.a + p.c * parity * s[k], inner);
      stretch(k, k) = p.a + p.b * s[k] * s[k] + lambda_ * s[i] * s[i] * s[j] * s[j];
      stretch(i, j) = stretch(j, i) = p.b * s[i] * s[j] + (lambda_ * s[0] * s[1] * s[2] + p.c * parity) * s[k];
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(stretch);
    for (int k = 0; k < 3; ++k) lift(eigen.eigenvalues()[k], eigen.eigenvectors().col(k).asDiagonal());
    return count;
  }

  double density(double I_C, double J) const {
    return 0.5 * (mu_ * (I_C - 3) + lambda_ * (J - alpha_) * (J - alpha_) - mu_ * std::log(I_C + 1));
  }
  double mu_, lambda_, alpha_, rest_;
};

}  // namespace

std::unique_ptr<Material> make_neo_hookean_material(const Lame& lame) { return std::make_unique<NeoHookean>(lame); }

}  // namespace kt
